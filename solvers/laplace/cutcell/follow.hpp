#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// A solution as a finer grid needs it: the potential of each cell (V, by row and column, conductors' inside them) and
/// of each body.
struct Potentials {
  int nx = 0, ny = 0;
  std::vector<double> cell, body;
};

/// Adds to x, in units of `scale` (V), by how much the potentials on a coarser grid of the same box have changed:
/// between cell centres bilinearly, the groups' as their members' on average.
void add_change(const Potentials& before, const Potentials& now, const LaplaceProblem& problem, double scale,
                const CutCellOperator& op, std::vector<double>& x);

}  // namespace lichtenberg::laplace
