#pragma once

// Charges made exact (CutCellOperator::balance): each group's potential is shifted, and the level of all potentials
// together, until every group's charge and the sum of all charges are right to rounding.

#include "solvers/laplace/cutcell/device/operator.hpp"

namespace lichtenberg::laplace::device {

/// By group; `level`: one value.
struct BalanceView {
  double *residual, *shift;  ///< of the groups' equations; what takes it away
  double *hold, *held;       ///< direct links' conductances to given potentials; the shift that these would make
  double* hold_flux;         ///< what such links bring
  double *r, *p, *q;         ///< for the elimination
  double* level;
  int *is_linked, *linked;  ///< whether a group is linked directly to another unknown; lists of those that are
};

/// What links of floating groups and cells to given potentials bring and conduct.
struct GroundSums {
  double flux = 0, conductance = 0, others = 0;  // how many links are to unknowns
  LICHTENBERG_HOST_DEVICE GroundSums& operator+=(const GroundSums& other) {
    flux += other.flux;
    conductance += other.conductance;
    others += other.others;
    return *this;
  }
};

/// The equations for given cells of groups that are linked to each other, two right-hand sides, by conjugate gradients
/// in one block: they are coupled by direct links alone, mostly in pairs and short chains, which takes few iterations.
/// A thread has a list of the groups that it looks after, since of thousands few are linked.
struct SolveGroups {
  ProblemView problem;
  GridView grid;
  BalanceView balance;

  static constexpr int threads = 1024, most = 400;
  static constexpr double enough = 1e-24;  // of the residual's norm squared: of what is a correction of the tolerance
  static constexpr std::size_t bytes = threads * (sizeof(double) + sizeof(int));

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int) const {
    list_linked(block);
    solve(block, balance.residual, balance.shift);
    solve(block, balance.hold, balance.held);
  }

 private:
  /// By thread, how many are in its list.
  template <class Block>
  LICHTENBERG_HOST_DEVICE static int* counts(const Block& block) {
    return reinterpret_cast<int*>(block.template memory<double>() + threads);
  }
  template <class Block>
  LICHTENBERG_HOST_DEVICE void list_linked(const Block& block) const {
    constexpr int at_once = 8;  // that are waited for
    int *count = counts(block), *linked = balance.linked;
    block.each(threads, [&](int t) {
      int found = 0;
      for (int first = t; first < problem.groups; first += at_once * threads) {
        bool is_linked[at_once];
        for (int k = 0; k < at_once; ++k) {
          const int g = first + k * threads;
          is_linked[k] = g < problem.groups && balance.is_linked[g];
        }
        for (int k = 0; k < at_once; ++k)
          if (is_linked[k]) linked[t + threads * found++] = first + k * threads;
      }
      count[t] = found;
    });
  }
  /// f(g) for the groups of a thread's list.
  template <class F>
  LICHTENBERG_HOST_DEVICE void each_of(const int* count, int t, F f) const {
    for (int k = 0; k < count[t]; ++k) f(balance.linked[t + threads * k]);
  }
  /// The same of all lists.
  template <class Block, class F>
  LICHTENBERG_HOST_DEVICE void each(const Block& block, F f) const {
    const int* count = counts(block);
    block.each(threads, [&](int t) { each_of(count, t, f); });
  }
  /// The sum of value(g) over all that are listed, in memory[0] of the block's.
  template <class Block, class Value>
  LICHTENBERG_HOST_DEVICE double sum(const Block& block, Value value) const {
    double* part = block.template memory<double>();
    const int* count = counts(block);
    block.each(threads, [&](int t) {
      double own = 0;
      each_of(count, t, [&](int g) { own += value(g); });
      part[t] = own;
    });
    for (int half = threads / 2; half > 0; half /= 2) block.each(half, [&](int t) { part[t] += part[t + half]; });
    const double all = part[0];
    block.each(1, [](int) {});  // before it is written again
    return all;
  }
  LICHTENBERG_HOST_DEVICE double product(const double* x, int g) const {
    double sum = grid.groups.diagonal[g] * x[g];
    for (int k = 0; k < grid.direct_links_of(problem, g); ++k) {
      const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + k];
      if (link.is_to_electrode()) continue;
      const int other = problem.group_of[link.other];
      if (grid.groups.diagonal[other] > 0) sum -= link.conductance * x[other];
    }
    return sum;
  }
  template <class Block>
  LICHTENBERG_HOST_DEVICE void solve(const Block& block, const double* rhs, double* x) const {
    double *r = balance.r, *p = balance.p, *q = balance.q;
    const auto squared = [&](int g) { return r[g] * r[g] / grid.groups.diagonal[g]; };
    each(block, [&](int g) {
      x[g] = 0;
      r[g] = rhs[g];
      p[g] = r[g] / grid.groups.diagonal[g];
    });
    const double first = sum(block, squared);
    double now = first;
    for (int step = 0; step < most && now > enough * first; ++step) {
      each(block, [&](int g) { q[g] = product(p, g); });
      const double curvature = sum(block, [&](int g) { return p[g] * q[g]; });
      if (!(curvature > 0)) return;
      const double alpha = now / curvature;
      each(block, [&](int g) {
        x[g] += alpha * p[g];
        r[g] -= alpha * q[g];
      });
      const double last = now;
      now = sum(block, squared);
      const double beta = now / last;
      each(block, [&](int g) { p[g] = r[g] / grid.groups.diagonal[g] + beta * p[g]; });
    }
  }
};

