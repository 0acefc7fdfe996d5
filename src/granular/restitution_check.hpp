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

/// Returns the exact restitution coefficient and duration (t0) of a head-on collision of two grains for a contact law.
/// `effective_mass`: m_i m_j / (m_i + m_j); `scale`: the law's factor of the forces for the radii; `speed`: impact
/// speed (v0), > 0. Both results are 0 for viscoelastic grains beyond the end of theory::RestitutionCurve, where the
/// restitution coefficient is below 1e-3.
HeadOnCollision expected_collision(const GrainContactLaw& law, double effective_mass, double scale, double speed);

/// Statistics of the errors of the restitution coefficient in a run, by decade of the impact speed. Each nearly head-on
/// collision of an isolated pair is compared with the exact value for its contact law.
class RestitutionCheck {
 public:
  static constexpr int first_decade = -8, decades = 12;  ///< the outermost ones include all slower and faster impacts
  /// Errors of the collisions in one decade of the impact speed.
  struct Decade {
    std::int64_t collisions = 0;
    double sum = 0, worst = 0;  ///< sum and maximum of |restitution coefficient - exact value|

    double mean() const { return sum / static_cast<double>(collisions); }
  };

  /// A completed collision of two grains without contact with a third one.
  struct IsolatedCollision {
    double began = 0, lasted = 0;                                      ///< onset and duration (t0)
    double impact_speed = 0, parting_speed = 0, tangential_speed = 0;  ///< v0; tangential_speed: at the end

    /// Returns |parting_speed / impact_speed - expected|, the error of the restitution coefficient.
    LICHTENBERG_HOST_DEVICE double error(double expected) const {
      return std::abs(parting_speed / impact_speed - expected);
    }
  };

  /// Returns the index (0 ... decades - 1) of the decade of an impact speed (v0).
  LICHTENBERG_HOST_DEVICE static int decade_of(double speed) {
    const int index = static_cast<int>(std::floor(std::log10(speed))) - first_decade;
    return index < 0 ? 0 : index < decades ? index : decades - 1;
  }
  /// Returns true if a collision enters the statistics: it began at the time `since` or later, and is nearly head-on. A
  /// pair with tangential speed u gains about u^2 t / reach of speed along its line of centres within a time t. The
  /// gain must be less than 1e-3 of the impact speed. `reach`: the sum of the radii (d0).
  LICHTENBERG_HOST_DEVICE static bool counts(const IsolatedCollision& c, double since, double reach) {
    constexpr double share = 1e-3;
    return c.impact_speed > 0 && c.began >= since &&
           c.tangential_speed * c.tangential_speed * c.lasted < share * c.impact_speed * reach;
  }

  /// Adds the collisions of isolated pairs among the contacts `ended` to the statistics, if counts() accepts them.
  /// `law`: contact law since the time `since` (t0).
  void count(std::span<const Collision> ended, const Bodies& bodies, const GrainContactLaw& law, double since);
  /// Returns the errors of the restitution coefficient by decade of the impact speed.
  const std::array<Decade, decades>& by_speed() const { return decade_; }
  /// Returns the errors of the restitution coefficient of all collisions together.
  Decade all() const;

  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);

 private:
  std::array<Decade, decades> decade_{};
};

}  // namespace lichtenberg::granular
