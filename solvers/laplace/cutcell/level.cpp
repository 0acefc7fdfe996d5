#include "solvers/laplace/cutcell/level.hpp"

#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

Level::Level(const LaplaceProblem& problem, int nx, int ny) : layout(nx, ny), h(problem.size.x / nx) {
  parallel::resize_in_huge_pages(owner, layout.size());
  parallel::resize_in_huge_pages(diagonal, layout.size());
}

std::vector<NetworkLink> Level::direct_links(const LaplaceProblem& problem) const {
  std::vector<NetworkLink> direct;
  for (const PairLink& pair : pairs)
    direct.push_back({problem.bodies[pair.body_a].group, problem.bodies[pair.body_b].group, pair.conductance});
  eliminated.for_each_pair([&](const EliminatedCells::Link& a, const EliminatedCells::Link& b, double conductance) {
    direct.push_back({a.group, b.group, conductance});
  });
  return direct;
}

}  // namespace lichtenberg::laplace
