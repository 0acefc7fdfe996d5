#pragma once

#include <vector>

#include "src/effects/hertz.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Returns the scene-file keys `young` (Young's modulus, Pa) and `poisson` (Poisson's ratio) of an elastic contact.
/// `Options` is a struct with these members.
template <class Options>
std::vector<Key> elastic_constants() {
  return {
      {.name = "young",
       .target = target<&Options::young>,
       .unit = "Pa",
       .range = ranges::positive,
       .help = "Young's modulus of the material in elastic contacts, in Pa; the default is steel"},
      {.name = "poisson",
       .target = target<&Options::poisson>,
       .range = {.low = -1, .high = 0.5, .low_itself = false},
       .help = "Poisson's ratio of the material in elastic contacts"},
  };
}

/// Returns the elastic constants of each conductor: individual conductors in their order, then those of populations.
/// `common` replaces missing keys. Empty if no conductor and no population has elastic constants of its own.
inline std::vector<Elasticity> materials_of_bodies(const Draft& draft, const Elasticity& common) {
  std::vector<Elasticity> bodies;
  bool any = false;
  const auto add = [&](const auto& given, int count) {
    any = any || given.young || given.poisson;
    bodies.insert(bodies.end(), count, {given.young.value_or(common.young), given.poisson.value_or(common.poisson)});
  };
  for (const ConductorDraft& conductor : draft.conductors) add(conductor, 1);
  for (const PopulationDraft& population : draft.populations) add(population, population.count);
  return any ? bodies : std::vector<Elasticity>{};
}

}  // namespace lichtenberg::effects
