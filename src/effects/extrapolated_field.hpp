#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::effects {

/// Electric forces on conductors and their charges from the last field solve, extrapolated linearly in time until the
/// next solve.
struct ExtrapolatedField {
  double time = 0;                          ///< time of the last solve (s)
  std::vector<Vec3> force, force_rate;      ///< for each conductor (N, N/s)
  std::vector<double> charge, charge_rate;  ///< for each conductor, from the field (C, A)
  bool rates_known = false;                 ///< true: rates are from the last two solves; false: they are 0

  Vec3 force_at(int i, double t) const { return force[i] + (t - time) * force_rate[i]; }
  double charge_at(int i, double t) const { return charge[i] + (t - time) * charge_rate[i]; }
};

}  // namespace lichtenberg::effects
