#pragma once

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// How the cut-cell system is held and preconditioned: without a matrix (matrix_free.hpp) or assembled
/// (assembled.hpp). Vectors are the operator's: a level's layout followed by one entry a group.
class LinearSystem {
 public:
  virtual ~LinearSystem() = default;
  /// Discretizes the problem on `level`, in `op` and in whatever the preconditioner needs; both must outlive this. A
  /// helper may go on with the preconditioner until `finish`, so that all three must stay as they are.
  virtual void build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) = 0;
  /// Waits for that helper; before first_guess and solve, and before the problem goes.
  virtual void finish() {}
  /// Sets x, in units of `scale` (V), to what is easily had without an earlier solution.
  virtual void first_guess(const LaplaceProblem& /*problem*/, double /*scale*/, std::vector<double>& x) {
    std::fill(x.begin(), x.end(), 0.0);
  }
  /// Solves op x = b from the guess in x, whose residual may be used and overwritten, until `criterion` is met; sets
  /// iterations and residual of `solution` and adds to its work, if it is counted. Throws Failure without convergence.
  virtual void solve(std::vector<double>& b, std::vector<double>& x, std::vector<double>& residual,
                     const StopCriterion& criterion, LaplaceSolution& solution) = 0;
};

}  // namespace lichtenberg::laplace
