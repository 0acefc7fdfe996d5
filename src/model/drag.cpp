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

}  // namespace

bool Drag::add(int body, const DragLaw& law) {
  if (!(law.linear >= 0))
    throw InputError(fmt::format("the drag of a body is {:g} kg/s: it must be at least 0", law.linear));
  if (law.nonlinear) check_nonlinear(law);
  linear_[body] += law.linear;
  if (!law.nonlinear) return law.linear > 0;
  nonlinear_.resize(linear_.size());
  auto& sum = nonlinear_[body];
  if (!sum) {
    sum = law.nonlinear;
  } else {
    sum = [one = std::move(sum), other = law.nonlinear](double speed) {
      const DragForce a = one(speed), b = other(speed);
      return DragForce{a.force + b.force, a.slope + b.slope};
    };
  }
  return true;
}

DragForce Drag::nonlinear(int body, double speed) const {
  return is_linear(body) ? DragForce{} : nonlinear_[body](speed);
}

double Drag::resistance(int body, double speed) const {
  const auto [force, slope] = nonlinear(body, speed);
  return linear_[body] + (speed > 0 ? std::min(slope, force / speed) : slope);
}

double Drag::power(int body, Vec3 velocity) const {
  return linear_[body] * norm2(velocity) + nonlinear_power(body, norm(velocity));
}

double Drag::nonlinear_power(int body, double speed) const { return nonlinear(body, speed).force * speed; }

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
  });
}

}  // namespace lichtenberg
