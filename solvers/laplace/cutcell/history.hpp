#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Coefficients of the combination of basis vectors that is closest to the solution of A x = b in the energy norm, from
/// their Gram matrix in A (symmetric, by rows) and their products with b.
std::vector<double> closest_combination(const std::vector<double>& gram, const std::vector<double>& products);

/// The last solutions, from which the next solve gets its first guess: the combination of them that is closest to the
/// new one in the energy norm (a Galerkin projection with the new operator; Fischer 1998). For a scene in motion that
/// is extrapolation in time, whatever the steps were.
///
/// A past solution fulfils the equations of all cells whose stencil is what it was then, to its solver's tolerance.
/// So A needs to be applied at those cells only that are, or were in one of the past geometries, at an edge.
class History {
 public:
  bool empty() const { return past_.empty(); }
  void clear();
  /// Bodies of the last solution's problem.
  std::size_t bodies() const { return past_.front().body.size(); }
  /// The last solution's potentials by slot, covered cells filled with their conductor's.
  const std::vector<double>& newest() const { return past_.front().x; }

  /// Sets x to a first guess for op x = b (0 without a past) and returns the work, in evaluations of op.
  double first_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                     std::vector<double>& x);
  /// Keeps the solution x, and leaves something else in it; `body_potential` one a body, in the units of x.
  void remember(const Level& level, std::vector<double>& x, std::vector<double> body_potential);

 private:
  struct Past {
    std::vector<double> x;           // cells, then groups
    std::vector<double> body;        // potentials
    std::vector<std::int32_t> edge;  // cells
  };
  static constexpr int length = 3;
  using Values = std::array<double, length>;  // of the past solutions at one place
  // Products over some of the cells: the Gram matrix's lower triangle and the products with b.
  struct Products {
    std::array<Values, length> gram{};
    Values rhs{};
    long cells = 0;
    void add(const Values& e, const Values& image, double b);
    void add(const Products& other);
  };
  void set_groups(const LaplaceProblem& problem, std::size_t cells);
  void count_edges(const std::vector<std::int32_t>& edge, int change);
  static Values shares(const Products& known, int m);
  Products row_products(const CutCellOperator& op, const double* b, int j) const;
  Products products(const CutCellOperator& op, const std::vector<double>& b) const;

  std::deque<Past> past_;            // newest first
  std::vector<std::uint8_t> edges_;  // by slot: in how many geometries, past and present, the cell is at an edge
};

}  // namespace lichtenberg::laplace
