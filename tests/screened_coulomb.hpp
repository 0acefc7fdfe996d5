#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// Screened repulsion of equal charges, U = strength exp(-r / screen) / r up to `range`, with a cutoff there: an
/// example of a pair law of long range.
struct ScreenedCoulombLaw {
  static constexpr bool over_distance = false, charged = false;
  double strength = 1;  ///< J m
  double screen = 1;    ///< m
  double range = 2;     ///< m

  LICHTENBERG_HOST_DEVICE double reach(double, double) const { return range; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return 1; }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairGeometry& pair) const {
    const double r = pair.distance, energy = strength * std::exp(-r / screen) / r, over = 1 / r + 1 / screen;
    return {energy, energy * over, energy * (over * over + 1 / (r * r))};
  }
};

}  // namespace lichtenberg
