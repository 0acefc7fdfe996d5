#include "src/mechanics/defect_correction.hpp"

#include <algorithm>

#include "src/model/body_ranges.hpp"

namespace lichtenberg::mechanics {

void DefectCorrection::apply(double dt, const std::vector<Vec3>& assumed, const std::vector<Vec3>& now,
                             std::span<const int> fixed) {
  for_ranges(*model_.team, model_.bodies.size(), [&](int first, int end) {
    FreeFallCache last;
    auto next = std::ranges::lower_bound(fixed, first);
    for (int i = first; i < end; ++i)
      if (next != fixed.end() && *next == i)
        ++next;
      else
        apply(last, i, dt, {}, (now[i] - assumed[i]) / dt);
  });
}

void DefectCorrection::apply(FreeFallCache& last, int body, double dt, Vec3 force, Vec3 rate) {
  Bodies& bodies = model_.bodies;
  const std::size_t d = bodies.dimension;
  Vec3 shift{}, velocity_gain = dt / bodies.mass[body] * force;
  if (dt > 0) {
    const FreeFall& fall = last.get(dt, bodies.mass[body], model_.drag.linear()[body]);
    shift = fall.displacement_per_force * force + fall.displacement_per_force_rate * rate;
    velocity_gain = fall.velocity_per_force * force + fall.velocity_per_force_rate * rate;
  }
  for (std::size_t k = 0; k < d; ++k) {
    bodies.position[body * d + k] += shift[k];
    bodies.momentum[body * d + k] += bodies.mass[body] * velocity_gain[k];
  }
}

double DefectCorrection::displacement(FreeFallCache& last, int body, double dt, double force) const {
  return force * last.get(dt, model_.bodies.mass[body], model_.drag.linear()[body]).displacement_per_force;
}

}  // namespace lichtenberg::mechanics
