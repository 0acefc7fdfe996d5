#include "src/model/drag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "src/model/effect.hpp"

namespace lichtenberg {

namespace {

/// Checks the nonlinear part of a drag law at speeds of 1e-6 to 10 m/s. Throws InputError for a force at rest, and for
/// a negative force or slope. Throws InputError if the slope differs by 1 % from the derivative of the force at more
/// than one of these speeds; at one of them the force may have a kink.
void check_nonlinear(const DragLaw& law) {
  if (const double at_rest = law.nonlinear(0).force; at_rest != 0)
    throw InputError(fmt::format("the nonlinear drag of a body is {:g} N at rest: it must be 0", at_rest));
  int wrong = 0;
  for (double speed = 1e-6; speed < 100; speed *= 10) {
    const auto [force, slope] = law.nonlinear(speed);
    if (!(force >= 0 && slope >= 0))
      throw InputError(fmt::format(
          "the nonlinear drag of a body is {:g} N with a slope of {:g} kg/s at {:g} m/s: both must be at least 0",
          force, slope, speed));
    constexpr double step = 1e-3, allowed = 0.01;  // relative; the central difference has an error of about step^2
    const double above = law.nonlinear(speed * (1 + step)).force, below = law.nonlinear(speed * (1 - step)).force;
    const double difference = (above - below) / (2 * step * speed);
    if (std::abs(difference - slope) > allowed * std::max(std::abs(difference), slope) && ++wrong > 1)
      throw InputError(
          fmt::format("the nonlinear drag of a body has a slope of {:g} kg/s at {:g} m/s, but the derivative of its "
                      "force there is {:g} kg/s",
                      slope, speed, difference));
  }
}

/// Adds a part of a drag law to the sum of earlier parts.
template <class Result, class Argument, class Add>
void append(std::function<Result(Argument)>& sum, const std::function<Result(Argument)>& part, const Add& add) {
  if (!sum) {
    sum = part;
    return;
  }
  sum = [one = std::move(sum), other = part, add](Argument argument) { return add(one(argument), other(argument)); };
}

}  // namespace

bool Drag::add(int body, const DragLaw& law) {
  if (!(law.linear >= 0))
    throw InputError(fmt::format("the drag of a body is {:g} kg/s: it must be at least 0", law.linear));
  if (law.nonlinear) check_nonlinear(law);
  linear_[body] += law.linear;
  if (law.nonlinear) {
    nonlinear_.resize(linear_.size());
    append(nonlinear_[body], law.nonlinear, [](const DragForce& a, const DragForce& b) {
      return DragForce{a.force + b.force, a.slope + b.slope};
    });
  }
  if (law.by_position) {
    by_position_.resize(linear_.size());
    append(by_position_[body], law.by_position, [](Vec3 a, Vec3 b) { return a + b; });
  }
  return law.linear > 0 || law.nonlinear || law.by_position;
}

DragForce Drag::nonlinear(int body, double speed) const {
  return nonlinear_.empty() || !nonlinear_[body] ? DragForce{} : nonlinear_[body](speed);
}

Vec3 Drag::by_position(int body, Vec3 position) const {
  return by_position_.empty() || !by_position_[body] ? Vec3{} : by_position_[body](position);
}

double Drag::resistance(int body, double speed) const {
  const auto [force, slope] = nonlinear(body, speed);
  return linear_[body] + (speed > 0 ? std::min(slope, force / speed) : slope);
}

double Drag::power(int body, Vec3 position, Vec3 velocity) const {
  return linear_[body] * norm2(velocity) + nonlinear_power(body, position, velocity);
}

double Drag::nonlinear_power(int body, Vec3 position, Vec3 velocity) const {
  const double speed = norm(velocity);
  double power = nonlinear(body, speed).force * speed;
  const Vec3 coefficient = by_position(body, position);
  for (int k = 0; k < 3; ++k) power += coefficient[k] * velocity[k] * velocity[k];
  return power;
}

void Drag::add_forces(const State& state, std::span<double> force) const {
  const Bodies& b = state.bodies;
  for_each_requested(state, [&](int i) {
    const int first = i * b.dimension, end = first + b.dimension;
    const double rate = linear_[i] / b.mass[i];
    for (int k = first; k < end; ++k) force[k] -= rate * b.momentum[k];
    const double speed = is_linear(i) ? 0 : norm(velocity_in_space(b, i));
    if (speed == 0) return;
    const double more = nonlinear(i, speed).force / (speed * b.mass[i]);
    for (int k = first; k < end; ++k) force[k] -= more * b.momentum[k];
    if (by_position_.empty()) return;
    const Vec3 here = by_position(i, position_in_space(b, i));
    for (int k = first; k < end; ++k) force[k] -= here[k - first] / b.mass[i] * b.momentum[k];
  });
}

void Drag::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  const Bodies& b = state.bodies;
  for_each_requested(state, [&](int i) {
    jacobian.add_drag(i, -linear_[i] / b.mass[i]);
    if (is_linear(i)) return;
    const Vec3 velocity = velocity_in_space(b, i);
    const double speed = norm(velocity);
    const auto [force, slope] = nonlinear(i, speed);
    const Vec3 n = speed > 0 ? velocity / speed : Vec3{1, 0, 0};
    const double across = speed > 0 ? force / speed : slope;
    const std::array<double, 3> along = {n[0], n[1], n[2]};
    jacobian.add_drag(i, std::span(along).first(b.dimension), -slope / b.mass[i], -across / b.mass[i]);
    const Vec3 here = by_position(i, position_in_space(b, i));
    for (int k = 0; k < b.dimension; ++k)
      jacobian.by_momentum.push_back({i * b.dimension + k, i * b.dimension + k, -here[k] / b.mass[i]});
  });
}

}  // namespace lichtenberg
