#pragma once

#include <vector>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Number of cells of a grid in x and y.
struct GridSize {
  int nx, ny;
};

/// Computes the size of the finest grid, with `cells` square cells along the box's longer side. Throws InputError for
/// fewer than 4 cells, or if the shorter side is not a whole number of cells.
GridSize finest_grid(const LaplaceProblem& problem, int cells);

/// Computes the grid sizes of the multigrid V-cycle from the finest (nx x ny) to the coarsest. Each grid has half the
/// cells per side of the next finer one. Coarsening ends at an odd number of cells, or at 8 or fewer along the shorter
/// side.
std::vector<GridSize> grid_sizes(int nx, int ny);

/// Computes the layouts of these grids for one of several processes. Rows of large grids are divided into slabs of
/// nearly equal size. The process that owns row J of a grid owns rows 2J and 2J + 1 of the next finer one. Grids with
/// few rows a process, few cells, or an odd number of cells are not divided, nor is the coarsest. `process`: index of
/// the process.
std::vector<Layout> grid_layouts(int nx, int ny, int process, int processes);

}  // namespace lichtenberg::laplace
