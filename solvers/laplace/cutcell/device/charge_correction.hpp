#pragma once

// Correction of charges (CutCellOperator::balance): shifts each group's potential, and all potentials together. Each
// group's charge and the sum of all charges become exact to rounding.

#include "solvers/laplace/cutcell/device/operator.hpp"
#include "solvers/laplace/cutcell/level_sums.hpp"

namespace lichtenberg::laplace::device {

/// Arrays of the correction that makes charges exact, by group (bodies with one potential), and the common shift of all
/// potentials, `level`.
struct ChargeCorrection {
  /// Residual of each group's equation, and the shift of potentials that removes it.
  double *residual, *shift;
  /// Conductance of each group to given potentials, and the fraction of a common shift that the group does not follow.
  double *hold, *held;
  /// Sum of the conductances of each group's links to cells; sum of conductance times the cells' potentials.
  double *to_cells, *from_cells;
  /// Residual, search direction and its image in the conjugate gradients of SolveGroups.
  double *r, *p, *q;
  /// Common shift of all potentials (one value).
  double* level;
  /// Whether a group has a direct link to another unknown group; lists of such groups.
  int *is_linked, *linked;
};

/// Sums over a group's direct links (gap conductances to other conductors). `flux`: from floating groups (bodies with
/// one unknown potential); `hold`: conductance to given potentials; `others`: number of links to unknown groups.
struct DirectSums {
  double flux = 0, hold = 0, others = 0;
  LICHTENBERG_HOST_DEVICE DirectSums& operator+=(const DirectSums& other) {
    flux += other.flux;
    hold += other.hold;
    others += other.others;
    return *this;
  }
};

/// Solution of the equations of groups (bodies with one potential) with direct links (gap conductances) to each other,
/// for given potentials of the cells. It solves for two right-hand sides by conjugate gradients in one thread block.
/// Such groups form mostly pairs and short chains, which need few iterations. Each thread has a list of its groups,
/// because few of thousands are linked.
struct SolveGroups {
  ProblemView problem;
  GridView grid;
  ChargeCorrection correction;

  static constexpr int threads = 1024, most = 400;
  static constexpr double enough = 1e-24;  // reduction of the residual's norm squared
  static constexpr std::size_t bytes = threads * (sizeof(double) + sizeof(int));

  /// Lists the linked groups (bodies with one potential) and computes their `shift` from `residual` and `held` from
  /// `hold`.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int) const {
    list_linked(block);
    solve(block, correction.residual, correction.shift);
    solve(block, correction.hold, correction.held);
  }

 private:
  /// Returns the array with the number of linked groups in each thread's list.
  template <class Block>
  LICHTENBERG_HOST_DEVICE static int* counts(const Block& block) {
    return reinterpret_cast<int*>(block.template memory<double>() + threads);
  }
  template <class Block>
  LICHTENBERG_HOST_DEVICE void list_linked(const Block& block) const {
    constexpr int at_once = 8;  // independent reads
    int *count = counts(block), *linked = correction.linked;
    block.each(threads, [&](int t) {
      int found = 0;
      for (int first = t; first < problem.groups; first += at_once * threads) {
        bool is_linked[at_once];
        for (int k = 0; k < at_once; ++k) {
          const int g = first + k * threads;
          is_linked[k] = g < problem.groups && correction.is_linked[g];
        }
        for (int k = 0; k < at_once; ++k)
          if (is_linked[k]) linked[t + threads * found++] = first + k * threads;
      }
      count[t] = found;
    });
  }
  /// Calls f(g) for the linked groups g in the list of thread t.
  template <class F>
  LICHTENBERG_HOST_DEVICE void each_of(const int* count, int t, F f) const {
    for (int k = 0; k < count[t]; ++k) f(correction.linked[t + threads * k]);
  }
  /// Calls f(g) for the linked groups g in the lists of all threads.
  template <class Block, class F>
  LICHTENBERG_HOST_DEVICE void each(const Block& block, F f) const {
    const int* count = counts(block);
    block.each(threads, [&](int t) { each_of(count, t, f); });
  }
  /// Returns the sum of value(g) over all linked groups g. Overwrites the block's memory. A group is a set of bodies
  /// with one potential.
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
  /// Returns row g of the product of the groups' matrix and x. A group is a set of bodies with one potential.
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
  /// Solves the listed groups' equations for x by conjugate gradients with diagonal preconditioning, at most `most`
  /// steps. A group is a set of bodies with one potential.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void solve(const Block& block, const double* rhs, double* x) const {
    double *r = correction.r, *p = correction.p, *q = correction.q;
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

/// Computes the residuals of the groups' equations and the groups' conductances to given potentials. Then solves the
/// equations with either as right-hand side, for `shift` and `held` of `correction`. A group is a set of bodies with
/// one potential.
template <class Executor>
void compute_group_equations(const Executor& run, ProblemView problem, GridView grid, SolveVectors v,
                             ChargeCorrection correction) {
  const double *b = v.b, *x = v.x;
  const int cells = static_cast<int>(grid.layout.size());
  const bool is_coupled = problem.couplings.start, direct_links = grid.may_have(Items::direct_links);
  double* carried = correction.q;
  run.sum_pieces(
      grid.link_pieces(problem), grid.pieces.partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link]; }, parallel::NoAddedValues{},
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { correction.to_cells[g] = sum; });
  sum_by_group(
      run, grid, links_by_group(problem, grid, grid.pieces.partial),
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link] * x[grid.links.slot[link]]; },
      parallel::NoAddedValues{}, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { correction.from_cells[g] = sum; });
  if (is_coupled) {
    run.fill(carried, 0, problem.groups * sizeof(double));
    add_couplings(run, problem, x + cells, carried);
  }
  const DirectFluxes<double> direct{problem, grid, x + cells};
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return direct.count(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
        const int other = link.is_to_electrode() ? -1 : problem.group_of[link.other];
        if (other < 0 || !problem.floating[other]) return DirectSums{direct.value(g, t), link.conductance};
        return DirectSums{direct.value(g, t), 0, grid.groups.diagonal[other] > 0 ? 1.0 : 0.0};
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, const DirectSums& sums) {
        const double diagonal = grid.groups.diagonal[g];
        const bool unknown = diagonal > 0;
        double flux = correction.from_cells[g] + sums.flux, hold = sums.hold;
        if (is_coupled) {
          flux -= carried[g];
          hold += to_given(problem, g, [](int) { return 1.0; });
        }
        correction.residual[g] = unknown ? b[cells + g] + flux - diagonal * x[cells + g] : 0.0;
        correction.hold[g] = unknown ? hold : 0.0;
        correction.is_linked[g] = unknown && sums.others > 0;
        correction.shift[g] = unknown ? correction.residual[g] / diagonal : 0.0;
        correction.held[g] = unknown ? hold / diagonal : 0.0;
      });
  if (is_coupled) {
    solve_exactly(run, problem, grid, correction.residual, correction.shift);
    solve_exactly(run, problem, grid, correction.hold, correction.held);
  } else if (direct_links) {
    run.template for_each_block<SolveGroups::threads>(1, SolveGroups::bytes, SolveGroups{problem, grid, correction});
  }
}

