#pragma once

#include "src/model/effect.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Grains that touch push each other by a damped law. How they move in contact is for who moves them
/// (src/granular/contact_motion.hpp), who asks for the law; it has no forces of its own.
class GrainContactEffect : public Effect {
 public:
  GrainContactEffect(const EffectKind& kind, GrainContactLaw law) : kind_(kind), law_(law) {}

  const EffectKind& kind() const override { return kind_; }
  const GrainContactLaw* grain_contact() const override { return &law_; }

 private:
  const EffectKind& kind_;
  GrainContactLaw law_;
};

/// EffectKind::device of a law of contacts: a device takes every GrainContactLaw, from Effect::grain_contact.
inline void contact_on_device(const Scene&, DeviceForces&) {}

}  // namespace lichtenberg::effects
