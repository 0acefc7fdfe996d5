#pragma once

#include <array>
#include <deque>
#include <vector>

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Last solutions, for the initial guess of the next solve. The guess is their linear combination that is closest to
/// the new solution in the energy norm (Galerkin projection with the new operator; Fischer 1998). For moving bodies it
/// extrapolates in time, with steps of any length.
class SolutionHistory {
 public:
  /// Returns true if no solution is stored.
  bool empty() const { return solutions_.empty(); }
  /// Removes all stored solutions.
  void clear() { solutions_.clear(); }
  /// Returns the number of bodies of the last solution. The history must not be empty.
  std::size_t bodies() const { return solutions_.front().body.size(); }
  /// Returns the potentials of the last solution in the solver's potential unit: by slot (memory index of a cell,
  /// Layout), then by group. Covered cells (inside conductors) have the potential of their conductor.
  const std::vector<double>& newest() const { return solutions_.front().x; }
  /// Returns the potentials of the last solution by body, in the solver's potential unit.
  const std::vector<double>& newest_of_bodies() const { return solutions_.front().body; }

  /// Computes the initial guess x for op x = b by Galerkin projection on the stored solutions, at most
  /// `history_length`. Returns the work in evaluations of `op`. The history must not be empty.
  double initial_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                       std::vector<double>& x);
  /// Sets x to the last solution on the unknowns of the new geometry. A floating group (bodies with one unknown
  /// potential) gets the mean potential of its bodies.
  void newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op, std::vector<double>& x);
  /// Stores the solution x as the newest and drops the oldest. Covered cells in x must hold their conductor's
  /// potential. `body_potential`: by body, in the units of x. The values of x are undefined after the call.
  void store(std::vector<double>& x, std::vector<double> body_potential);

 private:
  struct StoredSolution {
    std::vector<double> x;     // cells, then groups
    std::vector<double> body;  // potentials
  };
  /// Difference of two successive solutions; zero where there is no unknown.
  struct Difference {
    std::vector<float> cell;
    std::vector<double> group;
  };
  void set_groups(const LaplaceProblem& problem, std::size_t cells, double* x_group);
  void form_basis(const CutCellOperator& op, int j, double* x);
  GuessProducts row_products(const CutCellOperator& op, const double* b, const double* x, int j) const;
  GuessProducts group_products(const CutCellOperator& op, const double* b, const double* x) const;
  GuessProducts products(const CutCellOperator& op, const double* b, double* x);

  int differences() const { return static_cast<int>(solutions_.size()) - 1; }

  std::deque<StoredSolution> solutions_;  // newest first
  // Differences of successive solutions, the newest first. With the newest solution they are the basis: they are nearly
  // orthogonal where the solutions are nearly parallel, and their digits fit single precision.
  std::array<Difference, history_length - 1> difference_;
};

}  // namespace lichtenberg::laplace
