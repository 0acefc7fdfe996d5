#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Solution on a coarser grid of nx x ny cells: potentials (V) by cell, row after row, and by body. Cells inside a
/// conductor have its potential.
struct Potentials {
  int nx = 0, ny = 0;
  std::vector<double> cell, body;
};

/// Adds the change of the potentials on a coarser grid of the same box to the initial guess x, in units of `scale` (V).
/// The change is interpolated bilinearly between cell centres. A floating group (bodies with one unknown potential)
/// gets the mean change of its bodies. `before`, `now`: two solutions on the coarser grid; `op`: system of the finer
/// one.
void add_change(const Potentials& before, const Potentials& now, const LaplaceProblem& problem, double scale,
                const CutCellOperator& op, std::vector<double>& x);

}  // namespace lichtenberg::laplace
