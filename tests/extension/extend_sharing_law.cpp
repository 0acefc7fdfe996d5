// A law of charge sharing at contact added from outside: a rectifier, which conducts from the first conductor of a
// contact to the other alone, I = conductance (V / 1 V)^power V.
#include <doctest/doctest.h>

#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/effects.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/effect_kind.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using effects::Contact, effects::SharingLaw;

namespace {

struct RectifierOptions {
  double conductance = 0, power = 0;  ///< S at 1 V, 1
  bool joins_first = false;           ///< the contact of conductors 0 and 1 is ideal
  static const EffectKind& kind();
};

struct Rectifier : Effect {
  const EffectKind& kind() const override { return RectifierOptions::kind(); }
};

const EffectKind& RectifierOptions::kind() {
  static const EffectKind kind = {.name = "rectifier",
                                  .description = "contacts conduct in one direction",
                                  .help = "Contacts conduct in one direction.",
                                  .options = RectifierOptions{},
                                  .make = [](const Scene&) { return std::make_unique<Rectifier>(); },
                                  .sharing = [](const Scene& scene, Contact contact) -> SharingLaw {
                                    const RectifierOptions options = *scene.effects.find<RectifierOptions>();
                                    if (options.joins_first && contact == Contact{0, 1}) return {};
                                    return {.of_state = [options](const effects::ContactState& state) {
                                      const double volt = state.potential_difference;
                                      return volt > 0 ? options.conductance * std::pow(volt, options.power) : 0;
                                    }};
                                  }};
  return kind;
}

constexpr double near = 2.5, rc = 1e-3;  // radii between centres: within the contact's gap of one radius; s
// F, of two line charges; a charge that passes from one to the other changes their difference by itself over this.
const double pair_capacitance = std::numbers::pi * 4.2e-11 * 2 * radius / std::log(near);

/// Two conductors in contact.
Scene pair(const std::vector<double>& charges, const RectifierOptions& options, bool moves = false) {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + near * radius, 0.05}});
  for (std::size_t i = 0; i < 2; ++i) scene.conductors[i].charge = charges[i];
  if (!moves) scene.material.density = 1e15;
  scene.mechanics.position_tolerance = 1e-6 * radius;  // 1e-6 of the largest charge a step
  scene.effects.add(options);
  return scene;
}

ConductorFrame after(const Scene& scene, double time) {
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(time);
  return simulation.now();
}

}  // namespace

TEST_CASE("rectifier: charge decays to equal shares in one direction only") {
  const RectifierOptions diode{.conductance = pair_capacitance / rc};
  CHECK(after(pair({-1e-12, 3e-12}, diode), 20 * rc).charge == std::vector<double>{-1e-12, 3e-12});
  for (const double times : {1.0, 30.0}) {
    const ConductorFrame frame = after(pair({3e-12, -1e-12}, diode), times * rc);
    CHECK(std::abs(frame.charge[0] - 1e-12 - 2e-12 * std::exp(-times)) < 1e-3 * 3e-12);  // some hundred steps
    CHECK(frame.charge_held == 3e-12 - 1e-12);
  }
  // I = k V^2: the difference falls to half of what it was in C / (k V).
  const double volt = 2e-12 / pair_capacitance;
  const RectifierOptions square{.conductance = pair_capacitance / rc / volt, .power = 1};
  const ConductorFrame frame = after(pair({3e-12, -1e-12}, square), rc);
  CHECK(std::abs(frame.charge[0] - 2e-12) < 1e-3 * 3e-12);
  CHECK(frame.charge_held == 3e-12 - 1e-12);
}

TEST_CASE("rectifier beside an ideal contact: an electrode takes one sign only") {
  const RectifierOptions diode{.conductance = 1e3 * pair_capacitance / rc, .joins_first = true};
  for (const double charge : {2e-12, -2e-12}) {
    Scene scene = pair({charge, charge}, diode);
    scene.electrodes = {ball("ground", {0.05 + 2 * near * radius, 0.05}, 0)};
    const ConductorFrame frame = after(scene, 0.1);
    CHECK(frame.charge_held + frame.charge_drained == 2 * charge);
    CHECK(frame.potential[0] == doctest::Approx(frame.potential[1]).epsilon(1e-6));
    if (charge > 0) CHECK(std::abs(frame.charge_held) < 1e-5 * charge);
    if (charge < 0) CHECK(frame.charge_drained == 0);
  }
}

TEST_CASE("rectifier: conductors that move keep their sum; a restored run agrees") {
  const Scene scene = pair({3e-12, 1e-12}, {.conductance = pair_capacitance / rc}, true);
  Simulation whole(scene, std::make_unique<LineCharges>()), rest(scene, std::make_unique<LineCharges>());
  whole.advance_to(0.5 * rc);
  rest.restore(whole.checkpoint());
  for (Simulation* simulation : {&whole, &rest}) simulation->advance_to(20 * rc);
  CHECK(whole.now().charge == rest.now().charge);
  CHECK(whole.now().charge_held == 3e-12 + 1e-12);
}

TEST_CASE("rectifier: a second law, no contacts, infinite conductance are refused") {
  const auto refused = [](const Scene& scene, const char* why) {
    CHECK_THROWS_WITH_AS(after(scene, rc), doctest::Contains(why), InputError);
  };
  Scene scene = pair({3e-12, -1e-12}, {.conductance = INFINITY});
  refused(scene, "effects.rectifier gives a contact a conductance of inf S");
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1});
  refused(scene, "effects.rectifier and effects.contact_resistance both say how contacts share charge");
  scene.effects.remove<effects::ContactResistanceOptions>();
  scene.effects.remove<effects::ContactDischargeOptions>();
  refused(scene, "effects.rectifier needs the table [effects.contact_discharge]");
}
