#include "solvers/laplace/cutcell/eliminated_cells.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/slabs.hpp"

namespace lichtenberg::laplace {

void EliminatedCells::clear() {
  cells.clear();
  start.assign(1, 0);
  links.clear();
  link_of_level.clear();
}

void EliminatedCells::append(const EliminatedCells& more) {
  const int before = static_cast<int>(links.size());
  cells.insert(cells.end(), more.cells.begin(), more.cells.end());
  for (std::size_t k = 1; k < more.start.size(); ++k) start.push_back(before + more.start[k]);
  links.insert(links.end(), more.links.begin(), more.links.end());
  link_of_level.insert(link_of_level.end(), more.link_of_level.begin(), more.link_of_level.end());
}

namespace {

/// Adds a fluid cell of row j with all its links to `found`, unless none leads to a floating group.
void add_cell(const LaplaceProblem& problem, const Level& level, int j, std::span<const RowLink> cell_links,
              EliminatedCells& found) {
  const int first = static_cast<int>(found.links.size());
  for (const RowLink& link : cell_links) {
    const int group = problem.bodies[link.body].group;
    if (!problem.groups[group].floating) continue;
    found.link_of_level.push_back(link.link);
    const auto same = std::find_if(found.links.begin() + first, found.links.end(),
                                   [group](const EliminatedCells::Link& known) { return known.group == group; });
    if (same != found.links.end())
      same->conductance += link.conductance;
    else
      found.links.push_back({link.body, group, link.conductance});
  }
  if (static_cast<int>(found.links.size()) == first) return;
  const std::ptrdiff_t cell = cell_links.front().cell;
  found.cells.push_back({cell, j, level.diagonal[cell]});
  found.start.push_back(static_cast<int>(found.links.size()));
}

/// Adds the cells of row j that have a link of large conductance to `found`.
void add_row(const LaplaceProblem& problem, const GridBodies& bodies, const Level& level, int j,
             EliminatedCells& found) {
  const std::span<const RowLink> all(level.row_links);
  for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m) {
    const RowLink& link = all[m];
    if (link.conductance < EliminatedCells::least_conductance || !bodies.resolves(link.body)) continue;
    int from = m;
    while (from > level.row_start[j] && all[from - 1].cell == link.cell) --from;
    while (m + 1 < level.row_start[j + 1] && all[m + 1].cell == link.cell) ++m;
    add_cell(problem, level, j, all.subspan(from, m + 1 - from), found);
  }
}

/// Lists the pairs of groups with links to the same eliminated cell.
void list_pairs(Level& level) {
  level.eliminated_pairs.clear();
  const auto& [cells, start, links, link_of_level] = level.eliminated;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (!level.layout.own.contains(cells[k].row)) continue;
    for (int m = start[k]; m < start[k + 1]; ++m)
      for (int n = m + 1; n < start[k + 1]; ++n)
        level.eliminated_pairs.push_back(
            {links[m].body,
             links[n].body,
             EliminatedCells::schur_offdiagonal(links[m].conductance, links[n].conductance, cells[k].diagonal),
             {},
             {}});
  }
  gather_list(level.layout, level.eliminated_pairs);
}

}  // namespace

void find_eliminated_cells(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team,
                           std::vector<EliminatedCells>& found) {
  const int rows = level.layout.ny, chunks = team.size() == 1 ? 1 : 4 * team.size();
  found.resize(chunks);
  team.for_each(chunks, [&](int chunk) {
    found[chunk].clear();
    for (int j = rows * chunk / chunks; j < rows * (chunk + 1) / chunks; ++j)
      add_row(problem, bodies, level, j, found[chunk]);
  });
  if (chunks == 1) {
    std::swap(level.eliminated, found[0]);
  } else {
    level.eliminated.clear();
    for (const EliminatedCells& part : found) level.eliminated.append(part);
  }
  list_pairs(level);
}

}  // namespace lichtenberg::laplace
