#pragma once

#include "src/scene/draft.hpp"
#include "src/scene/placing.hpp"

namespace lichtenberg {

/// Largest radius (m) that a conductor of the population can have.
double largest_radius(const PopulationDraft& population);
double smallest_radius(const PopulationDraft& population);

/// Radii of the conductors of a population, in their order.
class Radii {
 public:
  /// Checks the keys of the radii. Throws InputError if they contradict each other or one is missing.
  Radii(const Draft& draft, const PopulationDraft& population);

  /// Returns the next radius (m). It draws no random number if there is no choice, one for a uniform distribution, and
  /// two for a normal or lognormal one (Box and Muller 1958). These are redrawn until the radius is in the interval.
  /// Throws InputError if the interval contains too small a part of the distribution.
  double next(UniformRandom& random);

 private:
  double truncated_normal(UniformRandom& random) const;

  const Draft& draft_;
  const PopulationDraft& population_;
  std::size_t taken_ = 0;
};

}  // namespace lichtenberg
