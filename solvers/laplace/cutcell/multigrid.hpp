#pragma once

#include <memory>
#include <vector>

#include "solvers/laplace/cutcell/grid.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"

namespace lichtenberg::laplace {

class CoarseSolver;

/// One symmetric V-cycle on the cut-cell system, the preconditioner of CG. Every level is discretized anew with the
/// same links (conductances do not depend on the cell size); a conductor is a conductor on every level that resolves it
/// and part of the medium below (homogenize.cpp). All of it runs in single precision: a preconditioner need not know
/// more than its own convergence rate.
class Multigrid {
 public:
  /// `coarse_sweeps` go before and after on all grids but the finest. What a second one costs there, an eighth of an
  /// iteration of CG, takes two iterations of eleven away.
  explicit Multigrid(LinkFormula formula, parallel::Team& team = parallel::Team::single(), int coarse_sweeps = 2);
  ~Multigrid();

  /// Chooses the grids below `finest`, at the first call. Then the two builds, in this order, and `finish`.
  void prepare(const LaplaceProblem& problem, const Layout& finest);
  /// Discretizes the coarser grids, from the finest on. The factorization of the coarsest is left to a helper of the
  /// team; where the caller has one helper only, all of it is, so that neither waits for the other in each of their
  /// loops.
  void build_coarse(const LaplaceProblem& problem, const Level& finest);
  /// Takes over the finest grid's system.
  void build_finest(const LaplaceProblem& problem, const Level& finest);
  /// Waits for the helper. Before that nothing but the builds may be called, and `problem` and `finest` must stand.
  void finish() { team_.finish(); }

  /// z = M r. Vectors in the finest level's layout, followed by one entry a group.
  void apply(const double* r, double* z);
  /// `apply` in parts, for who has better things to do with r and z than to keep them: all rows of r and its groups,
  /// then the cycle, which returns r'z; z is then read where it is.
  void take_row(int j, const double* r);
  void take_groups(const double* r);
  double cycle(const double* r);
  const float* cells() const { return grids_[0]->v.data(); }
  const double* groups() const { return group_potential_.data(); }

  /// Solves the problem on the coarser grids, each starting from the next coarser one's solution (nested iteration:
  /// Brandt 1977), and interpolates to x, in units of `scale` (V). Without a coarser grid x is left as it is.
  void nested_guess(const LaplaceProblem& problem, double scale, double* x);

  /// Work since the last call, in units of one residual evaluation on the finest grid (README.md).
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
