#pragma once

#include <memory>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

class CutCellBackend;

struct CutCellOptions {
  int cells = 512;          ///< S, cells along the longer side of the box; the shorter side must hold whole cells
  double tolerance = 1e-8;  ///< error in the energy norm, relative to the solution's norm
  LinkFormula links = LinkFormula::log_fitted;
  /// Threads of the set-up and the solve; results are bitwise identical for any number. 0: the number of processors,
  /// fewer on small grids.
  int threads = 0;
  /// multigrid: matrix-free, geometric multigrid as preconditioner. assembled: the same system as an AIJ matrix, for
  /// any PETSc preconditioner (default GAMG; -field_pc_type chooses).
  enum class LinearSolver { multigrid, assembled } linear_solver = LinearSolver::multigrid;
  /// Device of the solves. For cuda the solver's constructor throws InputError without CUDA in the build or without
  /// such a device.
  enum class Device { cpu, cuda } device = Device::cpu;
};

/// Direct cut-cell finite-volume scheme (docs/numerics/cut-cells.md) with log-fitted boundary fluxes. Floating
/// potentials are unknowns of the same symmetric positive definite system, which conjugate gradients solve. The scheme
/// is second-order. Charges are conserved to rounding. Forces are the exact derivative of the discrete energy (virtual
/// work). Where bodies overlap, a cell belongs to the body whose centre is in the lower row, in one row to the first
/// body; on a device always to the first. KSP options have the prefix "field_"; -field_ksp_rtol overrules `tolerance`.
class CutCellSolver : public LaplaceSolver {
 public:
  /// Makes a solver. Throws InputError if `options` combine LinkFormula::aperture with multigrid, or choose cuda
  /// without CUDA in the build or without such a device.
  explicit CutCellSolver(CutCellOptions options);
  ~CutCellSolver() override;

  /// Solves the problem. Throws the exceptions of LaplaceSolver::solve. Throws InputError for a number of cells that
  /// does not fit the box, and for an unused PETSc option of the solver. Throws InputError for a link model that the
  /// options or the grid do not support.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  Field field() const override;
  void forget() override;
  /// Adds to later initial guesses the change of potentials that `coarser` has computed since the last solve here.
  /// `coarser` solves the same scenes on a coarser grid. It must have solved the same problem just before, and outlive
  /// this solver.
  void follow(const CutCellSolver& coarser);
  /// Sets the tolerance of later solves.
  void set_tolerance(double tolerance);

 private:
  LaplaceSolution solve_without_nodes(const LaplaceProblem& problem);
  std::unique_ptr<CutCellBackend> backend_;
};

}  // namespace lichtenberg::laplace
