#pragma once

// Relaxation of groups whose direct links outweigh their links to cells.

#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

/// Number of threads that share a sum over a group's links to other groups, such as direct links (gap conductances). A
/// group is a set of bodies with one potential.
constexpr int group_lanes = 8;

/// Clusters of a grid as device pointers (Clusters). A cluster is a set of groups, mostly with large conductances
/// between them, relaxed together by an inverse matrix. A group is a set of bodies with one potential.
struct ClusterView {
  const int *row, *group, *first, *size;
  const long* start;
  const double* inverse;

  /// Returns the number of groups (bodies with one potential) in g's cluster (groups solved together); 0 outside all
  /// clusters.
  LICHTENBERG_HOST_DEVICE int size_of(int g) const { return row[g] < 0 ? 0 : size[row[g]]; }
  /// Returns the contribution of the t-th group (bodies with one potential) of g's cluster (groups solved together) in
  /// `rhs` to the potential of g: one term of inverse * rhs.
  template <class Real>
  LICHTENBERG_HOST_DEVICE double value(int g, int t, const Real* rhs) const {
    const int own = row[g];
    return inverse[start[own] + t] * rhs[group[first[own] + t]];
  }
  /// Returns true if groups g and h are in the same cluster (groups solved together). A group is a set of bodies with
  /// one potential.
  LICHTENBERG_HOST_DEVICE bool join(int g, int h) const {
    return row[g] >= 0 && row[h] >= 0 && first[row[g]] == first[row[h]];
  }
};

/// Flux to a group (bodies with one potential) from groups outside its cluster (groups solved together), through
/// conductances between groups in the V-cycle. It adds terms to a sum over the group's links to cells. Groups of given
/// potential have 0 in `phi`: they are on the right-hand side.
struct CycleFluxes {
  ProblemView problem;
  GridView grid;
  const float* phi;
  /// Potentials added to phi; null: nothing.
  const float* more = nullptr;
  /// Potentials subtracted for groups in a cluster, whose residual was zero then; null: nothing.
  const float* before = nullptr;
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

/// Solves for the groups' potentials phi from the right-hand sides `rhs`. Uses the inverse matrix of each cluster
/// (groups solved together), and the diagonal for other groups. `z`: also receives the potentials, in double precision;
/// null: unused.
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

/// Solves for the groups' potentials x from the right-hand sides `rhs` with all couplings and direct links (gap
/// conductances), for given potentials of the cells. A coupling is a lumped capacitance between groups. A group is a
/// set of bodies with one potential.
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

/// Arrays of one Jacobi sweep over the groups' potentials, all by group (bodies with one potential).
struct GroupSweep {
  /// Flux from cells, with the groups' charges if there are no clusters; or the charges alone.
  const float* flux;
  /// Potentials before the sweep.
  const float* phi;
  /// Potentials added to phi; null: nothing.
  const float* correction;
  /// Receives the potentials after the sweep.
  float* next;
  /// Also receives the potentials after the sweep, in double precision; null: unused.
  double* z = nullptr;
};

/// Relaxes all groups (bodies with one potential) from their charges, the fluxes from cells and the fluxes from groups
/// outside the own cluster. A cluster is a set of groups solved together. It works in double precision, because the
/// charges contain the rounding of couplings' fluxes, which cancels.
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
