#pragma once

#include <map>
#include <memory>

#include "solvers/laplace/cutcell/coarse.hpp"
#include "solvers/laplace/cutcell/device/cycle.hpp"
#include "solvers/laplace/cutcell/device/grids.hpp"
#include "solvers/laplace/cutcell/device/scene.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"

namespace lichtenberg::laplace::device {

/// The coarsest grid's system by a factorization on the host: right-hand side down, solution up.
template <class Executor>
class FactorizedCoarsest {
 public:
  explicit FactorizedCoarsest(const Executor& run) : run_(run) {}

  void build(const LaplaceProblem& problem, const GridView& grid) {
    if (!level_ || level_->layout.nx != grid.layout.nx || level_->layout.ny != grid.layout.ny)
      level_ = std::make_unique<Level>(problem, grid.layout.nx, grid.layout.ny);
    level_->build(problem, grid.formula);
    factor_.factorize(problem, *level_);
    f_.resize(level_->layout.size());
    v_.assign(level_->layout.size(), 0.0f);
    charge_.resize(problem.groups.size());
    phi_.assign(problem.groups.size(), 0.0f);
  }

  /// Fluid cells of v and phi from f and charge.
  void solve(const GridView& grid, float* v) {
    run_.to_host(f_.data(), grid.f, f_.size() * sizeof(float));
    run_.to_host(charge_.data(), grid.charge, charge_.size() * sizeof(float));
    factor_.solve(f_.data(), charge_.data(), v_.data(), phi_.data());
    run_.to_device(v, v_.data(), v_.size() * sizeof(float));
    run_.to_device(grid.phi, phi_.data(), phi_.size() * sizeof(float));
  }
  long unknowns() const { return factor_.unknowns(); }

 private:
  const Executor& run_;
  std::unique_ptr<Level> level_;
  CoarseSolver factor_;
  std::vector<float> f_, charge_, v_, phi_;
};

/// The grids and the V-cycle on them (../multigrid.hpp). Where groups are coupled directly, each sweep over conductors
/// is two Jacobi sweeps in place of one of Gauss-Seidel.
template <class Executor>
class Multigrid {
 public:
  Multigrid(const Executor& run, const LaplaceProblem& problem, int nx, int ny, LinkFormula formula)
      : run_(run), coarsest_(run) {
    for (const GridSize& size : resolving_grid_sizes(problem, nx, ny))
      grids_.emplace_back(run, size.nx, size.ny, problem.size.x / size.nx, formula, grids_.empty());
  }

  void build(const LaplaceProblem& problem, const SceneView& scene) {
    recordings_.clear();
    scene_ = scene;
    for (Grid<Executor>& grid : grids_) grid.build(scene);
    coarsest_.build(problem, grids_.back().view());
  }

  const Grid<Executor>& finest() const { return grids_.front(); }
  int levels() const { return static_cast<int>(grids_.size()); }
  long coarse_unknowns() const { return coarsest_.unknowns(); }

  /// z = M r
  void apply(const double* r, double* z) {
    Recordings& recordings = recordings_[{r, z}];
    run_.run(recordings.down, [&] {
      take_residual(run_, scene_, grids_[0].view(), r);
      down(0, z);
      for (int l = 1; l + 1 < levels(); ++l) down(l, grids_[l].view().v);
    });
    solve_coarsest(z);
    run_.run(recordings.up, [&] {
      for (int l = levels() - 2; l > 0; --l) up(l, grids_[l].view().v);
      if (levels() > 1) up(0, z);
      widen(run_, scene_.groups, grids_[0].view().phi, z + grids_[0].view().layout.size());
    });
  }

  template <class V>
  void down(int l, V* v) {
    if (l + 1 >= levels()) return;
    const GridView &grid = grids_[l].view(), &coarse = grids_[l + 1].view();
    // Conductors first: a conductor's charge spreads into its potential before the cells see it.
    if (grid.contacts > 0) {
      relax_contacts(run_, scene_, grid, grid.charge, grid.phi, grid.phi_next);
      run_.copy(grid.phi, grid.phi_next, scene_.groups * sizeof(float));
    }
    add_group_potentials(run_, grid, grid.phi, true, true);
    sweep_from_zero(run_, grid, v);
    restrict_residual(run_, scene_, grid, coarse, v);
    restrict_groups(run_, scene_, grid, coarse, v);
  }

  /// The mirror image: black, red, conductors.
  template <class V>
  void up(int l, V* v) {
    const GridView &grid = grids_[l].view(), &coarse = grids_[l + 1].view();
    fill_covered(run_, coarse, grids_[l + 1].covered());
    add_group_potentials(run_, grid, coarse.phi, false, true);
    prolongate_and_relax_black(run_, scene_, grid, coarse, v);
    add_group_potentials(run_, grid, coarse.phi, true, false);
    relax_red(run_, grid, v);
    relax_groups(run_, scene_, grid, static_cast<const V*>(v));
    if (grid.contacts == 0) {
      run_.copy(grid.phi, grid.phi_next, scene_.groups * sizeof(float));
      return;
    }
    add(run_, scene_.groups, coarse.phi, grid.phi);
    relax_contacts(run_, scene_, grid, grid.flux, grid.phi, grid.phi_next);
    relax_contacts(run_, scene_, grid, grid.flux, grid.phi_next, grid.phi);
  }

 private:
  struct Recordings {
    typename Executor::Recording down, up;
  };

  void solve_coarsest(double* z) {
    const GridView& grid = grids_.back().view();
    if (levels() > 1) {
      coarsest_.solve(grid, grid.v);
      return;
    }
    // The finest grid is the coarsest: its potentials are double.
    const std::size_t cells = grid.layout.size();
    only_.resize(cells);
    coarsest_.solve(grid, only_.data());
    widen(run_, cells, only_.data(), z);
  }

  const Executor& run_;
  std::vector<Grid<Executor>> grids_;
  SceneView scene_{};
  FactorizedCoarsest<Executor> coarsest_;
  std::map<std::pair<const double*, double*>, Recordings> recordings_;
  Array<float, Executor> only_{run_};
};

}  // namespace lichtenberg::laplace::device
