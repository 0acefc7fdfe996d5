#include "solvers/minimize/lbfgs.hpp"

#include <fmt/format.h>

#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {

constexpr std::size_t most_corrections = 12;

Lbfgs::Lbfgs(Objective& objective, std::vector<double> x, double first_step, double largest_move)
    : Minimizer(objective, std::move(x)), first_step_(first_step), largest_move_(largest_move), next_(point_) {}

/// Two loops (Nocedal 1980): -H gradient, with H the inverse Hessian as the corrections know it.
std::vector<double> Lbfgs::direction() const {
  std::vector<double> d = point_.gradient, share(corrections_.size());
  for (std::size_t k = corrections_.size(); k-- > 0;) {
    share[k] = dot(corrections_[k].move, d) / corrections_[k].product;
    add(d, -share[k], corrections_[k].change);
  }
  const double scale = corrections_.empty()
                           ? first_step_
                           : corrections_.back().product / dot(corrections_.back().change, corrections_.back().change);
  for (double& x : d) x *= scale;
  for (std::size_t k = 0; k < corrections_.size(); ++k)
    add(d, share[k] - dot(corrections_[k].change, d) / corrections_[k].product, corrections_[k].move);
  for (double& x : d) x = -x;
  return d;
}

bool Lbfgs::search(const std::vector<double>& direction) {
  const double slope = dot(direction, point_.gradient);
  if (!(slope < 0)) return false;
  double step = std::min(1.0, largest_move_ / largest(direction));
  const double rounding = 1e-14 * std::abs(point_.value);
  constexpr double share = 1e-4;
  constexpr int most_halvings = 40;
  for (int halving = 0; halving < most_halvings; ++halving, step *= 0.5) {
    for (std::size_t i = 0; i < direction.size(); ++i) next_.x[i] = point_.x[i] + step * direction[i];
    evaluate(next_);
    if (next_.value <= point_.value + share * step * slope + rounding) return true;
  }
  return false;
}

void Lbfgs::learn() {
  Correction c{next_.x, next_.gradient};
  add(c.move, -1, point_.x);
  add(c.change, -1, point_.gradient);
  c.product = dot(c.move, c.change);
  // A negative curvature has no place in an H that is to lead downhill.
  if (!(c.product > 1e-12 * norm(c.move) * norm(c.change))) return;
  corrections_.push_back(std::move(c));
  if (corrections_.size() > most_corrections) corrections_.pop_front();
}

bool Lbfgs::iterate() {
  if (!search(direction())) {
    if (corrections_.empty()) return false;
    corrections_.clear();
    if (!search(direction())) return false;
  }
  learn();
  std::swap(point_, next_);
  return true;
}

Memory Lbfgs::memory() const {
  Memory memory;
  for (std::size_t k = 0; k < corrections_.size(); ++k) {
    memory[fmt::format("move {:02}", k)] = corrections_[k].move;
    memory[fmt::format("change {:02}", k)] = corrections_[k].change;
  }
  return memory;
}

void Lbfgs::remember(const Memory& memory) {
  corrections_.clear();
  for (std::size_t k = 0; memory.contains(fmt::format("move {:02}", k)); ++k) {
    Correction c{memory.at(fmt::format("move {:02}", k)), memory.at(fmt::format("change {:02}", k))};
    c.product = dot(c.move, c.change);
    corrections_.push_back(std::move(c));
  }
}

}  // namespace lichtenberg::minimize
