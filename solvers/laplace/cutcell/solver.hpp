#pragma once

#include <cstdint>
#include <memory>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

class CutCellBackend;

/// Options of CutCellSolver: grid size, tolerance, formula of the conductances at cut cells, linear solver, threads and
/// device.
struct CutCellOptions {
  /// Number of cells along the longer side of the box. The shorter side must hold a whole number of cells.
  int cells = 512;
  /// Error in the energy norm, relative to the solution's norm.
  double tolerance = 1e-8;
  /// Formula of the conductances of links between fluid cells and conductors.
  LinkFormula links = LinkFormula::log_fitted;
  /// Threads of the set-up and the solve with `multigrid`; results are bitwise identical for any number. 0: the number
  /// of processors, fewer on small grids; one in each of several MPI processes.
  int threads = 0;
  /// Linear solver. `multigrid`: matrix-free, geometric multigrid as preconditioner. `assembled`: the same system as a
  /// sparse matrix for any PETSc preconditioner (default GAMG; option -field_pc_type).
  enum class LinearSolver { multigrid, assembled } linear_solver = LinearSolver::multigrid;
  /// Device of the solves. For `cuda` the solver's constructor throws InputError without CUDA in the build or, with
  /// `multigrid`, without a CUDA device.
  enum class Device { cpu, cuda } device = Device::cpu;
  /// CUDA devices among which `multigrid` divides the rows of large grids: bit k for device number k, all_cuda_devices
  /// for all; 0: PETSc's device.
  std::uint64_t cuda_devices = 0;
  static constexpr std::uint64_t all_cuda_devices = ~std::uint64_t{0};
};

/// Solver of Laplace's equation around conductors by a cut-cell finite-volume scheme (docs/numerics/cut-cells.md) with
/// log-fitted boundary fluxes. The cells' potentials and the floating potentials are unknowns of one symmetric system,
/// which conjugate gradients solve by default. Charges are conserved to rounding. Forces are the derivative of the
/// discrete energy in closed form (virtual work).
/// Where bodies overlap, a cell belongs to the body whose centre (of a bar: first end) is in the lower row of cells.
/// Within one row it belongs to the first body. On a device it always belongs to the first body. Options of PETSc's KSP
/// have the prefix "field_"; -field_ksp_rtol overrules `tolerance`.
class CutCellSolver : public LaplaceSolver {
 public:
  /// Makes a solver. Throws InputError if `options` combine LinkFormula::aperture with multigrid. For `cuda`, throws
  /// InputError if the program (for `multigrid`) or PETSc (for `assembled`) was built without CUDA. With `multigrid`
  /// also throws InputError if there is no CUDA device.
  explicit CutCellSolver(CutCellOptions options);
  ~CutCellSolver() override;

  /// Solves the problem: potentials of the groups (bodies with one potential), charges, forces and energy. Throws the
  /// exceptions of LaplaceSolver::solve. Throws InputError for a number of cells that does not fit the box, and for an
  /// unused or unsupported PETSc option of the solver. Throws InputError for a link model that the options or the grid
  /// do not support.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Returns the potential of the last solve at the cell centres. If the grid is divided among several MPI processes,
  /// the call is collective and the first process gets the field of all rows, the others that of their own. Throws
  /// Failure before the first solve, and after forget() or a failed solve.
  Field field() const override;
  /// Discards earlier solutions, so that the next initial guess depends on its problem only. On a device the
  /// preconditioner still depends on links in earlier problems, and with it the result within the tolerance.
  void forget() override;
  /// Improves later initial guesses by the solution of a solver on a coarser grid. The guess becomes this solver's last
  /// solution plus the change of the coarser solution since that solve, if both exist. `coarser` must solve each
  /// problem just before this solver does, and must outlive this solver.
  void follow(const CutCellSolver& coarser);
  /// Sets the tolerance of later solves: error in the energy norm, relative to the solution's norm.
  void set_tolerance(double tolerance);

 private:
  LaplaceSolution solve_without_nodes(const LaplaceProblem& problem);
  std::unique_ptr<CutCellBackend> backend_;
};

}  // namespace lichtenberg::laplace
