#include "solvers/laplace/cutcell/body_order.hpp"

#include <numeric>

#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

void BodyOrder::sort(const LaplaceProblem& problem, int rows) {
  const std::size_t bodies = problem.bodies.size();
  const double height = problem.size.y / rows;
  std::vector<int> row(bodies), next(rows + 1, 0);
  for (std::size_t body = 0; body < bodies; ++body) {
    row[body] = cell_at(outline_in_cells(problem.bodies[body].shape, height).centre.y, rows);
    ++next[row[body] + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  index_.resize(bodies);
  for (std::size_t body = 0; body < bodies; ++body) index_[next[row[body]]++] = static_cast<int>(body);
  sorted_ = problem;
  for (std::size_t body = 0; body < bodies; ++body) sorted_.bodies[body] = problem.bodies[index_[body]];
}

}  // namespace lichtenberg::laplace
