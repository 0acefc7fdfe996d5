#pragma once

#include <span>
#include <vector>

#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// Corrects positions and momenta of bodies for forces that were wrong or missing in a step, with linear drag.
class DefectCorrection {
 public:
  /// The model must outlive this.
  explicit DefectCorrection(Model& model) : model_(model) {}

  /// All bodies but those in `fixed` (in ascending order) were moved for dt (s) by forces that were wrong by nothing at
  /// first and in the end by now - assumed (N).
  void apply(double dt, const std::vector<Vec3>& assumed, const std::vector<Vec3>& now, std::span<const int> fixed);
  /// A body was moved for dt (s) without this force (N) and its rate (N/s). If a force acted too early, dt < 0, its
  /// impulse is taken back: once drag has had its time, the body is where it would be.
  void apply(LastFall& last, int body, double dt, Vec3 force, Vec3 rate);
  /// How far (m) that moves a body, for dt > 0 and a force of this size (N).
  double way(LastFall& last, int body, double dt, double force) const;

 private:
  Model& model_;
};

}  // namespace lichtenberg::mechanics
