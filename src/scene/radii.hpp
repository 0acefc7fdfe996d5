#pragma once

#include "src/scene/draft.hpp"
#include "src/scene/placing.hpp"

namespace lichtenberg {

/// Returns the largest radius (m) that a conductor of the population can have; 0 if none is given.
double largest_radius(const PopulationDraft& population);
/// Returns the smallest radius (m) that a conductor of the population can have; 0 if none is given.
double smallest_radius(const PopulationDraft& population);

/// Draws the radii of the conductors of a population, one after another.
class Radii {
 public:
  /// Checks the keys of the population's radii. Throws InputError if they contradict each other or one is missing.
  Radii(const Draft& draft, const PopulationDraft& population);

  /// Draws the radius of the next conductor (m). It takes no random number if there is no choice and one for a uniform
  /// distribution. For a normal or lognormal distribution each try takes two (Box and Muller 1958), until the radius is
  /// in the interval. Throws InputError if the interval contains too small a part of the distribution.
  double next(UniformRandom& random);

 private:
  double truncated_normal(UniformRandom& random) const;

  const Draft& draft_;
  const PopulationDraft& population_;
  std::size_t taken_ = 0;
};

}  // namespace lichtenberg
