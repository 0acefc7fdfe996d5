#pragma once

#include <span>
#include <vector>

#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// Corrects positions and momenta of bodies for forces that were wrong or missing in a step (defect correction). The
/// correction is the motion that the missing force alone causes, with linear drag.
class DefectCorrection {
 public:
  /// Makes the correction for a model, which must outlive this object.
  explicit DefectCorrection(Model& model) : model_(model) {}

  /// Corrects all bodies except `fixed` (indices in ascending order) for a force error in the past dt (s). The error
  /// grew linearly from 0 at the start to `now` - `assumed` (N, by body) at the end.
  void apply(double dt, const std::vector<Vec3>& assumed, const std::vector<Vec3>& now, std::span<const int> fixed);
  /// Corrects one body for a force (N) and its rate (N/s) that were missing for the past dt (s). For dt < 0 the force
  /// will act too early, by -dt: only the impulse of this time is removed. With drag, the body then still comes to the
  /// right position. `last`: cache of coefficients for identical bodies.
  void apply(FreeFallCache& last, int body, double dt, Vec3 force, Vec3 rate);
  /// Returns the displacement (m) that apply() adds for a missing constant force of this magnitude (N) and dt > 0 (s).
  double displacement(FreeFallCache& last, int body, double dt, double force) const;

 private:
  Model& model_;
};

}  // namespace lichtenberg::mechanics
