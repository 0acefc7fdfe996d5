#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

struct GridSize {
  int nx, ny;
};

/// Returns the finest grid, with `cells` square cells along the box's longer side. Throws InputError for fewer than 4
/// cells, or if the shorter side is not a whole number of cells.
GridSize finest_grid(const LaplaceProblem& problem, int cells);

/// Returns the grids of the V-cycle from the finest (nx x ny) to the coarsest, each with half the cells per side. A
/// grid with an odd number of cells is the last.
std::vector<GridSize> grid_sizes(int nx, int ny);

}  // namespace lichtenberg::laplace
