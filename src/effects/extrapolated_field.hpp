#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::effects {

/// Forces and charges of the last field solve and their linear extrapolation in time until the next.
struct ExtrapolatedField {
  double time = 0;                          ///< s, time of the solve
  std::vector<Vec3> force, force_rate;      ///< N, N/s, for each conductor
  std::vector<double> charge, charge_rate;  ///< C, from the field (D 5.4), and A
  bool rates_known = false;                 ///< true: rates are from the last two solves; false: they are 0

  Vec3 force_at(int i, double t) const { return force[i] + (t - time) * force_rate[i]; }
  double charge_at(int i, double t) const { return charge[i] + (t - time) * charge_rate[i]; }
};

}  // namespace lichtenberg::effects
