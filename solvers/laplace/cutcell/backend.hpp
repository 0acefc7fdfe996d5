#pragma once

#include <chrono>

#include "solvers/laplace/cutcell/cell_owner.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace {

/// Number of sweeps over the cells next to conductors that smooth an initial guess. Four sweeps cost about a third of a
/// residual evaluation and reduce the guess's error in the energy norm to about an eighth.
constexpr int edge_sweeps = 4;

/// Implementation of CutCellSolver on the CPU or on a device: the sequence of steps of a solve, and the state that both
/// have in common. The caller has checked the problem and eliminated circuit nodes (groups without bodies).
class CutCellBackend : public LaplaceSolver {
 public:
  explicit CutCellBackend(const CutCellOptions& options) : options_(options) {}
  /// Solves the problem: discretization, initial guess, iterations, results. If a step throws, the history of solutions
  /// is cleared and the exception passes.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Returns the potential of the last solve at the cell centres. Throws Failure without a stored solution: before the
  /// first solve, and after forget() or a failed solve.
  Field field() const override;
  void forget() override { clear_history(); }
  const CutCellOptions& options() const { return options_; }
  void set_tolerance(double tolerance) { options_.tolerance = tolerance; }
  /// Makes later initial guesses follow the solution of a solver on a coarser grid (CutCellSolver::follow). Nothing is
  /// followed if `coarser` is a backend of another kind.
  virtual void follow(const CutCellBackend& coarser) = 0;

 protected:
  /// Makes the grids for a new box; `finest_` is the size of the finest. First step of a solve if the box has changed.
  virtual void make_grids(const LaplaceProblem& problem) = 0;
  /// Computes the links (conductances between cells and conductors), the operator and the preconditioner for the
  /// problem's geometry.
  virtual void discretize(const LaplaceProblem& problem) = 0;
  /// Computes the right-hand side and the initial guess of the potentials.
  virtual void begin(const LaplaceProblem& problem, LaplaceSolution& solution) = 0;
  /// Solves the linear system and corrects the potentials until the charges are exact to rounding.
  virtual void iterate(LaplaceSolution& solution) = 0;
  /// Returns true if all arrays were large enough. If not, the steps from discretize() on are repeated with larger
  /// arrays.
  virtual bool is_complete() const { return true; }
  /// Computes charges, forces and energy, and adds the potentials to the history. Sets `solution.unknowns` to the
  /// number of fluid cells (cells that no body covers).
  virtual void finish(const LaplaceProblem& problem, LaplaceSolution& solution) = 0;

  virtual bool has_history() const = 0;
  virtual void clear_history() = 0;
  virtual Field last_field() const = 0;

  /// Converts potentials to a Field (by row, in V) on the own rows of the grid `at` with cells of size h (m). `cell`:
  /// potentials by slot (memory index of a cell), in units of `unit_` (V); `owner`: body that covers each cell, or
  /// fluid, by slot.
  Field field_on(const Layout& at, double h, const double* cell, const CellOwner* owner) const;
  /// Returns the wall time since the start of the solve (s).
  double seconds() const;

  CutCellOptions options_;
  GridSize finest_{};
  /// Unit of all potentials in the system and in the history (V).
  double unit_ = 1;

 private:
  void prepare(const LaplaceProblem& problem);
  void choose_unit(const LaplaceProblem& problem);
  Vec2 box_;                ///< the size that the grids were made for (m); 0: there are none
  std::size_t bodies_ = 0;  ///< of the last problem
  std::chrono::steady_clock::time_point start_;
};

}  // namespace lichtenberg::laplace
