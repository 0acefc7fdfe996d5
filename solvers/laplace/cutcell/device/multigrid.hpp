#pragma once

#include <map>
#include <memory>

#include "solvers/laplace/cutcell/device/coarsest.hpp"
#include "solvers/laplace/cutcell/device/cycle.hpp"
#include "solvers/laplace/cutcell/device/grids.hpp"
#include "solvers/laplace/cutcell/device/problem.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"

namespace lichtenberg::laplace::device {

/// The grids and the V-cycle on them (../multigrid.hpp). Where groups are coupled directly, each sweep over conductors
/// is two Jacobi sweeps in place of one of Gauss-Seidel.
template <class Executor>
class DeviceMultigrid {
 public:
  DeviceMultigrid(const Executor& run, const LaplaceProblem& problem, int nx, int ny, LinkFormula formula)
      : run_(run), coarsest_(run) {
    for (const GridSize& size : grid_sizes(nx, ny))
      grids_.emplace_back(run, size.nx, size.ny, problem.size.x / size.nx, formula, grids_.empty());
  }

  void build(const LaplaceProblem& problem, const ProblemView& view) {
    recordings_.clear();
    if (levels() == 1) {
      only_.resize(grids_[0].view().layout.size());
      only_.zero();
    }
    problem_ = view;
    const GridView* finer = nullptr;
    for (DeviceGrid<Executor>& grid : grids_) {
      grid.build(view, finer && unresolved(problem, grid.view().h), finer);
      finer = &grid.view();
    }
    coarsest_.build(problem, grids_.back().view());
  }

  const DeviceGrid<Executor>& finest() const { return grids_.front(); }
  int levels() const { return static_cast<int>(grids_.size()); }
  long coarse_unknowns() const { return coarsest_.unknowns(); }

  /// z = M r
  void apply(const double* r, double* z) {
    take_residual(run_, problem_, grids_[0].view(), r);
    apply(z);
  }

  /// z = M r with the residual r that has been taken (TakeResidual).
  void apply(double* z) {
    Recordings& recordings = recordings_[z];
    if (coarsest_.on_device()) {
      run_.run(recordings.first, [&] {
        go_down(z);
        solve_coarsest(z);
        go_up(z);
      });
      return;
    }
    run_.run(recordings.first, [&] { go_down(z); });
    solve_coarsest(z);
    run_.run(recordings.second, [&] { go_up(z); });
  }

  template <class V>
  void down(int l, V* v) {
    const GridView &grid = grids_[l].view(), &coarse = grids_[l + 1].view();
    // Conductors first: a conductor's charge spreads into its potential before the cells see it.
    if (grid.direct_links > 0) {
      relax_direct_links(run_, problem_, grid, grid.charge, grid.phi, grid.phi_next);
      run_.copy(grid.phi, grid.phi_next, problem_.groups * sizeof(float));
    }
    add_potentials(grid, grid.phi, true, true);
    sweep_from_zero(run_, grid, v);
    leave_residual(run_, grid, static_cast<const V*>(v), residual_of(v));
    restrict_residual(run_, problem_, grid, coarse, residual_of(v));
    if (coarse.newly_absorbed > 0) {
      leave_group_residual(run_, problem_, grid, static_cast<const V*>(v));
      restrict_absorbed(run_, problem_, coarse, grid.flux);
    }
    if (coarse.unknown_groups > 0) restrict_groups(run_, problem_, grid, coarse, static_cast<const V*>(v));
  }

  /// The mirror image of `down`: black, red, conductors.
  template <class V>
  void up(int l, V* v) {
    const GridView &grid = grids_[l].view(), &coarse = grids_[l + 1].view();
    fill_covered(run_, coarse, grids_[l + 1].covered());
    if (coarse.newly_absorbed > 0) interpolate_absorbed(run_, problem_, coarse);
    add_potentials(grid, coarse.phi, false, true);
    prolongate_and_relax_black(run_, problem_, grid, coarse, v);
    add_potentials(grid, coarse.phi, true, false);
    relax_red(run_, grid, v);
    if (grid.unknown_groups == 0) return;
    relax_groups(run_, problem_, grid, static_cast<const V*>(v));
    if (grid.direct_links == 0) {
      run_.copy(grid.phi, grid.phi_next, problem_.groups * sizeof(float));
      return;
    }
    add(run_, problem_.groups, coarse.phi, grid.phi);
    relax_direct_links(run_, problem_, grid, grid.flux, grid.phi, grid.phi_next);
    relax_direct_links(run_, problem_, grid, grid.flux, grid.phi_next, grid.phi);
  }

 private:
  struct Recordings {
    typename Executor::Recording first, second;
  };

  void go_down(double* z) {
    if (levels() > 1) down(0, z);
    for (int l = 1; l + 1 < levels(); ++l) down(l, grids_[l].view().v);
  }

  void go_up(double* z) {
    for (int l = levels() - 2; l > 0; --l) up(l, grids_[l].view().v);
    if (levels() > 1) up(0, z);
    widen(run_, problem_.groups, grids_[0].view().phi, z + grids_[0].view().layout.size());
  }

  void add_potentials(const GridView& grid, const float* phi, bool red, bool black) {
    if (grid.unknown_groups == 0) return;
    add_group_potentials(run_, grid, phi, red, black);
    if (grid.floating_thin_conductors > 0) add_thin_conductor_potentials(run_, problem_, grid, phi, red, black);
  }

  /// Whether a grid of cells of size h leaves a disk unresolved.
  static bool unresolved(const LaplaceProblem& problem, double h) {
    std::vector<int> members(problem.groups.size(), 0);
    for (const Body& body : problem.bodies) ++members[body.group];
    for (const Body& body : problem.bodies)
      if (!is_resolved(outline_in_cells(body.shape, h),
                       problem.groups[body.group].floating && members[body.group] == 1))
        return true;
    return false;
  }

  void solve_coarsest(double* z) {
    const GridView& grid = grids_.back().view();
    if (levels() > 1) {
      coarsest_.solve(grid, grid.v);
      return;
    }
    // The finest grid is the coarsest: its potentials are double.
    coarsest_.solve(grid, only_.data());
    widen(run_, grid.layout.size(), only_.data(), z);
  }

  const Executor& run_;
  std::vector<DeviceGrid<Executor>> grids_;
  ProblemView problem_{};
  Coarsest<Executor> coarsest_;
  std::map<double*, Recordings> recordings_;  // by z
  parallel::Array<float, Executor> only_{run_};
};

}  // namespace lichtenberg::laplace::device
