#include "src/effects/adhesion.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/flat_walls.hpp"
#include "src/effects/friction.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/effects/uniform_field.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/effects/viscoelastic_contact.hpp"

namespace lichtenberg::effects {

const EffectKinds& all_kinds() {
  static const EffectKinds kinds = [] {
    EffectKinds all = conductor_kinds();
    for (const EffectKind* kind : {
             &SoftRepulsionOptions::kind(),
             &ViscoelasticContactOptions::kind(),
             &LinearContactOptions::kind(),
             &FrictionOptions::kind(),
             &AdhesionOptions::kind(),
             &FlatWallsOptions::kind(),
             &CoulombOptions::kind(),
             &InducedDipolesOptions::kind(),
             &ChargeExchangeOptions::kind(),
             &GasDragOptions::kind(),
             &UniformForceOptions::kind(),
             &UniformFieldOptions::kind(),
         })
      all.push_back(kind);
    return all;
  }();
  return kinds;
}

}  // namespace lichtenberg::effects
