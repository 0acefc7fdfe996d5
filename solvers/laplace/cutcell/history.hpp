#pragma once

#include <array>
#include <deque>
#include <vector>

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Last solutions, for the initial guess of the next solve: their combination that is closest to the new solution in
/// the energy norm (a Galerkin projection with the new operator; Fischer 1998). In a scene in motion it extrapolates in
/// time, for steps of any length.
class SolutionHistory {
 public:
  bool empty() const { return solutions_.empty(); }
  void clear() { solutions_.clear(); }
  /// Number of bodies of the last solution.
  std::size_t bodies() const { return solutions_.front().body.size(); }
  /// Returns the potentials of the last solution by cell (Layout slot); in covered cells it is that of the conductor.
  const std::vector<double>& newest() const { return solutions_.front().x; }
  /// Returns the potentials of the last solution by body.
  const std::vector<double>& newest_of_bodies() const { return solutions_.front().body; }

  /// Sets x to the initial guess for op x = b. Returns the work in evaluations of op. The history must not be empty.
  double initial_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                       std::vector<double>& x);
  /// Sets x to the last solution on the cells of the new geometry.
  void newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op, std::vector<double>& x);
  /// Stores the solution x, whose covered cells hold their conductor's potential, and leaves undefined values in it.
  /// `body_potential`: by body, in the units of x.
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
