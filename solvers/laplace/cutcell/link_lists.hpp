#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// A level's links between fluid cells and floating groups, in the two orders that loops need: by row of the cell, for
/// what the groups' potentials bring the cells while a sweep passes, and by body, for what the cells bring the groups.
/// Links to groups of given potential are in the diagonal and in the right-hand side, and no loop need pass them.
template <class Real>
class LinkLists {
 public:
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team) {
    const int rows = level.layout.ny, chunks = 4 * team.size();
    list_runs(problem, level);
    row_start_ = level.row_start;
    row_end_.resize(rows);
    by_row_.resize(level.links.size());
    team.for_each(chunks, [&](int k) {
      const std::size_t runs = runs_.size();
      for (std::size_t n = runs * k / chunks; n < runs * (k + 1) / chunks; ++n)
        for (int m = runs_[n].start; m < runs_[n].end; ++m) {
          const FluidLink& link = level.links[m + runs_[n].fixed_before];
          by_body_[m] = {static_cast<std::int32_t>(link.cell), static_cast<Real>(link.conductance)};
        }
      for (int j = rows * k / chunks; j < rows * (k + 1) / chunks; ++j) list_row(level, j);
    });
  }

  /// What the groups at `potential` bring the cells of row j: effect(cell, conductance * potential).
  template <class Effect>
  void add_to_row(int j, const Real* potential, const Effect& effect) const {
    for (int m = row_start_[j]; m < row_end_[j]; ++m)
      effect(by_row_[m].cell, by_row_[m].conductance * potential[by_row_[m].group]);
  }

  /// Row j's links, in the order of its cells.
  int row_start(int j) const { return row_start_[j]; }
  int row_end(int j) const { return row_end_[j]; }
  std::int32_t cell(int link) const { return by_row_[link].cell; }
  /// What the groups at `potential` bring a cell whose links are those from `first` up to before `end`.
  Real flux(int first, int end, const Real* potential) const {
    Real flux = 0;
    for (int m = first; m < end; ++m) flux += by_row_[m].conductance * potential[by_row_[m].group];
    return flux;
  }

  /// Takes these of the level's links out of the sums over groups; they are of floating ones.
  void leave_out(const Level& level, const std::vector<int>& links) {
    for (const int m : links) by_body_[m - fixed_before_[level.links[m].body]].conductance = 0;
  }

  /// Sums conductance * v over each group's links and adds it to `sum` [groups].
  void add_to_groups(parallel::Team& team, const Real* v, Real* sum) const {
    add_of_links(team, sum, [v](const OfBody& link) { return link.conductance * v[link.cell]; });
  }

  /// Adds each floating group's conductances to `sum` [groups].
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
  /// Some links of one body, in by_body_, before which the level's list has so many of fixed groups.
  struct Run {
    int group, start, end, fixed_before;
  };

  void list_runs(const LaplaceProblem& problem, const Level& level) {
    constexpr int links_a_run = 512;  // more have long bodies, and what coarse grids make of a group of thin ones
    const int bodies = static_cast<int>(problem.bodies.size());
    runs_.clear();
    fixed_before_.resize(bodies);
    group_or_none_.resize(bodies);
    int links = 0;
    for (int body = 0; body < bodies; ++body) {
      const int group = problem.bodies[body].group;
      group_or_none_[body] = problem.groups[group].floating ? group : -1;
      fixed_before_[body] = level.link_start[body] - links;
      if (group_or_none_[body] < 0) continue;
      const int end = links + level.link_start[body + 1] - level.link_start[body];
      for (; links < end; links = runs_.back().end)
        runs_.push_back({group, links, std::min(links + links_a_run, end), fixed_before_[body]});
    }
    by_body_.resize(links);
    run_sum_.resize(runs_.size());
  }

  /// A row's links have as much room as if all were of floating groups.
  void list_row(const Level& level, int j) {
    int at = row_start_[j];
    for (int m = row_start_[j]; m < row_start_[j + 1]; ++m) {
      const RowLink& link = level.row_links[m];
      const int group = group_or_none_[link.body];
      if (group >= 0) by_row_[at++] = {link.cell, group, static_cast<Real>(link.conductance)};
    }
    row_end_[j] = at;
  }

  template <class Term>
  void add_of_links(parallel::Team& team, Real* sum, const Term& term) const {
    const std::size_t runs = runs_.size();
    constexpr int links_a_chunk = 2048;
    const int chunks = std::clamp(static_cast<int>(by_body_.size()) / links_a_chunk, 1, 4 * team.size());
    team.for_each(chunks, [&](int k) {
      for (std::size_t n = runs * k / chunks; n < runs * (k + 1) / chunks; ++n) {
        Real of_run = 0;
        for (int m = runs_[n].start; m < runs_[n].end; ++m) of_run += term(by_body_[m]);
        run_sum_[n] = of_run;
      }
    });
    for (std::size_t n = 0; n < runs; ++n) sum[runs_[n].group] += run_sum_[n];
  }

  std::vector<Run> runs_;
  std::vector<OfBody> by_body_;
  std::vector<int> fixed_before_, group_or_none_;  // by body
  std::vector<int> row_start_, row_end_;
  std::vector<OfRow> by_row_;
  mutable std::vector<Real> run_sum_;
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

/// All links of unknowns to given potentials (V): to_cell(slot, conductance, potential) and to_group(group,
/// conductance, potential).
template <class ToCell, class ToGroup>
void for_each_given(const LaplaceProblem& problem, const Level& level, const ToCell& to_cell, const ToGroup& to_group) {
  const auto group_of = [&](int body) { return problem.bodies[body].group; };
  const auto add_to_body = [&](int body, double conductance, double potential) {
    if (problem.groups[group_of(body)].floating) to_group(group_of(body), conductance, potential);
  };
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const Group& own = problem.groups[group_of(static_cast<int>(body))];
    if (own.floating) continue;
    for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m)
      to_cell(level.links[m].cell, level.links[m].conductance, own.potential);
  }
  for (const PairLink& pair : level.pairs) {
    const Group &a = problem.groups[group_of(pair.body_a)], &b = problem.groups[group_of(pair.body_b)];
    if (!b.floating) add_to_body(pair.body_a, pair.conductance, b.potential);
    if (!a.floating) add_to_body(pair.body_b, pair.conductance, a.potential);
  }
  for (const SideLink& link : level.side_links) {
    if (link.cell >= 0)
      to_cell(link.cell, link.conductance, link.potential);
    else
      add_to_body(link.body, link.conductance, link.potential);
  }
  for (const FixedCoupling& coupling : level.fixed_couplings)
    to_group(coupling.group, coupling.conductance, coupling.potential);
}

/// The right-hand side of a level's system, by slot into `cell` and by group into `group`: charges / permittivity and
/// what groups and sides of given potential bring, in units of `scale` (V).
template <class Real>
void write_right_hand_side(const LaplaceProblem& problem, const Level& level, double scale, Real* cell, Real* group) {
  const auto in_units = [scale](double value) { return static_cast<Real>(value / scale); };
  std::fill_n(cell, level.layout.size(), Real{0});
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    group[g] = problem.groups[g].floating ? in_units(problem.groups[g].charge / problem.permittivity) : Real{0};
  for_each_given(
      problem, level, [&](std::ptrdiff_t slot, double c, double given) { cell[slot] += in_units(c * given); },
      [&](int g, double c, double given) { group[g] += in_units(c * given); });
}

}  // namespace lichtenberg::laplace
