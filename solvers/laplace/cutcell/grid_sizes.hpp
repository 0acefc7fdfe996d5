#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

struct GridSize {
  int nx, ny;
};

/// The finest grid, of square cells, `cells` of them along the box's longer side. Throws InputError if they do not fit.
GridSize finest_grid(const LaplaceProblem& problem, int cells);

/// The grids of the V-cycle, from the finest (nx x ny) to the coarsest, each with half the cells a side. Where a number
/// of cells is odd they end.
std::vector<GridSize> grid_sizes(int nx, int ny);

}  // namespace lichtenberg::laplace
