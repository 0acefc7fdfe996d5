#include "solvers/laplace/cutcell/system.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

namespace {

struct Entry {
  int column;
  double value;
};

// Unknown of every slot and group; -1: none.
struct Numbering {
  std::vector<int> of_slot, of_group;
};

Numbering number_unknowns(const LaplaceProblem& problem, const Level& level, SparseSystem& system) {
  Numbering number{std::vector<int>(level.layout.size(), -1), std::vector<int>(problem.groups.size(), -1)};
  int next = 0;
  for (int j = 0; j < level.layout.ny; ++j)
    for (int i = 0; i < level.layout.nx; ++i) {
      const std::ptrdiff_t slot = level.layout(i, j);
      if (level.cover[slot] >= 0) continue;
      number.of_slot[slot] = next++;
      system.slot.push_back(slot);
    }
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    if (!problem.groups[g].floating || !level.has_unknown(static_cast<int>(g))) continue;
    number.of_group[g] = next++;
    system.group.push_back(static_cast<int>(g));
  }
  return number;
}

}  // namespace

SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin) {
  SparseSystem system;
  const Numbering number = number_unknowns(problem, level, system);
  const int cells = static_cast<int>(system.slot.size());
  const int unknowns = cells + static_cast<int>(system.group.size());

  // Links first, by the row of each end; the regular stencil is written straight into the rows below.
  std::vector<double> diagonal(unknowns, 0.0);
  std::vector<std::pair<int, Entry>> couplings;
  const auto couple = [&](int a, int b, double c) {
    if (a >= 0) diagonal[a] += c;
    if (b >= 0) diagonal[b] += c;
    if (a < 0 || b < 0) return;
    if (!upper_only || a > b) couplings.push_back({a, {b, -c}});
    if (!upper_only || b > a) couplings.push_back({b, {a, -c}});
  };
  const auto unknown_of_body = [&](int body) { return number.of_group[problem.bodies[body].group]; };
  for (const Link& link : level.links) couple(number.of_slot[link.cell], unknown_of_body(link.body), link.conductance);
  for (const PairLink& pair : level.pairs)
    couple(unknown_of_body(pair.body_a), unknown_of_body(pair.body_b), pair.conductance);
  for (const SideLink& link : level.side_links)
    couple(link.cell >= 0 ? number.of_slot[link.cell] : unknown_of_body(link.body), -1, link.conductance);
  for (int a = 0; a < cells; ++a) diagonal[a] = level.diagonal[system.slot[a]];
  if (pin) diagonal[unknowns - 1] *= 2;
  std::stable_sort(couplings.begin(), couplings.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.column < b.second.column;
  });

  system.start.reserve(unknowns + 1);
  system.index.reserve(5 * static_cast<std::size_t>(unknowns));
  system.value.reserve(5 * static_cast<std::size_t>(unknowns));
  std::size_t next = 0;
  std::vector<Entry> row;
  const Layout& at = level.layout;
  int a = 0;
  const auto finish_row = [&] {
    system.start.push_back(static_cast<int>(system.index.size()));
    row.push_back({a, diagonal[a]});
    for (; next < couplings.size() && couplings[next].first == a; ++next) row.push_back(couplings[next].second);
    std::sort(row.begin(), row.end(), [](Entry x, Entry y) { return x.column < y.column; });
    for (const Entry& entry : row) {
      if (static_cast<int>(system.index.size()) > system.start.back() && system.index.back() == entry.column) {
        system.value.back() += entry.value;  // several links between the same two unknowns
        continue;
      }
      system.index.push_back(entry.column);
      system.value.push_back(entry.value);
    }
    row.clear();
    ++a;
  };
  for (int j = 0; j < at.ny; ++j)
    for (int i = 0; i < at.nx; ++i) {
      if (level.cover[at(i, j)] >= 0) continue;
      const auto neighbour = [&](int ni, int nj, std::ptrdiff_t face, const std::vector<float>& conductance) {
        if (ni < 0 || ni >= at.nx || nj < 0 || nj >= at.ny) return;
        const int b = number.of_slot[at(ni, nj)];
        if (b >= 0 && (!upper_only || b < a)) row.push_back({b, conductance.empty() ? -1.0 : -conductance[face]});
      };
      neighbour(i, j - 1, at(i, j - 1), level.north);
      neighbour(i - 1, j, at(i - 1, j), level.east);
      neighbour(i + 1, j, at(i, j), level.east);
      neighbour(i, j + 1, at(i, j), level.north);
      finish_row();
    }
  while (a < unknowns) finish_row();
  system.start.push_back(static_cast<int>(system.index.size()));
  return system;
}

}  // namespace lichtenberg::laplace
