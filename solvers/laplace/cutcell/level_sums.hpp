#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Sum of the cells' equations: the flux that enters them, and by how much it falls if all potentials rise by 1.
struct LevelSums {
  double flux = 0, conductance = 0;

  /// Of a cell's link to a given potential.
  LICHTENBERG_HOST_DEVICE static LevelSums of_link(double conductance, double given, double own) {
    return {conductance * (given - own), conductance};
  }
  /// Of a group's links to cells: their conductance, the group's potential, the sum of conductance times the cells'
  /// potentials, and the share by which the group does not follow a level.
  LICHTENBERG_HOST_DEVICE static LevelSums of_group(double to_cells, double potential, double from_cells, double held) {
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
