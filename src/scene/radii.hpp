#pragma once

#include "src/scene/draft.hpp"
#include "src/scene/placing.hpp"

namespace lichtenberg {

/// m, that a conductor of the population can have.
double largest_radius(const PopulationDraft& population);
double smallest_radius(const PopulationDraft& population);

/// The radii of a population, one conductor after the other.
class Radii {
 public:
  /// Throws InputError for keys that do not go together.
  Radii(const Draft& draft, const PopulationDraft& population);

  /// m. Asks for nothing if there is no choice; for one number of a uniform distribution; for two of a normal or a
  /// lognormal one (Box and Muller 1958), again and again until the radius is in the interval. Throws InputError if the
  /// interval has next to nothing of the distribution.
  double next(UniformRandom& random);

 private:
  double truncated_normal(UniformRandom& random) const;

  const Draft& draft_;
  const PopulationDraft& population_;
  std::size_t taken_ = 0;
};

}  // namespace lichtenberg
