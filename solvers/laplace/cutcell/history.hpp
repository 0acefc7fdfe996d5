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

  /// Computes the initial guess x for op x = b by Galerkin projection on the stored solutions. Returns the work in
  /// evaluations of `op`. The history must not be empty.
  double initial_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                       std::vector<double>& x);
  /// Sets x to the last solution on the unknowns of the new geometry. A floating group (bodies with one unknown
  /// potential) gets the mean potential of its bodies.
  void newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op, std::vector<double>& x);
  /// Stores the solution x as the newest and drops the oldest if there are more than `history_length`. Covered cells in
  /// x must hold their conductor's potential. `body_potential`: by body, in the units of x. The values of x are
  /// undefined after the call.
  void store(std::vector<double>& x, std::vector<double> body_potential);

 private:
  struct StoredSolution {
    std::vector<double> x;     // cells, then groups
    std::vector<double> body;  // potentials
  };
  void set_groups(const LaplaceProblem& problem, std::size_t cells);
  void form_basis(const CutCellOperator& op, std::ptrdiff_t from, int count);
  GuessProducts row_products(const CutCellOperator& op, const double* b, int j);
  GuessProducts group_products(const CutCellOperator& op, const double* b);
  GuessProducts products(const CutCellOperator& op, const std::vector<double>& b);

  std::deque<StoredSolution> solutions_;  // newest first
  // Basis: the newest solution and successive differences, which are nearly orthogonal where the solutions are nearly
  // parallel; zero where there is no unknown. `image_`: the operator applied to one of them.
  std::array<std::vector<double>, history_length> basis_;
  std::vector<double> image_;
};

}  // namespace lichtenberg::laplace
