#pragma once

#include <array>
#include <vector>

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Limited-memory BFGS (Nocedal 1980) with backtracking: a step is taken if it lowers the value by a share of what the
/// slope promises (Armijo 1966).
///
/// The direction is a sum of the past moves, the past changes of the gradient and the gradient itself, whose factors
/// follow from these vectors' products alone (Chen, Wang & Zhou 2014). So an iteration passes through them twice, and
/// both passes can be shared. They are kept in single precision: they say how the gradient turns, not where it
/// vanishes. What a float can hold must not depend on the units that a scene is in: they are kept in the unit of length
/// that `largest_move` is and the one of force that goes with it and `first_step`.
class Lbfgs : public Minimizer {
 public:
  /// `largest_move`: of a component in one iteration; `first_step`: of the first step, in units of the gradient.
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
  void learn();
  void measure_newest();
  void replace_oldest();

  double first_step_, largest_move_;
  double length_, force_;  ///< units: powers of two, which change no digit
  /// Move (length_) and change (force_) of each correction, the oldest first.
  std::vector<Vector> vectors_;
  std::array<std::array<double, most_vectors>, most_vectors> product_{};  ///< of two of them
  std::array<double, most_vectors> with_gradient_{};                      ///< of each with the gradient (force_)
  std::vector<double> direction_;
  double slope_ = 0, longest_ = 0;  ///< of the direction: along it, and its largest component
  Point next_;
};

}  // namespace lichtenberg::minimize
