#pragma once

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Interface for the representation and the preconditioner of the cut-cell system A x = b: matrix-free
/// (matrix_free.hpp) or assembled (assembled.hpp). Vectors contain one entry a slot (memory index) of the grid's
/// layout, then one entry a group (bodies with one potential).
class LinearSystem {
 public:
  virtual ~LinearSystem() = default;
  /// Discretizes the problem: computes `level`, `op` and the preconditioner. `level` and `op` must outlive this object.
  /// A worker thread may continue with the preconditioner until finish(), so that no argument may change until then.
  virtual void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) = 0;
  /// Waits for the worker thread of build(). To be called before first_guess(), solve() and the end of the problem's
  /// lifetime.
  virtual void finish() {}
  /// Computes an initial guess x without an earlier solution, in units of `scale` (V); by default zero.
  virtual void first_guess(const LaplaceProblem& /*problem*/, double /*scale*/, std::vector<double>& x) {
    std::fill(x.begin(), x.end(), 0.0);
  }
  /// Solves A x = b from the initial guess in x until `criterion` is met. `residual`: b - A x of the guess, which may
  /// be overwritten. Sets iterations and residual of `solution`, and adds to its work, which is set to 0 if it cannot
  /// be counted. Throws Failure if the iteration does not converge.
  virtual void solve(std::vector<double>& b, std::vector<double>& x, SplitVector& residual,
                     const StopCriterion& criterion, LaplaceSolution& solution) = 0;
};

}  // namespace lichtenberg::laplace
