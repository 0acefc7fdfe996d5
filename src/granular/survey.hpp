#pragma once

#include <span>

#include "solvers/parallel/team.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// What a step needs to know of all grains: sums and maxima over them.
struct Survey {
  double kinetic = 0;  ///< energy
  double fastest = 0;  ///< the largest speed
};

/// Of the grains as they are. The same bits for any number of threads.
Survey survey(const Bodies& bodies, parallel::Team& team);

/// Momenta change by dt (now - before), of forces [N * d].
struct Kicked {
  double most = 0;  ///< by which a velocity has changed
  Survey after;     ///< with the bits that `survey` finds then
};
Kicked kick(Bodies& bodies, double dt, std::span<const double> before, std::span<const double> now,
            parallel::Team& team);

/// The largest of the forces ([N * d]) over their grain's mass.
double largest_acceleration(const Bodies& bodies, std::span<const double> force, parallel::Team& team);

}  // namespace lichtenberg::granular
