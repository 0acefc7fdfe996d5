#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// A level's couplings between fluid cells and groups, in the two orders that loops need: by row of the cell, for what
/// the groups' potentials bring the cells while a sweep passes, and by body, for what the cells bring the groups.
template <class Real>
class LinkLists {
 public:
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team) {
    const int bodies = static_cast<int>(problem.bodies.size()), rows = level.layout.ny;
    body_start_ = level.link_start;
    row_start_ = level.row_start;
    by_body_.resize(level.links.size());
    by_row_.resize(level.links.size());
    body_group_.resize(bodies);
    for (int body = 0; body < bodies; ++body) body_group_[body] = problem.bodies[body].group;
    body_sum_.resize(bodies);
    black_start_.resize(rows);
    const int chunks = 4 * team.size();
    team.for_each(chunks, [&](int k) {
      const std::size_t size = level.links.size();
      for (std::size_t m = size * k / chunks; m < size * (k + 1) / chunks; ++m) {
        const FluidLink& link = level.links[m];
        by_body_[m] = {static_cast<std::int32_t>(link.cell), static_cast<Real>(link.conductance)};
      }
      for (int j = rows * k / chunks; j < rows * (k + 1) / chunks; ++j)
        black_start_[j] = static_cast<int>(
            std::partition_point(level.links_by_row.begin() + row_start_[j],
                                 level.links_by_row.begin() + row_start_[j + 1],
                                 [&](int m) { return level.links[m].cell < level.layout.colour_size(); }) -
            level.links_by_row.begin());
      for (int m = row_start_[rows * k / chunks]; m < row_start_[rows * (k + 1) / chunks]; ++m) {
        const FluidLink& link = level.links[level.links_by_row[m]];
        by_row_[m] = {static_cast<std::int32_t>(link.cell), body_group_[link.body],
                      static_cast<Real>(link.conductance)};
      }
    });
  }

  /// What the groups at `potential` bring the cells of row j: effect(cell, conductance * potential).
  template <class Effect>
  void add_to_row(int j, const Real* potential, const Effect& effect) const {
    for (int m = row_start_[j]; m < row_start_[j + 1]; ++m)
      effect(by_row_[m].cell, by_row_[m].conductance * potential[by_row_[m].group]);
  }

  /// What the groups at `potential` bring the cells of one colour in row j, summed over all groups of a cell:
  /// effect(cell, flux), once a cell.
  template <class Effect>
  void for_linked_cells(int colour, int j, const Real* potential, const Effect& effect) const {
    const int from = colour == 0 ? row_start_[j] : black_start_[j];
    const int to = colour == 0 ? black_start_[j] : row_start_[j + 1];
    for (int m = from; m < to;) {
      const std::int32_t cell = by_row_[m].cell;
      Real flux = 0;
      for (; m < to && by_row_[m].cell == cell; ++m) flux += by_row_[m].conductance * potential[by_row_[m].group];
      effect(cell, flux);
    }
  }

  /// Takes these of the level's links out of the sums over groups.
  void leave_out(const std::vector<int>& links) {
    for (const int m : links) by_body_[m].conductance = 0;
  }

  /// Sums conductance * v over each group's links and adds it to `sum` [groups].
  void add_to_groups(parallel::Team& team, const Real* v, Real* sum) const {
    add_of_links(team, sum, [v](const OfBody& link) { return link.conductance * v[link.cell]; });
  }

  /// Adds each group's conductances to `sum` [groups].
  void add_conductances(parallel::Team& team, Real* sum) const {
    add_of_links(team, sum, [](const OfBody& link) { return link.conductance; });
  }

 private:
  struct OfBody {
    std::int32_t cell;
    Real conductance;
  };
  struct OfRow {
    std::int32_t cell, group;
    Real conductance;
  };
  template <class Term>
  void add_of_links(parallel::Team& team, Real* sum, const Term& term) const {
    const int bodies = static_cast<int>(body_group_.size());
    constexpr int links_a_chunk = 2048;
    const int chunks = std::clamp(static_cast<int>(by_body_.size()) / links_a_chunk, 1, 4 * team.size());
    team.for_each(chunks, [&](int k) {
      for (int body = bodies * k / chunks; body < bodies * (k + 1) / chunks; ++body) {
        Real of_body = 0;
        for (int m = body_start_[body]; m < body_start_[body + 1]; ++m) of_body += term(by_body_[m]);
        body_sum_[body] = of_body;
      }
    });
    for (int body = 0; body < bodies; ++body) sum[body_group_[body]] += body_sum_[body];
  }

  std::vector<int> body_start_, row_start_, black_start_, body_group_;
  std::vector<OfBody> by_body_;
  std::vector<OfRow> by_row_;
  mutable std::vector<Real> body_sum_;
};

/// Sum of each floating group's conductances to what is around it, couplings not counted; 0 for groups of given
/// potential.
template <class Real>
std::vector<Real> group_diagonals(const LaplaceProblem& problem, const Level& level, const LinkLists<Real>& links,
                                  parallel::Team& team) {
  std::vector<Real> diagonal(problem.groups.size(), 0);
  links.add_conductances(team, diagonal.data());
  const auto group = [&](int body) { return problem.bodies[body].group; };
  for (const PairLink& pair : level.pairs) {
    diagonal[group(pair.body_a)] += static_cast<Real>(pair.conductance);
    diagonal[group(pair.body_b)] += static_cast<Real>(pair.conductance);
  }
  for (const SideLink& link : level.side_links)
    if (link.body >= 0) diagonal[group(link.body)] += static_cast<Real>(link.conductance);
  for (std::size_t g = 0; g < diagonal.size(); ++g)
    if (!problem.groups[g].floating) diagonal[g] = 0;
  return diagonal;
}

/// The right-hand side of a level's system, by slot into `cell` and by group into `group`: charges / permittivity and
/// what groups and sides of given potential bring, in units of `scale` (V).
template <class Real>
void write_right_hand_side(const LaplaceProblem& problem, const Level& level, double scale, Real* cell, Real* group) {
  const auto in_units = [scale](double value) { return static_cast<Real>(value / scale); };
  std::fill_n(cell, level.layout.size(), Real{0});
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    group[g] = problem.groups[g].floating ? in_units(problem.groups[g].charge / problem.permittivity) : Real{0};
  const auto group_of = [&](int body) { return problem.bodies[body].group; };
  const auto add_to_body = [&](int body, double value) {
    if (problem.groups[group_of(body)].floating) group[group_of(body)] += in_units(value);
  };
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const Group& own = problem.groups[group_of(static_cast<int>(body))];
    if (own.floating || own.potential == 0) continue;
    for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m)
      cell[level.links[m].cell] += in_units(level.links[m].conductance * own.potential);
  }
  for (const PairLink& pair : level.pairs) {
    const Group &a = problem.groups[group_of(pair.body_a)], &b = problem.groups[group_of(pair.body_b)];
    if (!b.floating) add_to_body(pair.body_a, pair.conductance * b.potential);
    if (!a.floating) add_to_body(pair.body_b, pair.conductance * a.potential);
  }
  for (const SideLink& link : level.side_links) {
    if (link.cell >= 0)
      cell[link.cell] += in_units(link.conductance * link.potential);
    else
      add_to_body(link.body, link.conductance * link.potential);
  }
  for (const FixedCoupling& coupling : level.fixed_couplings)
    group[coupling.group] += in_units(coupling.conductance * coupling.potential);
}

}  // namespace lichtenberg::laplace
