#include "python/module/compiled.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>

#include "solvers/error.hpp"
#include "src/effects/effects.hpp"

namespace lichtenberg::python {

CompiledEffect load_effect(const std::string& path) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw Failure(fmt::format("the compiled effect cannot be loaded ({})", dlerror()));
  using Export = const EffectKind* (*)();
  const auto function = reinterpret_cast<Export>(dlsym(library, "lichtenberg_effect_kind"));
  if (!function)
    throw InputError(
        "the source exports no effect: end it with LICHTENBERG_EFFECT(OPTIONS), where OPTIONS is the struct "
        "of its options, and include \"src/scene/compiled_effect.hpp\"");
  const EffectKind* kind = function();
  if (std::ranges::find(effects::all_kinds(), kind->name, [](const EffectKind* each) { return each->name; }) !=
      effects::all_kinds().end())
    throw InputError(fmt::format("the effect \"{}\" is built in: give the compiled effect another name", kind->name));
  return {kind};
}

}  // namespace lichtenberg::python
