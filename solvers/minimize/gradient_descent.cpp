#include "solvers/minimize/gradient_descent.hpp"

#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {

GradientDescent::GradientDescent(Objective& objective, std::vector<double> x, double step, double largest_move)
    : Minimizer(objective, std::move(x)), step_(step), largest_move_(largest_move), next_(point_) {}

bool GradientDescent::iterate() {
  const double steepest = largest(point_.gradient);
  // Tolerance for rounding of the value, a sum of many terms: a step without a significant increase is accepted.
  const double rounding = 1e-13 * std::abs(point_.value);
  double step = steepest * step_ > largest_move_ ? largest_move_ / steepest : step_;
  constexpr int most_halvings = 60;
  for (int halving = 0; halving < most_halvings; ++halving, step *= 0.5) {
    for (std::size_t i = 0; i < next_.x.size(); ++i) next_.x[i] = point_.x[i] - step * point_.gradient[i];
    evaluate(next_);
    if (!(next_.value <= point_.value + rounding)) continue;
    std::swap(point_, next_);
    return true;
  }
  return false;
}

}  // namespace lichtenberg::minimize
