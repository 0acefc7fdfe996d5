#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

struct Bodies;
class ForceJacobian;
struct State;

/// Drag force on a body at one speed, and its derivative.
struct DragForce {
  double force = 0;  ///< N, opposite to the velocity
  double slope = 0;  ///< kg/s, derivative of the force with respect to the speed
};

/// Drag law of one body: force F(v) = linear * v + nonlinear(v) (N) opposite to the velocity, v the speed (m/s). A part
/// that depends on the position, as near walls, has one coefficient for each axis. The law is linear with a constant
/// coefficient if and only if `nonlinear` and `by_position` are empty.
struct DragLaw {
  double linear = 0;  ///< linear drag coefficient (kg/s), at least 0
  /// Nonlinear part for a speed of at least 0. It is 0 N at rest, and force and slope are at least 0. Empty: none.
  std::function<DragForce(double)> nonlinear{};
  /// Drag coefficients (kg/s) along x, y and z at a position (m) of the body, in addition to `linear`; at least 0. The
  /// force along an axis is minus its coefficient times that component of the velocity. Empty: none.
  std::function<Vec3(Vec3)> by_position{};
};

/// Total drag on each of N bodies: the sum of the drag laws that the effects of a model add.
class Drag {
 public:
  explicit Drag(int bodies = 0) : linear_(bodies) {}

  /// Adds a drag law to those of one body. Returns false if the law is zero: no linear coefficient and no nonlinear
  /// part. Throws InputError if the linear coefficient is negative. Throws InputError if the nonlinear part has a force
  /// at rest, a negative force or slope, or a slope that is not the derivative of the force. The checks are made at
  /// speeds of 1e-6 to 10 m/s and allow one kink of the force.
  bool add(int body, const DragLaw& law);

  /// Returns true if the drag of every body is linear with a constant coefficient.
  bool is_linear() const { return nonlinear_.empty() && by_position_.empty(); }
  bool is_linear(int body) const {
    return (nonlinear_.empty() || !nonlinear_[body]) && (by_position_.empty() || !by_position_[body]);
  }
  /// Returns the linear drag coefficients (kg/s), [N]: lower bounds on the drag force divided by the speed.
  std::span<const double> linear() const { return linear_; }
  /// Returns the smallest drag coefficient (kg/s) of a body at a speed (m/s). It is the linear coefficient plus the
  /// smaller of dF/dv (along the velocity) and F/v (across it) of the nonlinear force F. The part that depends on the
  /// position is omitted, because it may vanish.
  double resistance(int body, double speed) const;
  /// Returns the power (W) that the total drag on a body dissipates at a position (m) and a velocity (m/s).
  double power(int body, Vec3 position, Vec3 velocity) const;
  /// Returns the power (W) of the parts of the drag that are nonlinear or depend on the position (m), at a velocity
  /// (m/s).
  double nonlinear_power(int body, Vec3 position, Vec3 velocity) const;

  /// Adds the drag forces on the requested bodies to `force` (N, [N * dimension]).
  void add_forces(const State& state, std::span<double> force) const;
  /// Adds the derivatives of the drag forces by the momenta (1/s) for the requested bodies.
  void add_jacobian(const State& state, ForceJacobian& jacobian) const;

 private:
  DragForce nonlinear(int body, double speed) const;
  Vec3 by_position(int body, Vec3 position) const;

  std::vector<double> linear_;                               ///< kg/s, [N]
  std::vector<std::function<DragForce(double)>> nonlinear_;  ///< [N], or empty if no law is nonlinear
  std::vector<std::function<Vec3(Vec3)>> by_position_;       ///< [N], or empty if no law depends on the position
};

}  // namespace lichtenberg
