#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/slabs.hpp"

namespace lichtenberg::laplace {

/// Links between fluid cells and floating groups of one grid, in two orders. A link is the conductance between a fluid
/// cell and a conductor next to it. A floating group is a set of bodies with one unknown potential. The list by row of
/// the cell serves for fluxes from groups to cells during a sweep. The list by body serves for fluxes from cells to
/// groups. Links to groups of given potential are not listed: they enter the matrix diagonal and the right-hand side
/// only. In a slab the list by row has the links of all stored rows; sums by group count the links of own rows only.
template <class Real>
class LinkLists {
 public:
  /// Builds the lists by row and by body from the links (conductances) of `level`, the geometry of one grid. `team`:
  /// threads.
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
          const bool counts = level.layout.owns(link.cell);
          by_body_[m] = {static_cast<std::int32_t>(link.cell), static_cast<Real>(counts ? link.conductance : 0.0)};
        }
      for (int j = rows * k / chunks; j < rows * (k + 1) / chunks; ++j) list_row(level, j);
    });
  }

  /// Calls effect(cell, flux) for each link in row j. `cell`: memory index of the fluid cell; flux: conductance *
  /// potential of the link's group (bodies with one potential). `potential` [groups].
  template <class Effect>
  void add_to_row(int j, const Real* potential, const Effect& effect) const {
    for (int m = row_start_[j]; m < row_end_[j]; ++m)
      effect(by_row_[m].cell, by_row_[m].conductance * potential[by_row_[m].group]);
  }

  /// Returns the index of the first link of row j in the list by rows. A link is the conductance between a fluid cell
  /// and a conductor. The links of a row are in the order of their cells.
  int row_start(int j) const { return row_start_[j]; }
  /// Returns the index after the last link of row j in the list by rows. A link is the conductance between a fluid cell
  /// and a conductor.
  int row_end(int j) const { return row_end_[j]; }
  /// Returns the slot (memory index) of the fluid cell of a link in the list by rows. A link is the conductance between
  /// a fluid cell and a conductor.
  std::int32_t cell(int link) const { return by_row_[link].cell; }
  /// Returns the sum of conductance * potential of the group over the links `first` to `end` - 1 of the list by rows.
  /// `potential` [groups]. A group is a set of bodies with one potential.
  Real flux(int first, int end, const Real* potential) const {
    Real flux = 0;
    for (int m = first; m < end; ++m) flux += by_row_[m].conductance * potential[by_row_[m].group];
    return flux;
  }

  /// Excludes links from the sums by group (add_to_groups, add_conductances) by setting their conductances to zero.
  /// `links`: indices in Level::links of links to floating groups (bodies with one unknown potential).
  void leave_out(const Level& level, const std::vector<int>& links) {
    for (const int m : links) by_body_[m - fixed_before_[level.links[m].body]].conductance = 0;
  }

  /// Adds to `sum` [groups] the sum of conductance * v over each floating group's links. `v`: potentials of cells by
  /// slot (memory index). A group is a set of bodies with one potential.
  void add_to_groups(parallel::Team& team, const Real* v, Real* sum) const {
    add_links(team, sum, [v](const BodyLink& link) { return link.conductance * v[link.cell]; });
  }

  /// Adds to `sum` [groups] the sum of the conductances of each floating group's links. A group is a set of bodies with
  /// one potential.
  void add_conductances(parallel::Team& team, Real* sum) const {
    add_links(team, sum, [](const BodyLink& link) { return link.conductance; });
  }

 private:
  struct BodyLink {
    std::int32_t cell;
    Real conductance;
  };
  struct RowEntry {
    std::int32_t cell, group;
    Real conductance;
  };
  /// Consecutive links (conductances) of one body to fluid cells, summed as one term; `start` and `end` are indices in
  /// by_body_. `fixed_before`: number of links to groups of given potential before them in Level::links.
  struct Run {
    int group, start, end, fixed_before;
  };

  void list_runs(const LaplaceProblem& problem, const Level& level) {
    constexpr int links_a_run = 512;  // exceeded by long bodies and by the subgrid conductors of a group
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

  /// Lists the links of row j to floating groups (bodies with one unknown potential). Each row has memory for all its
  /// links, also those to groups of given potential.
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
  void add_links(parallel::Team& team, Real* sum, const Term& term) const {
    const std::size_t runs = runs_.size();
    constexpr int links_a_chunk = 2048;
    const int chunks = std::clamp(static_cast<int>(by_body_.size()) / links_a_chunk, 1, 4 * team.size());
    team.for_each(chunks, [&](int k) {
      for (std::size_t n = runs * k / chunks; n < runs * (k + 1) / chunks; ++n) {
        Real run_sum = 0;
        for (int m = runs_[n].start; m < runs_[n].end; ++m) run_sum += term(by_body_[m]);
        run_sum_[n] = run_sum;
      }
    });
    for (std::size_t n = 0; n < runs; ++n) sum[runs_[n].group] += run_sum_[n];
  }

  std::vector<Run> runs_;
  std::vector<BodyLink> by_body_;
  // By body: links of fixed groups before its first; its group, or -1 if that is fixed.
  std::vector<int> fixed_before_, group_or_none_;
  std::vector<int> row_start_, row_end_;
  std::vector<RowEntry> by_row_;
  mutable std::vector<Real> run_sum_;
};