/// What each group lacks, and what its direct links to given potentials bring and conduct; what takes either away of
/// groups that are linked to no other unknown.
template <class Executor>
void find_imbalance(const Executor& run, ProblemView problem, GridView grid, const double* b, const double* x,
                    double unit, double* partial, BalanceView balance) {
  const int cells = static_cast<int>(grid.layout.size());
  group_fluxes(run, problem, grid, x, partial, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
    const double diagonal = grid.groups.diagonal[g];
    balance.residual[g] = diagonal > 0 ? b[cells + g] + sum - diagonal * x[cells + g] : 0.0;
    if (!grid.may_have(Of::direct_links)) balance.shift[g] = diagonal > 0 ? balance.residual[g] / diagonal : 0.0;
  });
  if (!grid.may_have(Of::direct_links)) return;
  run.sum_segments(
      problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.groups.diagonal[g] > 0 ? grid.direct_links_of(problem, g) : 0; },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
        const int other = link.is_to_electrode() ? -1 : problem.group_of[link.other];
        if (other >= 0 && problem.floating[other]) return GroundSums{0, 0, grid.groups.diagonal[other] > 0 ? 1.0 : 0.0};
        const double given = other < 0 ? problem.side_potential[link.face()] : problem.potential[other];
        return GroundSums{link.conductance * (given / unit - x[cells + g]), link.conductance};
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, const GroundSums& sums) {
        const double diagonal = grid.groups.diagonal[g];
        balance.hold[g] = sums.conductance;
        balance.hold_flux[g] = sums.flux;
        balance.is_linked[g] = sums.others > 0;
        balance.shift[g] = diagonal > 0 ? balance.residual[g] / diagonal : 0.0;
        balance.held[g] = diagonal > 0 ? sums.conductance / diagonal : 0.0;
      });
}

/// The same where groups are coupled (CutCellOperator::balance_coupled), and what takes it away. The sum of all
/// equations would hold what couplings carry, and its rounding; so `hold_flux` and `r` become what links to cells
/// conduct and bring, for the sum of the cells' equations.
template <class Executor>
void balance_coupled_groups(const Executor& run, ProblemView problem, GridView grid, const double* b, const double* x,
                            double* partial, BalanceView balance) {
  const int cells = static_cast<int>(grid.layout.size());
  double *to_cells = balance.hold_flux, *from_cells = balance.r, *carried = balance.q;
  run.sum_pieces(
      grid.link_pieces(problem), partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link]; }, parallel::NoMore{},
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { to_cells[g] = sum; });
  run.sum_pieces(
      grid.link_pieces(problem), partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link] * x[grid.links.slot[link]]; },
      parallel::NoMore{}, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { from_cells[g] = sum; });
  run.fill(carried, 0, problem.groups * sizeof(double));
  add_couplings(run, problem, x + cells, carried);
  const DirectFluxes<double> direct{problem, grid, x + cells};
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.direct_links_of(problem, g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
        const bool given = link.is_to_electrode() || !problem.floating[problem.group_of[link.other]];
        return GroundSums{direct.value(g, t), given ? link.conductance : 0.0};
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, const GroundSums& sums) {
        const double diagonal = grid.groups.diagonal[g];
        const bool unknown = diagonal > 0;
        const double flux = from_cells[g] + sums.flux - carried[g];
        balance.residual[g] = unknown ? b[cells + g] + flux - diagonal * x[cells + g] : 0.0;
        balance.hold[g] = unknown ? sums.conductance + to_given(problem, g, [](int) { return 1.0; }) : 0.0;
      });
  solve_exactly(run, problem, grid, balance.residual, balance.shift);
  solve_exactly(run, problem, grid, balance.hold, balance.held);
}

