#include "src/scene/radii.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace lichtenberg {

double largest_radius(const PopulationDraft& population) {
  if (!population.radii.empty()) return std::ranges::max(population.radii);
  return population.radius ? population.radius->largest : 0;
}

double smallest_radius(const PopulationDraft& population) {
  if (!population.radii.empty()) return std::ranges::min(population.radii);
  return population.radius ? population.radius->smallest : 0;
}

Radii::Radii(const Draft& draft, const PopulationDraft& population) : draft_(draft), population_(population) {
  const auto refuse_it = [&](const std::string& why) { refuse(draft.scene.path, population.line, why); };
  const bool uniform = population.distribution == RadiusDistribution::uniform;
  if (!population.radius && population.radii.empty())
    refuse_it("population.radius is missing: [[population]] needs it, or population.radii");
  if (population.radius && !population.radii.empty())
    refuse_it("population.radius and population.radii are both given: only one of them is allowed");
  if (!uniform && !population.radius)
    refuse_it(fmt::format("population.distribution = \"{}\" is not allowed with population.radii: they are given",
                          name_of(population.distribution)));
  if (uniform && (population.mean || population.deviation))
    refuse_it(
        "population.mean and population.deviation belong to population.distribution = \"normal\" or "
        "\"lognormal\": with \"uniform\" they are not allowed");
  if (!uniform && !population.deviation)
    refuse_it(fmt::format("population.deviation is missing: population.distribution = \"{}\" needs it",
                          name_of(population.distribution)));
  if (population.radius && population.radius->smallest > population.radius->largest)
    refuse_it(fmt::format("population.radius = [{:g}, {:g}] is not allowed: the smallest must come first",
                          population.radius->smallest, population.radius->largest));
}

double Radii::next(UniformRandom& random) {
  if (!population_.radii.empty()) return population_.radii[taken_++ % population_.radii.size()];
  const auto [smallest, largest] = *population_.radius;
  if (!(smallest < largest)) return smallest;
  return population_.distribution == RadiusDistribution::uniform ? random.between(smallest, largest)
                                                                 : truncated_normal(random);
}

double Radii::truncated_normal(UniformRandom& random) const {
  const auto [smallest, largest] = *population_.radius;
  const double mean = population_.mean.value_or(0.5 * (smallest + largest)), deviation = *population_.deviation;
  constexpr int most_tries = 100000;
  for (int attempt = 0; attempt < most_tries; ++attempt) {
    const double length = std::sqrt(-2 * std::log1p(-random()));  // log1p(-x) of a number x in [0, 1) is finite
    const double normal = length * std::cos(2 * std::numbers::pi * random());
    const double radius =
        mean * (population_.distribution == RadiusDistribution::normal ? 1 + deviation * normal
                                                                       : std::exp(deviation * normal));
    if (radius >= smallest && radius <= largest) return radius;
  }
  refuse(draft_.scene.path, population_.line,
         fmt::format("population.radius = [{:g}, {:g}] is not allowed: population.mean = {:g} m and "
                     "population.deviation = {:g} put less than a radius in {} there",
                     smallest, largest, mean, deviation, most_tries));
}

}  // namespace lichtenberg
