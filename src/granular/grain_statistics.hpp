#pragma once

#include <span>

#include "solvers/parallel/team.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Sums and maxima over all grains, in reduced units.
struct GrainStatistics {
  double kinetic = 0;  ///< energy
  double fastest = 0;  ///< the largest speed
};

/// Returns them for the present grains, bitwise identical for any number of threads.
GrainStatistics grain_statistics(const Bodies& bodies, parallel::Team& team);

/// Result of a change of momenta by dt (now - before).
struct KickResult {
  double most = 0;        ///< v0, largest change of a velocity
  GrainStatistics after;  ///< bitwise identical to that of `grain_statistics`
};
/// Changes momenta by dt times the difference of two forces ([N * d]).
KickResult kick(Bodies& bodies, double dt, std::span<const double> before, std::span<const double> now,
                parallel::Team& team);

/// Returns the largest acceleration by these forces ([N * d]).
double largest_acceleration(const Bodies& bodies, std::span<const double> force, parallel::Team& team);

}  // namespace lichtenberg::granular
