#include "solvers/laplace/cutcell/bound_cells.hpp"

#include <algorithm>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

void BoundCells::clear() {
  cells.clear();
  start.assign(1, 0);
  links.clear();
  link_of_level.clear();
}

void BoundCells::append(const BoundCells& more) {
  const int before = static_cast<int>(links.size());
  cells.insert(cells.end(), more.cells.begin(), more.cells.end());
  for (std::size_t k = 1; k < more.start.size(); ++k) start.push_back(before + more.start[k]);
  links.insert(links.end(), more.links.begin(), more.links.end());
  link_of_level.insert(link_of_level.end(), more.link_of_level.begin(), more.link_of_level.end());
}

void Level::find_bound_cells(const LaplaceProblem& problem, parallel::Team& team) {
  const int chunks = 4 * team.size();
  std::vector<BoundCells> found(chunks);
  team.for_each(chunks, [&](int chunk) {
    found[chunk].clear();
    for (int j = layout.ny * chunk / chunks; j < layout.ny * (chunk + 1) / chunks; ++j)
      for (int m = row_start[j]; m < row_start[j + 1]; ++m) {
        const RowLink& link = row_links[m];
        if (link.conductance < BoundCells::least_conductance || !resolves(link.body)) continue;
        int from = m;
        while (from > row_start[j] && row_links[from - 1].cell == link.cell) --from;
        while (m + 1 < row_start[j + 1] && row_links[m + 1].cell == link.cell) ++m;
        bind_cell(problem, j, std::span(row_links).subspan(from, m + 1 - from), found[chunk]);
      }
  });
  bound.clear();
  for (const BoundCells& part : found) bound.append(part);
}

/// A cell of row j with all its links.
void Level::bind_cell(const LaplaceProblem& problem, int j, std::span<const RowLink> of_cell, BoundCells& found) const {
  const int first = static_cast<int>(found.links.size());
  for (const RowLink& link : of_cell) {
    const int group = problem.bodies[link.body].group;
    if (!problem.groups[group].floating) continue;
    found.link_of_level.push_back(link.link);
    const auto same = std::find_if(found.links.begin() + first, found.links.end(),
                                   [group](const BoundCells::Link& known) { return known.group == group; });
    if (same != found.links.end())
      same->conductance += link.conductance;
    else
      found.links.push_back({link.body, group, link.conductance});
  }
  if (static_cast<int>(found.links.size()) == first) return;
  const std::ptrdiff_t cell = of_cell.front().cell;
  found.cells.push_back({cell, j, diagonal[cell]});
  found.start.push_back(static_cast<int>(found.links.size()));
}

std::vector<NetworkLink> Level::direct_links(const LaplaceProblem& problem) const {
  std::vector<NetworkLink> direct;
  for (const PairLink& pair : pairs)
    direct.push_back({problem.bodies[pair.body_a].group, problem.bodies[pair.body_b].group, pair.conductance});
  bound.for_each_joined([&](const BoundCells::Link& a, const BoundCells::Link& b, double conductance) {
    direct.push_back({a.group, b.group, conductance});
  });
  return direct;
}

}  // namespace lichtenberg::laplace
