#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct ContactResistanceOptions {
  double resistance = 0;   ///< ohm a contact
  double resistivity = 0;  ///< ohm m, of the conductors
  double spot = 0;         ///< m, radius of the spot in which two surfaces touch
  /// Of one contact: the given one and the constriction of the current to the spot, resistivity / (2 spot)
  /// (R. Holm, Electric Contacts, 1967, eq. 4.15: each side has half of it).
  double ohms() const { return resistance + (resistivity > 0 ? resistivity / (2 * spot) : 0); }
  static const EffectKind& kind();
};

/// A contact of contact_discharge conducts instead of making two one: EffectKind::sharing.
class ContactResistance : public Effect {
 public:
  const EffectKind& kind() const override { return ContactResistanceOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
};

}  // namespace lichtenberg::effects