/// Computes the common shift of all potentials (`correction.level`) from the sum of the cells' equations. `x`:
/// potentials in units of `unit` (V).
template <class Executor>
void compute_level(const Executor& run, ProblemView problem, GridView grid, const double* x, double unit,
                   ChargeCorrection correction) {
  const int links = grid.capacity[Items::links], faces = 4 * problem.faces,
            cells = static_cast<int>(grid.layout.size());
  const long all = static_cast<long>(links) + faces + problem.groups;
  const auto value = [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (k < links) {
      if (k >= grid.number[Items::links] || problem.floating[grid.links.group[k]]) return LevelSums{};
      return LevelSums::from_link(grid.links.conductance[k], problem.potential[grid.links.group[k]] / unit,
                                  x[grid.links.slot[k]]);
    }
    if (k < links + faces) {
      const int side = (k - links) / problem.faces, face = (k - links) % problem.faces;
      if (!problem.electrode[side] || face >= faces_of(grid.layout, side)) return LevelSums{};
      const auto [i, j] = cell_at_face(grid.layout, side, face);
      const int slot = slot_of(grid.layout, i, j);
      if (!grid.cells.owner[slot].is_fluid()) return LevelSums{};
      return LevelSums::from_link(2, problem.side_potential[k - links] / unit, x[slot]);
    }
    const int g = k - links - faces;
    if (!(grid.groups.diagonal[g] > 0)) return LevelSums{};
    return LevelSums::from_group(correction.to_cells[g], x[cells + g] + correction.shift[g], correction.from_cells[g],
                                 correction.held[g]);
  };
  const auto finish = [=] LICHTENBERG_HOST_DEVICE(const LevelSums& sums) { *correction.level = sums.level(); };
  const Layout at = grid.layout;
  if (!at.is_divided()) return run.sum(all, value, finish);
  LevelSums* mine = values_of_ranks<LevelSums>(grid) + run.rank();
  run.sum(
      all,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        bool is_own = at.is_first();  // groups
        if (k < links) {
          is_own = k < grid.number[Items::links] && at.owns(grid.links.slot[k]);
        } else if (k < links + faces) {
          const int side = (k - links) / problem.faces, face = (k - links) % problem.faces;
          is_own = at.own.contains(cell_at_face(at, side, face).j);
        }
        return is_own ? value(k) : LevelSums{};
      },
      [=] LICHTENBERG_HOST_DEVICE(const LevelSums& sums) { *mine = sums; });
  add_ranks<LevelSums>(run, grid, 1, [=] LICHTENBERG_HOST_DEVICE(int, const LevelSums& sums) { finish(sums); });
}

/// Corrects the potentials so that each group's charge and the sum of all charges are exact to rounding. Shifts each
/// group (bodies with one potential) and all potentials together, as CutCellOperator::balance. Potentials are in units
/// of `unit` (V).
template <class Executor>
void correct_charges(const Executor& run, ProblemView problem, GridView grid, SolveVectors v, double unit,
                     ChargeCorrection correction) {
  double* x = v.x;
  compute_group_equations(run, problem, grid, v, correction);
  compute_level(run, problem, grid, x, unit, correction);
  const int cells = static_cast<int>(grid.layout.size());
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const double level = *correction.level;
    if (k < cells) {
      if (level != 0 && grid.cells.inverse_diagonal[k] > 0) x[k] += level;
      return;
    }
    const int g = k - cells;
    if (grid.groups.diagonal[g] > 0) x[k] += correction.shift[g] + level * (1 - correction.held[g]);
  });
}

}  // namespace lichtenberg::laplace::device
