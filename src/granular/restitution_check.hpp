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

/// The head-on collision of two grains by the law of their contact, with nothing else that acts on them.
struct ExpectedCollision {
  double restitution = 0, duration = 0;
};
/// `scale`: of E and D, by the radii (ViscoelasticLaw::scale). Speed > 0. Where grains lose all but a thousandth the
/// restitution is 0 (theory::RestitutionCurve ends there).
ExpectedCollision expected_collision(const GrainContactLaw& law, double effective_mass, double scale, double speed);

/// How far restitution in a run is from that of its law, by decade of the speed of impact. Of contacts that no third
/// grain disturbed, and central ones: a pair that goes by with tangential speed u gains about u^2 t / d along its
/// line of centres within t, so those with u^2 t / d > 1e-3 of the speed of impact are left out.
class RestitutionCheck {
 public:
  static constexpr int first_decade = -8, decades = 12;  ///< slower and faster ones count with the outermost
  struct Decade {
    std::int64_t collisions = 0;
    double sum = 0, worst = 0;  ///< of |restitution - expected|

    double mean() const { return sum / static_cast<double>(collisions); }
  };

  /// Which of them has this speed of impact.
  LICHTENBERG_HOST_DEVICE static int decade_of(double speed) {
    const int place = static_cast<int>(std::floor(std::log10(speed))) - first_decade;
    return place < 0 ? 0 : place < decades ? place : decades - 1;
  }
  /// Of two that pass at tangential speed `across` while a contact lasts; `reach`: the sum of their radii.
  LICHTENBERG_HOST_DEVICE static bool is_central(double across, double duration, double speed, double reach) {
    constexpr double share = 1e-3;
    return across * across * duration < share * speed * reach;
  }

  /// Contacts that began before `since`, under another law, do not count.
  void count(std::span<const Collision> ended, const Bodies& bodies, const GrainContactLaw& law, double since);
  const std::array<Decade, decades>& by_speed() const { return decade_; }
  Decade all() const;

  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);

 private:
  std::array<Decade, decades> decade_{};
};

}  // namespace lichtenberg::granular
