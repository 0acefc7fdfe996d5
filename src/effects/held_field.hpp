#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::effects {

/// The last field's forces and charges, and how they go on until the next: linearly in time.
struct HeldField {
  double time = 0;                          ///< s, of the solve
  std::vector<Vec3> force, force_rate;      ///< N, N/s, a conductor
  std::vector<double> charge, charge_rate;  ///< C, by the field (D 5.4), and A
  bool rates_known = false;                 ///< from the last two solves; if not they are 0

  Vec3 force_at(int i, double t) const { return force[i] + (t - time) * force_rate[i]; }
  double charge_at(int i, double t) const { return charge[i] + (t - time) * charge_rate[i]; }
};

}  // namespace lichtenberg::effects
