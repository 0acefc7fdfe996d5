#pragma once

#include <fmt/format.h>

#include <string>

#include "src/scene/draft.hpp"

namespace lichtenberg::effects {

/// Throws InputError unless the vector of a key ("effects.NAME.KEY") has as many numbers as the domain has axes.
inline void check_components(const Draft& draft, const std::string& key, const Coordinates& vector) {
  if (vector.count != draft.domain_size.count)
    refuse(draft.scene.path, draft.line(key),
           fmt::format("{} has {} numbers, but the domain has {}: as many are allowed", key, vector.count,
                       draft.domain_size.count));
}

}  // namespace lichtenberg::effects
