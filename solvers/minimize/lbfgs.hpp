#pragma once

#include <array>
#include <vector>

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Limited-memory BFGS (Nocedal 1980) with backtracking: a step is accepted if it lowers the value by a share of the
/// decrease predicted by the slope (Armijo 1966).
/// The direction is a sum of past moves, past changes of the gradient and the gradient itself. Its factors follow from
/// the products of these vectors alone (Chen, Wang & Zhou 2014). An iteration therefore traverses them twice, and
/// threads share both passes. They are stored in single precision, which affects the curvature but not the minimum. To
/// make float's range independent of a scene's units, they are scaled by the length `largest_move` and the
/// corresponding force, which follows from `first_step`.
class Lbfgs : public Minimizer {
 public:
  /// Starts at x. `largest_move`: change of a component in one iteration; `first_step`: first step, in units of the
  /// gradient.
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
  double length_, force_;  ///< Units: powers of two, so that scaling is exact
  /// Move (in length_) and change (in force_) of each correction, the oldest first.
  std::vector<Vector> vectors_;
  std::array<std::array<double, most_vectors>, most_vectors> product_{};  ///< Products of two of these vectors
  std::array<double, most_vectors> with_gradient_{};                      ///< Gradient products (in force_)
  std::vector<double> direction_;
  double slope_ = 0, longest_ = 0;  ///< Slope along the direction, and its largest component
  Point next_;
};

}  // namespace lichtenberg::minimize
