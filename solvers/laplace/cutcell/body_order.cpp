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
  sorted_.size = problem.size;
  sorted_.sides = problem.sides;
  sorted_.permittivity = problem.permittivity;
  sorted_.groups = problem.groups;
  sorted_.couplings = problem.couplings;
  sorted_.bodies.clear();
  for (const int body : index_) sorted_.bodies.push_back(problem.bodies[body]);
}

}  // namespace lichtenberg::laplace
