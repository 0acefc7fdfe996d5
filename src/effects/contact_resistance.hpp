#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters from which the resistance of an electrical contact between two conductors follows.
struct ContactResistanceOptions {
  double resistance = 0;      ///< resistance of each contact without its constriction resistance (ohm)
  double resistivity = 0;     ///< ohm m, of the conductors
  double contact_radius = 0;  ///< m, radius of the contact area of two surfaces
  /// Returns the resistance (ohm) of one contact: `resistance` plus the constriction resistance of the contact area,
  /// resistivity / (2 contact_radius), half of it on each side (R. Holm, Electric Contacts, 1967, eq. 4.15).
  double ohms() const { return resistance + (resistivity > 0 ? resistivity / (2 * contact_radius) : 0); }
  static const EffectKind& kind();
};

/// Effect that gives electrical contacts (ContactDischarge) a finite constant conductance. Such a contact is a resistor
/// between two conductors and does not join them to one equipotential group. The function EffectKind::sharing of its
/// description returns the conductance.
class ContactResistance : public Effect {
 public:
  const EffectKind& kind() const override { return ContactResistanceOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
};

}  // namespace lichtenberg::effects
