#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/effects/extrapolated_field.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Coefficients of the closed-form motion of a body, one component, for a time t (s). The force grows linearly in time,
/// and drag is linear:
///   m dv/dt = force + rate t - drag v.
/// The solution, which also holds without drag, is
///   x(t) - x(0) = v t phi_1 + force / m t^2 phi_2 + rate / m t^3 phi_3,
///   v(t) = v exp(-z) + force / m t phi_1 + rate / m t^2 phi_2,
///   z = t drag / m,   phi_1 = (1 - exp(-z)) / z,   phi_2 = (1 - phi_1) / z,   phi_3 = (1/2 - phi_2) / z.
struct FreeFall {
  /// Computes the coefficients for `t` in s, `mass` in kg, `drag` in kg/s.
  FreeFall(double t, double mass, double drag);
  /// Returns the displacement (m) in the time t, from the initial velocity (m/s) and force (N) and its rate (N/s).
  double displacement(double velocity, double force, double rate) const;
  /// Returns the velocity (m/s) after the time t, from the initial velocity (m/s) and force (N) and its rate (N/s).
  double final_velocity(double velocity, double force, double rate) const;

  /// Coefficients of displacement(): s, m/N, m s/N.
  double displacement_per_velocity, displacement_per_force, displacement_per_force_rate;
  /// Coefficients of final_velocity(): 1, m/(s N), m/N.
  double velocity_per_velocity, velocity_per_force, velocity_per_force_rate;
};

/// Cache of the last FreeFall, so that successive identical bodies share its coefficients.
class FreeFallCache {
 public:
  /// Returns the coefficients for `t` in s, `mass` in kg, `drag` in kg/s; recomputes them if an argument has changed.
  const FreeFall& get(double t, double mass, double drag) {
    if (!fall_ || t != t_ || mass != mass_ || drag != drag_) fall_.emplace(t_ = t, mass_ = mass, drag_ = drag);
    return *fall_;
  }

 private:
  std::optional<FreeFall> fall_;
  double t_ = 0, mass_ = 0, drag_ = 0;  ///< s, kg, kg/s
};

/// Motion of bodies without contacts, in closed form: the electric force is extrapolated linearly in time, and drag is
/// linear.
class FreeFlight {
 public:
  /// Makes the motion for a model, which must have the effect floating_conductors and outlive this object.
  explicit FreeFlight(Model& model) : model_(model), total_force_(model.bodies.position.size()) {}

  /// Finds the bodies that have no closed form of motion while each body i moves by at most travel[i] (m). Other forces
  /// (contacts, walls) may act on them, or their drag is nonlinear. Returns their indices in ascending order.
  std::vector<int> interacting(std::span<const double> travel) const;
  /// Moves all bodies from time `start` to `end` (s), or to the first event (sign change of an event function) if that
  /// is earlier. Returns the time reached.
  double advance(double start, double end, const effects::ExtrapolatedField& extrapolated, const Events& events);
  /// Moves all bodies from time `start` to `end` (s), or to the first event if that is earlier. Integrates the motion
  /// of the bodies `interacting` (in ascending order, at least one) by CVODE, and moves the others in closed form.
  /// Returns the time reached.
  double advance(double start, double end, const effects::ExtrapolatedField& extrapolated, const Events& events,
                 const std::vector<int>& interacting, Cvode& cvode);

 private:
  Model& model_;
  std::vector<double> total_force_;  ///< N, on the bodies that events watch; scratch memory
};

}  // namespace lichtenberg::mechanics
