#pragma once

#include <deque>
#include <vector>

#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Coefficients of the combination of basis vectors that is closest to A^-1 b in the energy norm of A: `gram` holds
/// basis' A basis (symmetric), `products` basis' b. Directions that depend on others get 0.
std::vector<double> closest_combination(const std::vector<double>& gram, const std::vector<double>& products);

/// The last solutions, from which the next solve gets its first guess.
class History {
 public:
  bool empty() const { return past_.empty(); }
  void clear() { past_.clear(); }
  /// Bodies of the last solution's problem.
  std::size_t bodies() const { return past_.front().body.size(); }
  /// The last solution's potentials by slot, covered cells filled with their conductor's.
  const std::vector<double>& newest() const { return past_.front().cell; }

  /// Sets x to a first guess for op x = b (0 without a past) and returns the work done.
  double first_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                     std::vector<double>& x) const;
  /// Keeps the solution x; `body_potential` one a body, in the units of x.
  void remember(const Level& level, const std::vector<double>& x, std::vector<double> body_potential);

 private:
  struct Past {
    std::vector<double> cell, body;
  };
  static constexpr std::size_t length = 3;
  static std::vector<double> on_unknowns(const LaplaceProblem& problem, const CutCellOperator& op, const Past& past);
  std::deque<Past> past_;  // newest first
};

}  // namespace lichtenberg::laplace
