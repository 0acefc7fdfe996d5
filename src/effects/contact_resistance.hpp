#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct ContactResistanceOptions {
  double resistance = 0;      ///< ohm, for each contact
  double resistivity = 0;     ///< ohm m, of the conductors
  double contact_radius = 0;  ///< m, radius of the contact area of two surfaces
  /// Returns the resistance (ohm) of one contact: `resistance` plus the constriction resistance of the contact area,
  /// resistivity / (2 contact_radius) (R. Holm, Electric Contacts, 1967, eq. 4.15: each side has half of it).
  double ohms() const { return resistance + (resistivity > 0 ? resistivity / (2 * contact_radius) : 0); }
  static const EffectKind& kind();
};

/// Gives contacts of contact_discharge a finite conductance, so that they do not join their bodies. EffectKind::sharing
/// defines this law.
class ContactResistance : public Effect {
 public:
  const EffectKind& kind() const override { return ContactResistanceOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
};

}  // namespace lichtenberg::effects
