#pragma once

#include <array>
#include <vector>

namespace lichtenberg::effects {

/// Drag on a sphere that moves towards a plane wall or away from it, over its Stokes drag (Brenner 1961, eq. 2.19).
/// `gap`: gap over the radius, at least 1e-6. The sum over n converges as exp(-(2 n + 1) acosh(1 + gap)).
double drag_towards_wall(double gap);

/// Drag on a sphere that translates along a plane wall without rotation, over its Stokes drag, by the solution of
/// O'Neill (1964) in bipolar coordinates, as given by Goldman, Cox & Brenner (1967). `gap`: gap over the radius, at
/// least 1e-6.
double drag_along_wall(double gap);

/// Both factors of drag near a wall, interpolated between tabulated gaps with a relative error below 1e-6.
class WallDrag {
 public:
  WallDrag();
  struct Factors {
    double towards = 1, along = 1;
  };
  /// Returns the factors of drag at a gap over the radius. Below `least_gap` they are those at `least_gap`.
  Factors at(double gap) const;

  static constexpr double least_gap = 1e-4;

 private:
  std::vector<std::array<double, 2>> logarithm_;  ///< of the factors minus 1 (towards, along), at the tabulated gaps
};

}  // namespace lichtenberg::effects
