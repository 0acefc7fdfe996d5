#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Sums over the equations of all cells, to find the common shift of all potentials (the potential level) that balances
/// the charges. `flux`: flux into the cells; `conductance`: decrease of this flux per unit shift of all potentials.
struct LevelSums {
  double flux = 0, conductance = 0;

  /// Returns the contribution of a link (conductance) from a cell to a given potential. `given`: the given potential;
  /// `own`: the potential of the cell.
  LICHTENBERG_HOST_DEVICE static LevelSums from_link(double conductance, double given, double own) {
    return {conductance * (given - own), conductance};
  }
  /// Returns the contribution of the links between cells and a group (bodies with one potential). `to_cells`: sum of
  /// the links' conductances; `potential`: potential of the group; `from_cells`: sum of conductance times the cells'
  /// potentials. `held`: fraction of a common shift that the group does not follow, because of its links to given
  /// potentials.
  LICHTENBERG_HOST_DEVICE static LevelSums from_group(double to_cells, double potential, double from_cells,
                                                      double held) {
    return {to_cells * potential - from_cells, to_cells * held};
  }
  LICHTENBERG_HOST_DEVICE LevelSums& operator+=(const LevelSums& other) {
    flux += other.flux;
    conductance += other.conductance;
    return *this;
  }
  /// Returns the common shift of all potentials that makes the flux zero; 0 if `conductance` is 0.
  LICHTENBERG_HOST_DEVICE double level() const { return conductance > 0 ? flux / conductance : 0.0; }
};

}  // namespace lichtenberg::laplace
