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

}  // namespace lichtenberg::laplace
