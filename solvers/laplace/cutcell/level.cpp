#include "solvers/laplace/cutcell/level.hpp"

#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

Level::Level(const LaplaceProblem& problem, const Layout& at) : layout(at), h(problem.size.x / at.nx) {
  parallel::resize_in_huge_pages(owner, layout.size());
  parallel::resize_in_huge_pages(diagonal, layout.size());
}

std::vector<NetworkLink> Level::direct_links(const LaplaceProblem& problem) const {
  std::vector<NetworkLink> direct;
  for (const std::vector<PairLink>* list : {&pairs, &eliminated_pairs})
    for (const PairLink& pair : *list)
      direct.push_back({problem.bodies[pair.body_a].group, problem.bodies[pair.body_b].group, pair.conductance});
  return direct;
}

}  // namespace lichtenberg::laplace
