#pragma once

#include <span>
#include <vector>

#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// Corrects positions and momenta of bodies for forces that were wrong or missing in a step, with linear drag.
class DefectCorrection {
 public:
  /// The model must outlive this object.
  explicit DefectCorrection(Model& model) : model_(model) {}

  /// Corrects all bodies except `fixed` (in ascending order) for a force error that grew linearly from 0 to
  /// now - assumed (N) in dt (s).
  void apply(double dt, const std::vector<Vec3>& assumed, const std::vector<Vec3>& now, std::span<const int> fixed);
  /// Corrects a body for a force (N) and its rate (N/s) that were missing for dt (s). For dt < 0 the force acted too
  /// early, and its impulse is removed: drag then brings the body to the right position.
  void apply(FreeFallCache& last, int body, double dt, Vec3 force, Vec3 rate);
  /// Returns the displacement (m) by which apply() corrects for a constant force of this magnitude (N), for dt > 0.
  double displacement(FreeFallCache& last, int body, double dt, double force) const;

 private:
  Model& model_;
};

}  // namespace lichtenberg::mechanics
