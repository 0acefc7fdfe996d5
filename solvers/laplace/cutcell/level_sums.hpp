#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Sums over the cells' equations: the flux into the cells, and its decrease per unit rise of all potentials.
struct LevelSums {
  double flux = 0, conductance = 0;

  /// Contribution of a cell's link to a given potential.
  LICHTENBERG_HOST_DEVICE static LevelSums from_link(double conductance, double given, double own) {
    return {conductance * (given - own), conductance};
  }
  /// Contribution of a group's links to cells. `to_cells`: their conductance; `from_cells`: the sum of conductance
  /// times the cells' potentials; `held`: the fraction of a level by which the group's potential does not change.
  LICHTENBERG_HOST_DEVICE static LevelSums from_group(double to_cells, double potential, double from_cells,
                                                      double held) {
    return {to_cells * potential - from_cells, to_cells * held};
  }
  LICHTENBERG_HOST_DEVICE LevelSums& operator+=(const LevelSums& other) {
    flux += other.flux;
    conductance += other.conductance;
    return *this;
  }
  LICHTENBERG_HOST_DEVICE double level() const { return conductance > 0 ? flux / conductance : 0.0; }
};

}  // namespace lichtenberg::laplace
