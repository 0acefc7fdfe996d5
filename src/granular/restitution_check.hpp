#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "solvers/geometry/host_device.hpp"
#include "src/model/bodies.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// Returns the head-on collision of two grains by the law of their contact, at a speed > 0. `scale`: the law's factor
/// by the radii. For viscoelastic grains beyond the end of theory::RestitutionCurve, whose restitution is below 1e-3,
/// restitution and duration are 0.
HeadOnCollision expected_collision(const GrainContactLaw& law, double effective_mass, double scale, double speed);

/// Errors of the restitution in a run, by decade of the impact speed.
class RestitutionCheck {
 public:
  static constexpr int first_decade = -8, decades = 12;  ///< the outermost ones include all slower and faster impacts
  struct Decade {
    std::int64_t collisions = 0;
    double sum = 0, worst = 0;  ///< of |restitution - expected|

    double mean() const { return sum / static_cast<double>(collisions); }
  };

  /// A collision of an isolated pair.
  struct IsolatedCollision {
    double began = 0, lasted = 0;                                      ///< t0
    double impact_speed = 0, parting_speed = 0, tangential_speed = 0;  ///< v0; tangential_speed: at the end

    LICHTENBERG_HOST_DEVICE double error(double expected) const {
      return std::abs(parting_speed / impact_speed - expected);
    }
  };

  /// Index of the decade of a speed.
  LICHTENBERG_HOST_DEVICE static int decade_of(double speed) {
    const int index = static_cast<int>(std::floor(std::log10(speed))) - first_decade;
    return index < 0 ? 0 : index < decades ? index : decades - 1;
  }
  /// Returns true if a collision counts: it began at `since` or later, under the present law, and it is central. A pair
  /// with tangential speed u gains about u^2 t / reach along its line of centres within t, which must be less than a
  /// part `share` of the impact speed. `reach`: the sum of the radii.
  LICHTENBERG_HOST_DEVICE static bool counts(const IsolatedCollision& c, double since, double reach) {
    constexpr double share = 1e-3;
    return c.impact_speed > 0 && c.began >= since &&
           c.tangential_speed * c.tangential_speed * c.lasted < share * c.impact_speed * reach;
  }

  /// Counts the collisions of isolated pairs among those that have ended; `law` holds since the time `since`.
  void count(std::span<const Collision> ended, const Bodies& bodies, const GrainContactLaw& law, double since);
  /// Returns the errors by decade of the impact speed.
  const std::array<Decade, decades>& by_speed() const { return decade_; }
  /// Returns the errors of all decades together.
  Decade all() const;

  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);

 private:
  std::array<Decade, decades> decade_{};
};

}  // namespace lichtenberg::granular