/// From the sum of all equations, in which only links to given potentials are left, the level of all potentials.
template <class Executor>
void find_level(const Executor& run, ProblemView problem, GridView grid, const double* x, double unit,
                BalanceView balance) {
  const int links = grid.room[Of::links], faces = 4 * problem.faces, cells = static_cast<int>(grid.layout.size());
  const bool direct_links = grid.may_have(Of::direct_links);
  run.sum(
      static_cast<long>(links) + faces + problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        if (k < links) {
          if (k >= grid.number[Of::links] || problem.floating[grid.links.group[k]]) return GroundSums{};
          const double c = grid.links.conductance[k], given = problem.potential[grid.links.group[k]] / unit;
          return GroundSums{c * (given - x[grid.links.slot[k]]), c};
        }
        if (k < links + faces) {
          const int side = (k - links) / problem.faces, face = (k - links) % problem.faces;
          const Layout& at = grid.layout;
          if (!problem.electrode[side] || face >= (side < 2 ? at.ny : at.nx)) return GroundSums{};
          const int far = side == 1 ? at.nx - 1 : side == 3 ? at.ny - 1 : 0;
          const int slot = side < 2 ? slot_of(at, far, face) : slot_of(at, face, far);
          if (!grid.cells.cover[slot].is_fluid()) return GroundSums{};
          return GroundSums{2 * (problem.side_potential[k - links] / unit - x[slot]), 2};
        }
        const int g = k - links - faces;
        if (problem.couplings.start) {
          if (!(grid.groups.diagonal[g] > 0)) return GroundSums{};
          const double to_cells = balance.hold_flux[g], own = x[cells + g] + balance.shift[g];
          return GroundSums{to_cells * own - balance.r[g], to_cells * balance.held[g]};
        }
        GroundSums sums{problem.charge[g] / problem.permittivity / unit, 0};
        if (direct_links) {
          sums.flux += balance.hold_flux[g] - balance.hold[g] * balance.shift[g];
          sums.conductance += balance.hold[g] * (1 - balance.held[g]);
        }
        return sums;
      },
      [=] LICHTENBERG_HOST_DEVICE(const GroundSums& sums) {
        *balance.level = sums.conductance > 0 ? sums.flux / sums.conductance : 0.0;
      });
}

/// Makes the charges exact; potentials in units of `unit`, V.
template <class Executor>
void balance_charges(const Executor& run, ProblemView problem, GridView grid, const double* b, double unit,
                     double* partial, BalanceView balance, double* x) {
  const bool is_coupled = problem.couplings.start;
  if (is_coupled)
    balance_coupled_groups(run, problem, grid, b, x, partial, balance);
  else
    find_imbalance(run, problem, grid, b, x, unit, partial, balance);
  const bool are_held = is_coupled || grid.may_have(Of::direct_links);
  if (!is_coupled && are_held)
    run.template for_each_block<SolveGroups::threads>(1, SolveGroups::bytes, SolveGroups{problem, grid, balance});
  find_level(run, problem, grid, x, unit, balance);
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(static_cast<long>(cells) + problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const double level = *balance.level;
    if (k < cells) {
      if (level != 0 && grid.cells.inverse_diagonal[k] > 0) x[k] += level;
      return;
    }
    const int g = k - cells;
    if (grid.groups.diagonal[g] > 0) x[k] += balance.shift[g] + level * (are_held ? 1 - balance.held[g] : 1.0);
  });
}

}  // namespace lichtenberg::laplace::device
