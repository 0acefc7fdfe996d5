#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

class CoarseSolver;

/// One symmetric V-cycle on the cut-cell system, the preconditioner of CG. Every level is discretized anew with the
/// same links (conductances do not depend on the cell size), a conductor is a conductor on every level, and all of it
/// runs in single precision: a preconditioner need not know more than its own convergence rate.
class Multigrid {
 public:
  explicit Multigrid(LinkFormula formula);
  ~Multigrid();

  /// Chooses the grids below `finest`, at the first call. Then the two builds, in any order or at the same time.
  void prepare(const LaplaceProblem& problem, const Layout& finest);
  /// Discretizes the coarser grids and factorizes the coarsest.
  void build_coarse(const LaplaceProblem& problem);
  /// Takes over the finest grid's system.
  void build_finest(const LaplaceProblem& problem, const Level& finest);

  /// z = M r. Vectors in the finest level's layout, followed by one entry a group.
  void apply(const double* r, double* z);

  int levels() const;
  long coarse_unknowns() const;

 private:
  struct Grid;
  void cycle(int l);
  LinkFormula formula_;
  std::vector<std::unique_ptr<Level>> coarse_levels_;
  std::vector<Grid> grids_;
  std::unique_ptr<CoarseSolver> coarse_solver_;
};

}  // namespace lichtenberg::laplace
