#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/effects/extrapolated_field.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Closed form of the motion of a body (one component) under a force that grows linearly and linear drag:
///   m dv/dt = force + rate t - drag v.
/// With z = t drag / m and phi_1 = (1 - exp(-z)) / z, phi_2 = (1 - phi_1) / z, phi_3 = (1/2 - phi_2) /
/// z,
///   x(t) - x(0) = v t phi_1 + force / m t^2 phi_2 + rate / m t^3 phi_3,
///   v(t) = v exp(-z) + force / m t phi_1 + rate / m t^2 phi_2,
/// which also holds without drag.
struct FreeFall {
  FreeFall(double t, double mass, double drag);
  double displacement(double velocity, double force, double rate) const;    ///< m, displacement; from m/s, N, N/s
  double final_velocity(double velocity, double force, double rate) const;  ///< m/s

  double displacement_per_velocity, displacement_per_force,
      displacement_per_force_rate;  ///< s, m/N, m s/N: coefficients of displacement()
  double velocity_per_velocity, velocity_per_force, velocity_per_force_rate;  ///< coefficients of final_velocity()
};

/// Cache of the last FreeFall, which identical bodies share.
class FreeFallCache {
 public:
  const FreeFall& get(double t, double mass, double drag) {
    if (!fall_ || t != t_ || mass != mass_ || drag != drag_) fall_.emplace(t_ = t, mass_ = mass, drag_ = drag);
    return *fall_;
  }

 private:
  std::optional<FreeFall> fall_;
  double t_ = 0, mass_ = 0, drag_ = 0;  ///< s, kg, kg/s
};

/// Motion of bodies without contacts under a constant electric force and linear drag, in closed form.
class FreeFlight {
 public:
  /// The model must outlive this object and have floating_conductors.
  explicit FreeFlight(Model& model) : model_(model), total_force_(model.bodies.position.size()) {}

  /// Returns the bodies on which other forces may act while body i moves by at most travel[i] (m).
  std::vector<int> interacting(std::span<const double> travel) const;
  /// Moves the bodies from time `start` to `end` (s), or to the first event if that is earlier, as Cvode::advance()
  /// does. Returns the time reached.
  double advance(double start, double end, const effects::ExtrapolatedField& extrapolated, const Events& events);
  /// Moves the bodies as the function above. Integrates the motion of the bodies `interacting`, at least one, by CVODE.
  double advance(double start, double end, const effects::ExtrapolatedField& extrapolated, const Events& events,
                 const std::vector<int>& interacting, Cvode& cvode);

 private:
  Model& model_;
  std::vector<double> total_force_;  ///< N, on the bodies that events watch; scratch memory
};

}  // namespace lichtenberg::mechanics
