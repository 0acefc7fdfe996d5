#pragma once

#include <array>
#include <vector>

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Minimizer L-BFGS: limited-memory quasi-Newton method of Broyden, Fletcher, Goldfarb and Shanno (Nocedal 1980) with a
/// backtracking line search. A step is halved until it lowers the value by at least 1e-4 of the decrease that the slope
/// predicts (Armijo 1966), up to rounding.
/// The direction is a linear combination of past moves of x, past changes of the gradient and the gradient itself. Its
/// coefficients follow from the scalar products of these vectors (Chen, Wang & Zhou 2014). An iteration therefore
/// passes only twice through the past vectors; threads share the work.
/// Past vectors are stored in single precision, which affects the approximate Hessian but not the minimum. They are
/// stored in units of about `largest_move` (moves) and `largest_move` / `first_step` (gradients), so that numbers stay
/// within float's range.
class Lbfgs : public Minimizer {
 public:
  /// Starts the minimization at x. `first_step`: factor of the negative gradient in the first step. `largest_move`:
  /// upper limit of the change of a component of x in one iteration.
  Lbfgs(Objective& objective, std::vector<double> x, double first_step, double largest_move);
  bool iterate() override;
  Memory memory() const override;
  void remember(const Memory& memory) override;

 private:
  using Vector = std::vector<float>;
  static constexpr int most_corrections = 8, most_vectors = 2 * most_corrections;

  int vectors() const { return static_cast<int>(vectors_.size()); }
  std::vector<double> factors() const;
  void find_direction();
  bool search();
  void add_correction();
  void measure_newest();
  void replace_oldest();

  double first_step_, largest_move_;
  double length_, force_;  ///< Units of stored moves and gradients: powers of two, so that scaling is exact
  /// Stored corrections, the oldest first: for each the move of x (unit length_) and the change of the gradient (unit
  /// force_).
  std::vector<Vector> vectors_;
  std::array<std::array<double, most_vectors>, most_vectors> product_{};  ///< Scalar products of stored vectors
  std::array<double, most_vectors> with_gradient_{};  ///< Scalar products with the gradient (unit force_)
  std::vector<double> direction_;
  double slope_ = 0, longest_ = 0;  ///< Slope of the value along the direction; the direction's largest component
  Point next_;
};

}  // namespace lichtenberg::minimize
