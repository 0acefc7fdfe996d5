#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// U = K q_i q_j (u(r) - u(R) - (r - R) u'(R)) with u = exp(-r / screen) / r, up to R: U and its derivative are
/// continuous.
struct YukawaLaw {
  static constexpr bool over_distance = false, charged = true;
  double strength = 1, screen = 0.5, range = 3;

  LICHTENBERG_HOST_DEVICE double reach(double, double) const { return range; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return 1; }
  LICHTENBERG_HOST_DEVICE PairForce bare(double r) const {
    const double u = std::exp(-r / screen) / r, over = 1 / r + 1 / screen;
    return {u, u * over, u * (over * over + 1 / (r * r))};
  }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairGeometry& pair) const {
    const PairForce here = bare(pair.distance), edge = bare(range);
    const double k = strength * pair.charge_i * pair.charge_j;
    return {k * (here.energy - edge.energy + (pair.distance - range) * edge.force), k * (here.force - edge.force),
            k * here.stiffness};
  }
};

}  // namespace lichtenberg
