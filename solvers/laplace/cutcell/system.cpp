#include "solvers/laplace/cutcell/system.hpp"

#include <algorithm>
#include <array>

namespace lichtenberg::laplace {

namespace {

/// Range of rows and variant of the matrix to assemble.
struct MatrixPart {
  // Range of rows.
  int begin, end;
  bool upper_only;
  bool pin;
  // Whether couplings to fixed groups are those of the preconditioner.
  bool in_cycle;
};

using Entry = SparseSystem::Entry;

/// Index of the unknown of every slot (memory index of a cell) and group; -1: none.
struct Numbering {
  std::vector<int> by_slot, by_group;
};

Numbering invert(const LaplaceProblem& problem, const Level& level, const SparseSystem& system) {
  Numbering number{std::vector<int>(level.layout.size(), -1), std::vector<int>(problem.groups.size(), -1)};
  int next = 0;
  for (const std::ptrdiff_t slot : system.slot) number.by_slot[slot] = next++;
  for (const int g : system.group) number.by_group[g] = next++;
  return number;
}

/// Entries of the matrix that are not part of the five-point stencil: the diagonal, and entries of links and couplings.
struct Links {
  // By unknown.
  std::vector<double> diagonal;
  // By row and column.
  std::vector<std::pair<int, Entry>> couplings;
};

Links collect_links(const LaplaceProblem& problem, const Level& level, const SparseSystem& system,
                    const Numbering& number, MatrixPart part) {
  Links links;
  links.diagonal.resize(system.unknowns(), 0.0);
  const auto add = [&](int row, int column, double c) {
    if (row >= part.begin && row < part.end && (!part.upper_only || row > column))
      links.couplings.push_back({row, {column, -c}});
  };
  std::vector<int> from(system.unknowns(), -1);
  for (const SparseSystem::Difference& difference : system.differences) from[difference.unknown] = difference.from;
  // The potential of an end is that of unknown a, plus that of from[a] if it exists; it may be the same at both ends.
  const auto couple = [&](int a, int b, double c) {
    const int base_a = a >= 0 ? from[a] : -1, base_b = b >= 0 ? from[b] : -1;
    const bool cancel_a = base_a >= 0 && (base_a == base_b || base_a == b);
    const bool cancel_b = base_b >= 0 && (base_b == base_a || base_b == a);
    std::array<int, 4> end{a, base_a, b, base_b};
    std::array<double, 4> sign{1, 1, -1, -1};
    if (cancel_a) end[1] = -1;
    if (cancel_b) end[3] = -1;
    if (cancel_a && base_a == b) end[2] = -1;
    if (cancel_b && base_b == a) end[0] = -1;
    for (int k = 0; k < 4; ++k) {
      if (end[k] < 0) continue;
      links.diagonal[end[k]] += c;
      for (int l = 0; l < 4; ++l)
        if (l != k && end[l] >= 0) add(end[k], end[l], -sign[k] * sign[l] * c);
    }
  };
  const auto unknown_of_body = [&](int body) { return number.by_group[problem.bodies[body].group]; };
  for (const FluidLink& link : level.links)
    couple(number.by_slot[link.cell], unknown_of_body(link.body), link.conductance);
  for (const PairLink& pair : level.pairs)
    couple(unknown_of_body(pair.body_a), unknown_of_body(pair.body_b), pair.conductance);
  for (const SideLink& link : level.side_links)
    couple(link.cell >= 0 ? number.by_slot[link.cell] : unknown_of_body(link.body), -1, link.conductance);
  for (const auto& [a, b, conductance] : level.couplings) couple(number.by_group[a], number.by_group[b], conductance);
  for (const FixedCoupling& coupling : level.fixed_couplings)
    couple(number.by_group[coupling.group], -1, part.in_cycle ? coupling.conductance_in_cycle : coupling.conductance);
  for (std::size_t a = 0; a < system.slot.size(); ++a) links.diagonal[a] = level.diagonal[system.slot[a]];
  if (part.pin) links.diagonal[from.back() >= 0 ? from.back() : from.size() - 1] *= 2;
  std::stable_sort(links.couplings.begin(), links.couplings.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.column < b.second.column;
  });
  return links;
}

void assemble_part(const LaplaceProblem& problem, const Level& level, MatrixPart part, SparseSystem& system) {
  const Numbering number = invert(problem, level, system);
  const Links links = collect_links(problem, level, system, number, part);
  const Layout& at = level.layout;
  const auto rows = static_cast<std::size_t>(part.end - part.begin);
  system.start.reserve(rows + 1);
  system.index.reserve(5 * rows);
  system.value.reserve(5 * rows);
  system.start.assign(1, 0);
  auto coupling = links.couplings.begin();
  std::vector<Entry> row;
  for (int a = part.begin; a < part.end; ++a) {
    row.clear();
    if (a < static_cast<int>(system.slot.size())) {
      const auto [i, j] = cell_of(at, static_cast<int>(system.slot[a]));
      const auto neighbour = [&](int ni, int nj, std::ptrdiff_t face, const std::vector<float>& conductance) {
        if (ni < 0 || ni >= at.nx || nj < 0 || nj >= at.ny) return;
        const int b = number.by_slot[at(ni, nj)];
        if (b >= 0 && (!part.upper_only || b < a)) row.push_back({b, conductance.empty() ? -1.0 : -conductance[face]});
      };
      neighbour(i, j - 1, at(i, j - 1), level.faces.north);
      neighbour(i - 1, j, at(i - 1, j), level.faces.east);
      neighbour(i + 1, j, at(i, j), level.faces.east);
      neighbour(i, j + 1, at(i, j), level.faces.north);
    }
    row.push_back({a, links.diagonal[a]});
    for (; coupling != links.couplings.end() && coupling->first == a; ++coupling) row.push_back(coupling->second);
    system.append(row);
  }
}

/// Finds the unknowns that are differences of potentials. The first group of each strongly coupled set has its
/// potential as unknown, the others the difference from it.
void number_differences(const LaplaceProblem& problem, const Level& level, SparseSystem& system) {
  if (level.couplings.empty()) return;
  constexpr double strong = 1e3;
  const std::vector<int> set_of = coupled_sets(problem, strong * problem.permittivity);
  std::vector<int> first(problem.groups.size(), -1);
  for (std::size_t k = 0; k < system.group.size(); ++k) {
    const int unknown = static_cast<int>(system.slot.size() + k), set = set_of[system.group[k]];
    if (first[set] < 0)
      first[set] = unknown;
    else
      system.differences.push_back({unknown, first[set]});
  }
}

}  // namespace

