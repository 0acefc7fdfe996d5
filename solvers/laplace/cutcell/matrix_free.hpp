#pragma once

#include "solvers/laplace/cutcell/linear_system.hpp"
#include "solvers/laplace/cutcell/multigrid.hpp"

namespace lichtenberg::laplace {

/// The operator as it is, geometric multigrid as preconditioner.
class MatrixFreeSystem : public LinearSystem {
 public:
  /// `tolerance` is what KSP's views show; each solve has its own.
  MatrixFreeSystem(LinkFormula links, double tolerance);

  void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) override;
  void solve(std::vector<double>& b, std::vector<double>& x, const StopCriterion& criterion,
             LaplaceSolution& solution) override;

 private:
  void discretize(const LaplaceProblem& problem, Level& level, CutCellOperator& op);
  void make_krylov(CutCellOperator& op);
  LinkFormula links_;
  double tolerance_;
  Multigrid multigrid_;
  Krylov krylov_;
};

}  // namespace lichtenberg::laplace
