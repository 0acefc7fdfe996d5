#pragma once

#include <memory>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

class CutCellBackend;

struct CutCellOptions {
  int cells = 512;          ///< S: cells along the longer side of the box; the shorter one must hold whole cells
  double tolerance = 1e-8;  ///< error of a solve in the energy norm, relative to the solution's
  LinkFormula links = LinkFormula::log_fitted;
  /// That share set-up and solve; the results are the same bits for any number. 0: as many as the machine has, fewer
  /// on small grids.
  int threads = 0;
  /// multigrid: matrix-free, geometric multigrid as preconditioner. assembled: the same system as an AIJ matrix, for
  /// any PETSc preconditioner (default GAMG; -field_pc_type chooses).
  enum class LinearSolver { multigrid, assembled } linear_solver = LinearSolver::multigrid;
  /// Where the solves run. cuda: InputError from the solver's constructor if the program was built without CUDA, or if
  /// there is no such device.
  enum class Device { cpu, cuda } device = Device::cpu;
};

/// The direct scheme (README.md): cut-cell finite volumes with log-fitted boundary fluxes, floating potentials as
/// unknowns of the same symmetric positive definite system, CG. Second-order; charges are conserved to rounding (on a
/// device to the tolerance), forces are the exact derivative of the discrete energy (virtual work). Where bodies
/// overlap, a cell belongs to the one whose centre is in the lower row, of one row to the first (on a device always to
/// the first). KSP options have the prefix "field_"; -field_ksp_rtol overrules `tolerance`.
class CutCellSolver : public LaplaceSolver {
 public:
  explicit CutCellSolver(CutCellOptions options);
  ~CutCellSolver() override;

  LaplaceSolution solve(const LaplaceProblem& problem) override;
  Field field() const override;
  void forget() override;
  /// From now on first guesses take over by how much the potentials of `coarser`, a solver of the same scenes on a
  /// coarser grid, have changed since the last solve here: what predictions have found already. `coarser` must have
  /// solved the same problem just before, and outlive this.
  void follow(const CutCellSolver& coarser);
  /// Changes the tolerance of the solves that follow.
  void set_tolerance(double tolerance);

 private:
  LaplaceSolution solve_without_nodes(const LaplaceProblem& problem);
  CutCellOptions options_;  // as given
  std::unique_ptr<CutCellBackend> backend_;
};

}  // namespace lichtenberg::laplace