SparseSystem number_unknowns(const LaplaceProblem& problem, const Level& level) {
  SparseSystem system;
  for (int j = 0; j < level.layout.ny; ++j)
    for (int i = 0; i < level.layout.nx; ++i)
      if (const std::ptrdiff_t slot = level.layout(i, j); level.owner[slot].is_fluid()) system.slot.push_back(slot);
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    if (problem.groups[g].floating && level.has_unknown(static_cast<int>(g)))
      system.group.push_back(static_cast<int>(g));
  number_differences(problem, level, system);
  return system;
}

void SparseSystem::append(std::vector<Entry>& row) {
  std::sort(row.begin(), row.end(), [](Entry x, Entry y) { return x.column < y.column; });
  for (const Entry& entry : row) {
    if (static_cast<int>(index.size()) > start.back() && index.back() == entry.column) {
      value.back() += entry.value;
      continue;
    }
    index.push_back(entry.column);
    value.push_back(entry.value);
  }
  start.push_back(static_cast<int>(index.size()));
}

void SparseSystem::from_charges(double* b) const {
  for (const auto& [unknown, from] : differences) b[from] += b[unknown];
}

void SparseSystem::from_potentials(double* x) const {
  for (const auto& [unknown, from] : differences) x[unknown] -= x[from];
}

void SparseSystem::to_potentials(double* x) const {
  for (const auto& [unknown, from] : differences) x[unknown] += x[from];
}

void assemble_rows(const LaplaceProblem& problem, const Level& level, int begin, int end, SparseSystem& system) {
  assemble_part(problem, level, {begin, end, false, false, false}, system);
}

SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin) {
  SparseSystem system = number_unknowns(problem, level);
  assemble_part(problem, level, {0, system.unknowns(), upper_only, pin, true}, system);
  return system;
}

}  // namespace lichtenberg::laplace
