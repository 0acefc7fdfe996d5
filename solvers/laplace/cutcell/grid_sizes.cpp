#include "solvers/laplace/cutcell/grid_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "solvers/error.hpp"

namespace lichtenberg::laplace {

GridSize finest_grid(const LaplaceProblem& problem, int cells) {
  const double h = std::max(problem.size.x, problem.size.y) / cells;
  const int nx = static_cast<int>(std::lround(problem.size.x / h)),
            ny = static_cast<int>(std::lround(problem.size.y / h));
  if (cells < 4 || nx < 1 || ny < 1 || std::abs(nx * h - problem.size.x) > 1e-9 * problem.size.x ||
      std::abs(ny * h - problem.size.y) > 1e-9 * problem.size.y)
    throw InputError(
        "field.cells = " + std::to_string(cells) +
        ": the domain's shorter side must hold a whole number of square cells, and there must be at least 4");
  return {nx, ny};
}

std::vector<GridSize> grid_sizes(int nx, int ny) {
  constexpr int least = 8;  // cells along the shorter side, few enough for a fast factorization
  std::vector<GridSize> sizes{{nx, ny}};
  while (nx % 2 == 0 && ny % 2 == 0 && std::min(nx, ny) > least) {
    nx /= 2;
    ny /= 2;
    sizes.push_back({nx, ny});
  }
  return sizes;
}

std::vector<Layout> grid_layouts(int nx, int ny, int process, int processes) {
  constexpr long least_rows = 32, least_cells = 1L << 15;  // of a divided grid: rows a process, cells in all
  const std::vector<GridSize> sizes = grid_sizes(nx, ny);
  const int last = static_cast<int>(sizes.size()) - 1;
  int divided = 0;
  const auto is_large = [&](GridSize size) {
    return size.ny >= least_rows * processes && static_cast<long>(size.nx) * size.ny >= least_cells;
  };
  while (processes > 1 && divided < last && is_large(sizes[divided])) ++divided;
  std::vector<Layout> layouts;
  for (int l = 0; l <= last; ++l) {
    const auto [columns, rows] = sizes[l];
    if (l >= divided) {
      layouts.emplace_back(columns, rows);
      continue;
    }
    const long coarser = sizes[divided].ny;  // rows of the finest grid that is not divided
    const auto first_row = [&](int k) { return static_cast<int>(coarser * k / processes) << (divided - l); };
    layouts.emplace_back(columns, rows, Rows{first_row(process), first_row(process + 1)});
  }
  return layouts;
}

}  // namespace lichtenberg::laplace
