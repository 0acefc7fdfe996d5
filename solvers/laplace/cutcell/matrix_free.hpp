#pragma once

#include "solvers/laplace/cutcell/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/linear_system.hpp"

namespace lichtenberg::laplace {

/// Cut-cell system without an assembled matrix, with geometric multigrid as preconditioner of conjugate gradients.
class MatrixFreeSystem : public LinearSystem {
 public:
  /// Makes the system without a problem. `links`: formula of the links' conductances; `tolerance`: only shown in
  /// PETSc's output, because each solve has its own; `team`: threads of all loops.
  MatrixFreeSystem(LinkFormula links, double tolerance, parallel::Team& team);

  void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) override;
  void finish() override { multigrid_.finish(); }
  void first_guess(const LaplaceProblem& problem, double scale, std::vector<double>& x) override;
  void solve(std::vector<double>& b, std::vector<double>& x, std::vector<double>& residual,
             const StopCriterion& criterion, LaplaceSolution& solution) override;

 private:
  void discretize(const LaplaceProblem& problem, Level& level, CutCellOperator& op);
  void make_krylov(CutCellOperator& op);
  void make_vectors(PetscInt n);
  Shell shell() { return Shell::of(&context_, "cut-cell multigrid", VECSTANDARD); }
  LinkFormula links_;
  double tolerance_;
  parallel::Team& team_;
  LevelBuilder builder_;
  Multigrid multigrid_;
  MatrixFreeContext context_;
  Krylov krylov_;
};

}  // namespace lichtenberg::laplace
