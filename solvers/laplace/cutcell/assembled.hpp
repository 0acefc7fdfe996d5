#pragma once

#include "solvers/laplace/cutcell/linear_system.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

/// The system as an AIJ matrix, for any PETSc preconditioner (default GAMG; -field_pc_type chooses).
class AssembledSystem : public LinearSystem {
 public:
  AssembledSystem(LinkFormula links, double tolerance);

  void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) override;
  void solve(std::vector<double>& b, std::vector<double>& x, const StopCriterion& criterion,
             LaplaceSolution& solution) override;

 private:
  void make_krylov();
  void scatter(const std::vector<double>& from, Vec to) const;
  void gather(Vec from, std::vector<double>& to) const;
  LinkFormula links_;
  double tolerance_;
  std::size_t cells_ = 0;  // slots of the layout: where the groups begin in the operator's vectors
  SparseSystem sparse_;    // the matrix borrows its arrays
  Krylov krylov_;
};

}  // namespace lichtenberg::laplace
