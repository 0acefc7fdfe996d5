#pragma once

#include <memory>
#include <string>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::python {

/// Effect of a library that lichtenberg.compile_effect has made. The library stays loaded until the process ends.
struct CompiledEffect {
  const EffectKind* kind = nullptr;
};

/// Loads a library that exports an effect (src/scene/compiled_effect.hpp). Throws Failure if it cannot be loaded,
/// InputError if it exports no effect or one with the name of a built-in effect.
CompiledEffect load_effect(const std::string& path);

}  // namespace lichtenberg::python
