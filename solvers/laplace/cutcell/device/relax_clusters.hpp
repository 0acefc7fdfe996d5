#pragma once

// Groups whose direct links outweigh their links to cells, on the device: how they are relaxed.

#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

/// Threads that share the sum over a group's direct links.
constexpr int group_lanes = 8;

/// A grid's clusters as the device has them (Clusters).
struct ClusterView {
  const int *row, *group, *first, *size;
  const long* start;
  const double* inverse;

  LICHTENBERG_HOST_DEVICE int size_of(int g) const { return row[g] < 0 ? 0 : size[row[g]]; }
  /// What the t-th of the cluster of g makes of its part of `rhs`.
  template <class Real>
  LICHTENBERG_HOST_DEVICE double value(int g, int t, const Real* rhs) const {
    const int own = row[g];
    return inverse[start[own] + t] * rhs[group[first[own] + t]];
  }
  LICHTENBERG_HOST_DEVICE bool join(int g, int h) const {
    return row[g] >= 0 && row[h] >= 0 && first[row[g]] == first[row[h]];
  }
};

/// What the cycle's direct links bring a group from others that are not of its cluster, for sums over its links.
/// Groups of given potential have 0 in `phi`: the right-hand side knows of them.
struct CycleFluxes {
  ProblemView problem;
  GridView grid;
  const float* phi;
  const float* more = nullptr;    ///< is added to phi; null: nothing
  const float* before = nullptr;  ///< is taken off for groups in a cluster, which were in balance then; null: nothing
  LICHTENBERG_HOST_DEVICE int count(int g) const {
    return grid.may_link_groups() ? grid.cycle_links_of(problem, g) : 0;
  }
  LICHTENBERG_HOST_DEVICE float value(int g, int t) const {
    const DirectLink& link = grid.cycle_link(problem, g, t);
    if (link.is_to_electrode()) return 0;
    const int other = problem.group_of[link.other];
    if (grid.groups.clusters && grid.groups.clusters->join(g, other)) return 0;
    float potential = more ? phi[other] + more[other] : phi[other];
    if (before && grid.groups.clusters->row[g] >= 0) potential -= before[other];
    return static_cast<float>(link.conductance) * potential;
  }
};

/// phi = what `rhs` makes of the groups' potentials: of a cluster's together, of any other by its diagonal. `z`:
/// becomes the potentials too, without rounding to phi's precision; null: nothing.
template <class Executor, class Real>
void solve_clusters(const Executor& run, ProblemView problem, GridView grid, const Real* rhs, float* phi,
                    double* z = nullptr) {
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.groups.clusters->size_of(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return grid.groups.clusters->value(g, t, rhs); },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        if (grid.groups.clusters->row[g] < 0) sum = rhs[g] * grid.groups.inverse_diagonal[g];
        phi[g] = static_cast<float>(sum);
        if (z) z[g] = sum;
      });
}

/// x = what `rhs` makes of the groups' potentials by all that links them to each other, couplings and direct links.
template <class Executor>
void solve_exactly(const Executor& run, ProblemView problem, GridView grid, const double* rhs, double* x) {
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.groups.exact_clusters->size_of(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return grid.groups.exact_clusters->value(g, t, rhs); },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        const double diagonal = grid.groups.diagonal[g];
        x[g] = !(diagonal > 0) ? 0.0 : grid.groups.exact_clusters->row[g] < 0 ? rhs[g] / diagonal : sum;
      });
}

/// One Jacobi sweep over the groups' potentials, all arrays by group.
struct GroupSweep {
  const float* flux;        ///< what cells bring, with the groups' charges but where there are clusters; or the charges
  const float* phi;         ///< potentials before the sweep
  const float* correction;  ///< is added to phi; null: nothing
  float* next;              ///< becomes the potentials after it
  double* z = nullptr;      ///< becomes these, too; null: nothing
};

/// A sweep over all groups: from their charges, what cells bring, and what comes from other clusters. In double
/// precision: rounding of what couplings carry is in the charges, and cancels.
template <class Executor>
void relax_clusters(const Executor& run, ProblemView problem, GridView grid, const GroupSweep& sweep) {
  const CycleFluxes outside{problem, grid, sweep.phi, sweep.correction};
  const float* flux = sweep.flux == grid.cycle.charge ? nullptr : sweep.flux;
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return outside.count(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return outside.value(g, t); },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        grid.cycle.group_rhs[g] = static_cast<double>(grid.cycle.charge[g]) + (flux ? flux[g] + sum : sum);
      });
  solve_clusters(run, problem, grid, grid.cycle.group_rhs, sweep.next, sweep.z);
}

}  // namespace lichtenberg::laplace::device
