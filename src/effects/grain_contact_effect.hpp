#pragma once

#include "src/model/effect.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Effect that defines the damped contact force law of grains. The integrator of grains
/// (src/granular/contact_motion.hpp) reads the law and computes the motion in contact. The effect adds no forces
/// itself.
class GrainContactEffect : public Effect {
 public:
  GrainContactEffect(const EffectKind& kind, GrainContactLaw law) : kind_(kind), law_(law) {}

  const EffectKind& kind() const override { return kind_; }
  const GrainContactLaw* grain_contact() const override { return &law_; }

 private:
  const EffectKind& kind_;
  GrainContactLaw law_;
};

/// Implements EffectKind::device for a contact law. It adds nothing, because a device reads the law from
/// Effect::grain_contact.
inline void contact_on_device(const Scene&, DeviceForces&) {}

}  // namespace lichtenberg::effects
