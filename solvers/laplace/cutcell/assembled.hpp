#pragma once

#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/linear_system.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system as a sparse PETSc matrix (type AIJ), for any PETSc preconditioner (option -field_pc_type;
/// default GAMG). With several MPI processes, each process has the whole geometry, a part of the matrix rows, and the
/// whole solution. build() and solve() are collective over PETSC_COMM_WORLD. On a CUDA device the matrix type is
/// aijcusparse. The options -field_mat_type and -field_vec_type set other types.
class AssembledSystem : public LinearSystem {
 public:
  AssembledSystem(LinkFormula links, double tolerance, CutCellOptions::Device device = CutCellOptions::Device::cpu);

  void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) override;
  void solve(std::vector<double>& b, std::vector<double>& x, SplitVector& residual, const StopCriterion& criterion,
             LaplaceSolution& solution) override;

  /// Assembles the matrix of the discretized grid `level` and makes PETSc's vectors. Part of build().
  void assemble_matrix(const LaplaceProblem& problem, const Level& level);
  /// Makes the Krylov method, sets up its preconditioner and, if no potential is given, the null space of equal
  /// potentials. Part of build().
  void set_up_preconditioner(const LaplaceProblem& problem);

 private:
  void scatter(const std::vector<double>& by_unknown, ::Vec to) const;
  MatNullSpace constant_potential() const;
  std::vector<double> by_unknown(const std::vector<double>& x) const;
  void gather(::Vec from, std::vector<double>& to) const;
  LinkFormula links_;
  double tolerance_;
  CutCellOptions::Device device_;
  LevelBuilder builder_;
  // Without rows.
  SparseSystem numbering_;
  // Index of each unknown in the operator's vectors.
  std::vector<std::ptrdiff_t> entry_;
  Krylov krylov_;
};

}  // namespace lichtenberg::laplace
