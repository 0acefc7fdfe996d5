#pragma once

#include <array>
#include <deque>
#include <vector>

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// The last solutions, from which the next solve gets its first guess: the combination of them that is closest to the
/// new one in the energy norm (a Galerkin projection with the new operator; Fischer 1998). For a scene in motion that
/// is extrapolation in time, whatever the steps were.
class SolutionHistory {
 public:
  bool empty() const { return solutions_.empty(); }
  void clear() { solutions_.clear(); }
  /// Bodies of the last solution's problem.
  std::size_t bodies() const { return solutions_.front().body.size(); }
  /// The last solution's potentials by slot, covered cells filled with their conductor's, and those of the bodies.
  const std::vector<double>& newest() const { return solutions_.front().x; }
  const std::vector<double>& newest_of_bodies() const { return solutions_.front().body; }

  /// Sets x to a first guess for op x = b and returns the work, in evaluations of op. There must be a past.
  double initial_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                       std::vector<double>& x);
  /// Sets x to the last solution, as far as the new geometry has its cells.
  void newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op, std::vector<double>& x);
  /// Keeps the solution x, covered cells filled with their conductor's, and leaves something else in it;
  /// `body_potential` one a body, in the units of x.
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
  // The newest solution and successive differences, nearly orthogonal where the solutions are nearly parallel; zero
  // where there is no unknown. And what the operator makes of one of them.
  std::array<std::vector<double>, history_length> basis_;
  std::vector<double> image_;
};

}  // namespace lichtenberg::laplace
