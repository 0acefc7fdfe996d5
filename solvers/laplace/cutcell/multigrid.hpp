#pragma once

#include <memory>
#include <vector>

#include "solvers/laplace/cutcell/grid.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"

namespace lichtenberg::laplace {

class CoarseSolver;

/// One symmetric V-cycle on the cut-cell system, the multigrid preconditioner of conjugate gradients. Every grid is
/// discretized with the same link formulas, because conductances do not depend on the cell size. Conductors that a
/// coarse grid does not resolve become part of an effective medium or subgrid conductors (homogenize.hpp). The grids'
/// vectors are in single precision: a preconditioner needs no more digits than its convergence rate requires.
class Multigrid {
 public:
  /// Makes a preconditioner without grids. `coarse_sweeps`: number of smoothing sweeps before and after the coarse-grid
  /// correction, on all grids except the finest.
  explicit Multigrid(LinkFormula formula, parallel::Team& team = parallel::Team::single(), int coarse_sweeps = 2);
  ~Multigrid();

  /// Makes the grids at the first call, for the layout of the finest grid. For each problem, call prepare(),
  /// build_coarse(), build_finest() and finish() in this order.
  void prepare(const LaplaceProblem& problem, const Layout& finest);
  /// Discretizes the coarser grids, if there are any. A worker thread factorizes the coarsest system. In a team of two
  /// the worker thread does all of this, because otherwise the two threads would wait for each other in every loop.
  /// `finest`: the finest grid's geometry.
  void build_coarse(const LaplaceProblem& problem, const Level& finest);
  /// Copies the finest grid's system to the V-cycle. If there is no coarser grid, factorizes this system.
  void build_finest(const LaplaceProblem& problem, const Level& finest);
  /// Waits for the worker thread of build_coarse(). Before this call only the build functions are allowed, and
  /// `problem` and `finest` must not change.
  void finish() { team_.finish(); }

  /// Applies the preconditioner: z = M r by one V-cycle. Vectors have the finest grid's layout, then one entry a group
  /// (bodies with one potential).
  void apply(const double* r, double* z);
  /// Copies row j of the residual r to the finest grid as its right-hand side. take_row() for all rows, take_groups()
  /// and cycle() together equal apply(). They serve fused passes over r and z.
  void take_row(int j, const double* r);
  /// Copies the groups' entries of the residual r to the finest grid as right-hand side of the V-cycle. A group is a
  /// set of bodies with one potential.
  void take_groups(const double* r);
  /// Runs one V-cycle on the residual r, which take_row() and take_groups() have copied. Returns the scalar product
  /// r'z. The result z = M r is then in cells() and groups().
  double cycle(const double* r);
  /// Returns the cells' part of z = M r after cycle(), by slot (memory index), in own rows and one ghost row.
  const float* cells() const { return grids_[0]->v.data(); }
  /// Returns the groups' part of z = M r after cycle(). A group is a set of bodies with one potential.
  const double* groups() const { return group_potential_.data(); }

  /// Computes an initial guess x by nested iteration (full multigrid, Brandt 1977), in units of `scale` (V). It solves
  /// the problem on the coarsest grid. On each finer grid except the finest, one V-cycle improves the interpolated
  /// solution of the coarser grid. The result is interpolated to the finest grid. Without a coarser grid x is not
  /// changed.
  void nested_guess(const LaplaceProblem& problem, double scale, double* x);

  /// Returns the work of V-cycles and nested_guess() since the last call, and resets it. The unit is one residual
  /// evaluation on the finest grid (docs/numerics/multigrid.md).
  double take_work();

  /// Returns the number of grids.
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
