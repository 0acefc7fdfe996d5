#pragma once

#include <vector>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// The keys of an elastic contact, whose options have `young` (Pa) and `poisson`.
template <class Options>
std::vector<Key> elastic_constants() {
  return {
      {.name = "young",
       .place = place<&Options::young>,
       .unit = "Pa",
       .range = ranges::positive,
       .help = "Young's modulus; the default is steel"},
      {.name = "poisson",
       .place = place<&Options::poisson>,
       .range = {.low = -1, .high = 0.5, .low_itself = false},
       .help = "Poisson's ratio"},
  };
}

}  // namespace lichtenberg::effects