/// Computes the diagonal of each floating group's equation. It is the sum of the conductances of the group's links to
/// cells, conductors and sides. Couplings (lumped capacitances between groups) and links excluded by
/// LinkLists::leave_out() do not count. Groups of given potential get 0. A group is a set of bodies with one potential.
/// The sums are those of all processes.
template <class Real>
std::vector<Real> group_diagonals(const LaplaceProblem& problem, const Level& level, const LinkLists<Real>& links,
                                  parallel::Team& team) {
  std::vector<Real> diagonal(problem.groups.size(), 0);
  links.add_conductances(team, diagonal.data());
  const auto group = [&](int body) { return problem.bodies[body].group; };
  if (level.layout.is_first())
    for (const PairLink& pair : level.pairs) {
      diagonal[group(pair.body_a)] += static_cast<Real>(pair.conductance);
      diagonal[group(pair.body_b)] += static_cast<Real>(pair.conductance);
    }
  for (const SideLink& link : level.side_links)
    if (link.body >= 0) diagonal[group(link.body)] += static_cast<Real>(link.conductance);
  add_over_slabs(level.layout, diagonal.data(), std::ssize(diagonal));
  for (std::size_t g = 0; g < diagonal.size(); ++g)
    if (!problem.groups[g].floating) diagonal[g] = 0;
  return diagonal;
}

/// Calls a function for each link between an unknown and a given potential (V), to form right-hand sides. Arguments:
/// to_cell(slot, conductance, potential) for fluid cells and to_group(group, conductance, potential) for floating
/// groups (bodies with one unknown potential). A slot is the memory index of a cell. In a slab it lists the links of
/// all stored cells. Links to groups are listed by one process each, so that sums over processes count them once.
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
  const bool is_first = level.layout.is_first();
  for (const PairLink& pair : level.pairs) {
    if (!is_first) break;
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
    if (is_first) to_group(coupling.group, coupling.conductance, coupling.potential);
}

/// Computes the right-hand side of one grid's system, in units of `scale` (V). It is the sum of conductance * given
/// potential over links to given potentials, plus charge / permittivity for floating groups. `cell`: by slot (memory
/// index); `group`: by group, 0 for groups of given potential. A floating group is a set of bodies with one unknown
/// potential.
template <class Real>
void write_right_hand_side(const LaplaceProblem& problem, const Level& level, double scale, Real* cell, Real* group) {
  const auto in_units = [scale](double value) { return static_cast<Real>(value / scale); };
  std::fill_n(cell, level.layout.size(), Real{0});
  const bool is_first = level.layout.is_first();
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const Group& own = problem.groups[g];
    group[g] = own.floating && is_first ? in_units(own.charge / problem.permittivity) : Real{0};
  }
  for_each_given(
      problem, level, [&](std::ptrdiff_t slot, double c, double given) { cell[slot] += in_units(c * given); },
      [&](int g, double c, double given) { group[g] += in_units(c * given); });
  add_over_slabs(level.layout, group, std::ssize(problem.groups));
}

}  // namespace lichtenberg::laplace
