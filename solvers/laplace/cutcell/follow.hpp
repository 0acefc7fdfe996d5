#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Solution of a coarser grid: potentials (V) by cell, row after row, with those of conductors inside them, and by
/// body.
struct Potentials {
  int nx = 0, ny = 0;
  std::vector<double> cell, body;
};

/// Adds to x, in units of `scale` (V), the change of potentials on a coarser grid of the same box. It is interpolated
/// bilinearly between cell centres; a group gets the mean of its members.
void add_change(const Potentials& before, const Potentials& now, const LaplaceProblem& problem, double scale,
                const CutCellOperator& op, std::vector<double>& x);

}  // namespace lichtenberg::laplace
