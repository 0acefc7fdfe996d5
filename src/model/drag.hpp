#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

struct Bodies;
class ForceJacobian;
struct State;

/// Drag at one speed.
struct DragForce {
  double force = 0;  ///< N, against the velocity
  double slope = 0;  ///< kg/s, derivative of the force with respect to the speed
};

/// Drag on one body as a function of its speed v (m/s): F(v) = linear v + nonlinear(v), against the velocity. A law is
/// linear if and only if it has no nonlinear part, so that no law can be integrated as linear that is not.
struct DragLaw {
  double linear = 0;  ///< kg/s, at least 0
  /// The rest for a speed of at least 0; 0 N at rest, force and slope at least 0. Empty: none.
  std::function<DragForce(double)> nonlinear{};
};

/// Drag on the bodies of a model: the sum of the laws of its effects.
class Drag {
 public:
  explicit Drag(int bodies = 0) : linear_(bodies) {}

  /// Adds a law for a body; returns whether it is more than nothing. Throws InputError for a linear part below 0,
  /// and for a nonlinear part with a force at rest, a negative force or slope, or a slope that is not its derivative.
  bool add(int body, const DragLaw& law);

  bool is_linear() const { return nonlinear_.empty(); }  ///< for every body
  bool is_linear(int body) const { return is_linear() || !nonlinear_[body]; }
  /// Linear parts (kg/s), [N]: lower bounds on the drag per speed.
  std::span<const double> linear() const { return linear_; }
  /// Force over change of velocity (kg/s) of a body at that speed (m/s), in the direction in which it is least.
  double resistance(int body, double speed) const;
  /// Heat (W) that a body makes at that velocity (m/s), of all laws and of the nonlinear parts alone.
  double power(int body, Vec3 velocity) const;
  double nonlinear_power(int body, double speed) const;

  /// Adds the forces (N, [N * dimension]) on the bodies asked for, and their derivatives.
  void add_forces(const State& state, std::span<double> force) const;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const;

 private:
  DragForce nonlinear(int body, double speed) const;

  std::vector<double> linear_;                               ///< kg/s, [N]
  std::vector<std::function<DragForce(double)>> nonlinear_;  ///< [N], or empty if all laws are linear
};

}  // namespace lichtenberg
