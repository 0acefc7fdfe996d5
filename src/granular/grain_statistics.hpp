#pragma once

#include <span>

#include "solvers/parallel/team.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Kinetic energy and largest speed of all grains, in reduced units.
struct GrainStatistics {
  double kinetic = 0;  ///< kinetic energy of all grains (m0 v0^2)
  double fastest = 0;  ///< largest speed of a grain (v0)
};

/// Returns kinetic energy and largest speed of the grains. The result is bitwise identical for any number of threads.
GrainStatistics grain_statistics(const Bodies& bodies, parallel::Team& team);

/// Result of kick(): largest change of a velocity, and kinetic energy and largest speed afterwards.
struct KickResult {
  double most = 0;        ///< largest change of a velocity (v0)
  GrainStatistics after;  ///< bitwise identical to grain_statistics() afterwards
};
/// Adds the impulse dt * (now - before) to the momenta of the grains, which corrects them for a change of the forces.
/// `before`, `now`: forces, [N * d].
KickResult kick(Bodies& bodies, double dt, std::span<const double> before, std::span<const double> now,
                parallel::Team& team);

/// Returns the largest acceleration of a grain by the forces `force` ([N * d]); 0 if `force` is empty.
double largest_acceleration(const Bodies& bodies, std::span<const double> force, parallel::Team& team);

}  // namespace lichtenberg::granular
