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
  double force = 0;  ///< N, opposite to the velocity
  double slope = 0;  ///< kg/s, derivative of the force with respect to the speed
};

/// Drag on one body as a function of its speed v (m/s): F(v) = linear v + nonlinear(v), opposite to the velocity. A law
/// is linear if and only if `nonlinear` is empty, so no nonlinear law can be integrated as a linear one.
struct DragLaw {
  double linear = 0;  ///< kg/s, at least 0
  /// Nonlinear part for a speed of at least 0. It is 0 N at rest, and force and slope are at least 0. Empty: none.
  std::function<DragForce(double)> nonlinear{};
};

/// Drag on the bodies of a model: the sum of the laws of its effects.
class Drag {
 public:
  explicit Drag(int bodies = 0) : linear_(bodies) {}

  /// Adds a law for a body and returns true if the law is not zero. Throws InputError for a negative linear part.
  /// Throws InputError for a nonlinear part with a force at rest, a negative force or slope, or a slope that is not its
  /// derivative.
  bool add(int body, const DragLaw& law);

  bool is_linear() const { return nonlinear_.empty(); }  ///< true if linear for every body
  bool is_linear(int body) const { return is_linear() || !nonlinear_[body]; }
  /// Linear parts (kg/s), [N]: lower bounds on the drag divided by speed.
  std::span<const double> linear() const { return linear_; }
  /// Returns the ratio of force change to velocity change (kg/s) of a body at that speed (m/s), in the direction in
  /// which it is smallest.
  double resistance(int body, double speed) const;
  /// Heating power (W) of a body at that velocity (m/s), of all laws and of the nonlinear parts alone.
  double power(int body, Vec3 velocity) const;
  double nonlinear_power(int body, double speed) const;

  /// Adds the forces (N, [N * dimension]) on the requested bodies, and their derivatives.
  void add_forces(const State& state, std::span<double> force) const;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const;

 private:
  DragForce nonlinear(int body, double speed) const;

  std::vector<double> linear_;                               ///< kg/s, [N]
  std::vector<std::function<DragForce(double)>> nonlinear_;  ///< [N], or empty if all laws are linear
};

}  // namespace lichtenberg
