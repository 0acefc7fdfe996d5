#pragma once

#include <memory>
#include <vector>

#include "solvers/laplace/cutcell/grid.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"

namespace lichtenberg::laplace {

class CoarseSolver;

/// One symmetric V-cycle on the cut-cell system, the preconditioner of CG. Every grid is discretized with the same link
/// formulas, because conductances do not depend on the cell size. A conductor is resolved on fine grids and part of the
/// medium on coarse ones (homogenize.hpp). The cycle uses single precision: a preconditioner needs no more digits than
/// its convergence rate requires.
class Multigrid {
 public:
  /// Makes a preconditioner without grids. `coarse_sweeps`: number of sweeps before and after the correction on all
  /// grids except the finest. A second sweep there costs 1/8 of a CG iteration and saves two of eleven iterations.
  explicit Multigrid(LinkFormula formula, parallel::Team& team = parallel::Team::single(), int coarse_sweeps = 2);
  ~Multigrid();

  /// Chooses the grids at the first call. For each problem, call prepare(), build_coarse(), build_finest() and finish()
  /// in this order.
  void prepare(const LaplaceProblem& problem, const Layout& finest);
  /// Discretizes the coarser grids. A worker thread factorizes the coarsest system. A team of two leaves all of this to
  /// the worker thread, so that the two threads do not wait for each other in every loop.
  void build_coarse(const LaplaceProblem& problem, const Level& finest);
  /// Takes over the finest grid's system.
  void build_finest(const LaplaceProblem& problem, const Level& finest);
  /// Waits for the worker thread. Before this call only the builds are allowed, and `problem` and `finest` must not
  /// change.
  void finish() { team_.finish(); }

  /// z = M r. Vectors have the finest level's layout, then one entry a group.
  void apply(const double* r, double* z);
  /// apply() in parts, for fused passes over r and z: take_row() for all rows of r and take_groups(), then cycle(),
  /// which returns r'z. Then cells() and groups() are z.
  void take_row(int j, const double* r);
  void take_groups(const double* r);
  double cycle(const double* r);
  const float* cells() const { return grids_[0]->v.data(); }
  const double* groups() const { return group_potential_.data(); }

  /// Solves the problem on the coarser grids, each with the next coarser grid's solution as initial guess (nested
  /// iteration: Brandt 1977), and interpolates to x, in units of `scale` (V). Without a coarser grid x is not changed.
  void nested_guess(const LaplaceProblem& problem, double scale, double* x);

  /// Returns the work since the last call, in units of one residual evaluation on the finest grid
  /// (docs/numerics/multigrid.md).
  double take_work();

  int levels() const;

 private:
  void discretize_coarse(const LaplaceProblem& problem, const Level& finest, parallel::Team& team);
  void cycle(int l, const double* r, double* row_product);
  void spread_correction(int l);
  double share(int l) const;
  LinkFormula formula_;
  parallel::Team& team_;
  int coarse_sweeps_;
  std::vector<std::unique_ptr<Level>> coarse_levels_;
  std::vector<LevelBuilder> coarse_builders_;
  std::vector<std::unique_ptr<Grid>> grids_;
  std::unique_ptr<CoarseSolver> coarse_solver_;
  std::vector<double> row_product_, group_potential_;
  double work_ = 0;
};

}  // namespace lichtenberg::laplace
