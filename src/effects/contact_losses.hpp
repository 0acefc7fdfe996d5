#pragma once

#include <array>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Losses in a contact of Hertz's elastic spheres: restitution and sliding friction.
struct ContactLosses {
  double restitution = 1;        ///< speed after over speed before a head-on collision, at any speed; 1: elastic
  double friction = 0;           ///< coefficient mu of sliding friction
  double friction_speed = 1e-4;  ///< m/s, sliding speed below which friction is viscous

  bool any() const { return restitution < 1 || friction > 0; }
};

/// Force of the losses at one instant, in addition to the elastic force.
struct LossForce {
  Vec3 force{};                 ///< N, on the body to which the normal points
  double power = 0;             ///< W, dissipated
  std::array<Vec3, 3> slope{};  ///< kg/s, derivative of the force by the relative velocity, row by row
};

/// Computes the losses of contacts with Hertz's elastic force F of stiffness S = dF/d(overlap). With the closing speed
/// c, the effective mass m and a constant z the normal force is
///
///   N = max(F + z sqrt(10/3 m S) c, 0),
///
/// whose dissipative part is proportional to overlap^(1/4) (Tsuji and others 1992). With u = overlap^(5/4), the speed
/// as a function of u is that of a linear spring and dashpot of damping ratio z (Antypov and Elliott 2011). The
/// restitution coefficient is therefore that of LinearSpringLaw::collision(), at any speed; z follows from it. Friction
/// is mu N v_t / sqrt(v_t^2 + v_s^2) against the tangential velocity v_t, with v_s = friction_speed: Coulomb's law
/// above v_s. Below it, bodies creep. Bodies do not rotate, so that friction acts as between bodies whose rotation is
/// blocked.
class ContactLoss {
 public:
  /// Throws InputError unless 0 < restitution <= 1.
  explicit ContactLoss(const ContactLosses& losses);

  bool any() const { return losses_.any(); }
  /// Returns the force on a body. `normal`: unit vector to it from the other body or the wall. `velocity`: its velocity
  /// relative to the other (m/s). `effective_mass`: kg.
  LossForce operator()(const HertzForce& elastic, double effective_mass, Vec3 normal, Vec3 velocity) const;

 private:
  ContactLosses losses_;
  double damping_ratio_ = 0;  ///< z
};

/// Adds `loss` to the derivatives of the force on body i by momenta; j: the other body, on which the force is opposite;
/// -1: a wall.
void add_loss(const LossForce& loss, int i, int j, const Bodies& bodies, ForceJacobian& jacobian);

/// Checks the keys of ContactLosses: throws InputError for a friction_speed without friction.
template <class Options>
void check_contact_losses(const Draft& draft) {
  if (draft.scene.effects.find<Options>()->losses.friction > 0) return;
  const std::string table = "effects." + Options::kind().name;
  refuse_if_given(draft, table + ".friction_speed",
                  "needs " + table + ".friction: add it, or leave friction_speed out");
}

/// Returns the scene-file keys of ContactLosses, for options with such a member `losses`.
template <class Options>
std::vector<Key> contact_loss_keys() {
  return {
      {.name = "restitution",
       .target = [](Draft& draft) { return &draft.scene.effects.find<Options>()->losses.restitution; },
       .range = {.low = 0, .high = 1, .low_itself = false},
       .help = "restitution coefficient, the speed after over the speed before a head-on collision, at any speed; 1 is "
               "elastic"},
      {.name = "friction",
       .target = [](Draft& draft) { return &draft.scene.effects.find<Options>()->losses.friction; },
       .range = ranges::not_negative,
       .help = "coefficient of sliding friction between the surfaces. Bodies do not rotate, so that they slide and do "
               "not roll"},
      {.name = "friction_speed",
       .target = [](Draft& draft) { return &draft.scene.effects.find<Options>()->losses.friction_speed; },
       .unit = "m/s",
       .range = ranges::positive,
       .help = "sliding speed below which friction falls to 0 in proportion to the speed, in m/s: bodies at rest on a "
               "slope creep at less than this speed"},
  };
}

}  // namespace lichtenberg::effects
