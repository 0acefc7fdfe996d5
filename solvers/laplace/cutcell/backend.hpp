#pragma once

#include <optional>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Solver behind CutCellSolver, on the CPU or on a device. The caller has checked the problem and eliminated nodes of
/// circuits.
class CutCellBackend : public LaplaceSolver {
 public:
  virtual void set_tolerance(double tolerance) = 0;
  /// CutCellSolver::follow; nothing is followed from now on if `coarser` is another kind of backend.
  virtual void follow(const CutCellBackend& coarser) = 0;
};

/// A new unit of all potentials, V; nothing if the old one is good enough. Single precision holds 38 decades either
/// way: enough for any right-hand side of about 1. The unit is kept within a factor of 1e6, so that past solutions need
/// no rescaling. `largest`: charge / permittivity or potential given.
inline std::optional<double> new_potential_unit(double largest, double unit, bool has_past) {
  const double ratio = largest / unit;
  if (has_past && (largest == 0 || (ratio > 1e-6 && ratio < 1e6))) return {};
  return largest > 0 ? largest : 1;
}

}  // namespace lichtenberg::laplace
