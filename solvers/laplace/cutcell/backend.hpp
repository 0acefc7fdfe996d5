#pragma once

#include <chrono>

#include "solvers/laplace/cutcell/cell_owner.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace {

/// Number of sweeps over the cells next to conductors that smooth an initial guess. Four cost a third of a residual
/// evaluation and reduce the guess's error in the energy norm to an eighth.
constexpr int edge_sweeps = 4;

/// Solver behind CutCellSolver, on the CPU or on a device: the sequence of a solve, and the state that both have in
/// common. The caller has checked the problem and eliminated nodes of circuits.
class CutCellBackend : public LaplaceSolver {
 public:
  explicit CutCellBackend(const CutCellOptions& options) : options_(options) {}
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Throws Failure before the first solve.
  Field field() const override;
  void forget() override { clear_history(); }
  const CutCellOptions& options() const { return options_; }
  void set_tolerance(double tolerance) { options_.tolerance = tolerance; }
  /// Implements CutCellSolver::follow. The solver follows no other one if `coarser` is a backend of another kind.
  virtual void follow(const CutCellBackend& coarser) = 0;

 protected:
  // Steps of a solve; the first one only for a new box.
  /// Makes the grids, of which finest_ is the size of the finest.
  virtual void make_grids(const LaplaceProblem& problem) = 0;
  /// Sets up the grids, the operator and the preconditioner.
  virtual void discretize(const LaplaceProblem& problem) = 0;
  /// Sets the right-hand side and the initial guess of the potentials.
  virtual void begin(const LaplaceProblem& problem, LaplaceSolution& solution) = 0;
  /// Solves the system and corrects the potentials until charges are exact.
  virtual void iterate(LaplaceSolution& solution) = 0;
  /// Returns true if all arrays were large enough. If not, the steps from discretize() on are repeated with larger
  /// ones.
  virtual bool is_complete() const { return true; }
  /// Evaluates the results and adds the potentials to the history. Sets `unknowns` to the number of fluid cells.
  virtual void finish(const LaplaceProblem& problem, LaplaceSolution& solution) = 0;

  virtual bool has_history() const = 0;
  virtual void clear_history() = 0;
  virtual Field last_field() const = 0;

  /// Returns the field on the grid `at` with cells of edge h (m). `cell`: potentials by Layout slot, in units of
  /// `unit_`; `owner`: by slot.
  Field field_on(const Layout& at, double h, const double* cell, const CellOwner* owner) const;
  /// Wall time since the begin of the solve (s).
  double seconds() const;

  CutCellOptions options_;
  GridSize finest_{};
  /// Unit of all potentials of the system and the history (V).
  double unit_ = 1;

 private:
  void prepare(const LaplaceProblem& problem);
  void choose_unit(const LaplaceProblem& problem);
  Vec2 box_;                ///< the size that the grids were made for (m); 0: there are none
  std::size_t bodies_ = 0;  ///< of the last problem
  std::chrono::steady_clock::time_point start_;
};

}  // namespace lichtenberg::laplace
