#include "solvers/minimize/fire.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {
namespace {

// Parameters of Guenole et al. 2020, table 1.
constexpr double first_mixing = 0.25, mixing_decay = 0.99, faster = 1.1, slower = 0.5, first_share = 0.1;
constexpr int delay = 20;

}  // namespace

Fire::Fire(Objective& objective, std::vector<double> x, double largest_step, double largest_move)
    : Minimizer(objective, std::move(x)),
      largest_step_(largest_step),
      largest_move_(largest_move),
      step_(first_share * largest_step),
      mixing_(first_mixing),
      velocity_(point_.x.size()),
      next_(point_) {}

void Fire::stop() {
  for (std::size_t i = 0; i < velocity_.size(); ++i) {
    point_.x[i] -= 0.5 * taken_ * velocity_[i];
    velocity_[i] = 0;
  }
  step_ = std::max(step_ * slower, 1e-3 * largest_step_);
  mixing_ = first_mixing;
  downhill_ = 0;
}

bool Fire::iterate() {
  const double slope = norm(point_.gradient);
  if (slope == 0) return false;
  const double power = -dot(velocity_, point_.gradient);
  if (power > 0) {
    if (++downhill_ > delay) step_ = std::min(step_ * faster, largest_step_), mixing_ *= mixing_decay;
  } else if (downhill_ > 0) {
    stop();
  }
  for (std::size_t i = 0; i < velocity_.size(); ++i) velocity_[i] -= step_ * point_.gradient[i];
  const double turn = mixing_ * norm(velocity_) / slope;
  for (std::size_t i = 0; i < velocity_.size(); ++i)
    velocity_[i] = (1 - mixing_) * velocity_[i] - turn * point_.gradient[i];
  double step = std::min(step_, largest_move_ / largest(velocity_));
  constexpr int most_halvings = 60;
  for (int halving = 0; halving < most_halvings; ++halving, step *= 0.5) {
    for (std::size_t i = 0; i < velocity_.size(); ++i) next_.x[i] = point_.x[i] + step * velocity_[i];
    evaluate(next_);
    if (!std::isfinite(next_.value)) continue;
    std::swap(point_, next_);
    taken_ = step;
    return true;
  }
  return false;
}

Memory Fire::memory() const {
  return {{"velocity", velocity_}, {"fire", {step_, mixing_, static_cast<double>(downhill_), taken_}}};
}

void Fire::remember(const Memory& memory) {
  velocity_ = remembered(memory, "velocity", velocity_.size());
  const std::vector<double>& numbers = remembered(memory, "fire", 4);
  step_ = numbers[0], mixing_ = numbers[1], downhill_ = static_cast<int>(numbers[2]), taken_ = numbers[3];
}

}  // namespace lichtenberg::minimize
