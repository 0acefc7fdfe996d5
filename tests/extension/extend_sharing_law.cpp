// Law of charge sharing added from outside: a rectifier, which conducts from the first conductor of a contact only.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/current_injection.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/effect_kind.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

namespace extend_sharing_law {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using effects::Contact, effects::SharingLaw;

namespace {

struct RectifierOptions {
  double conductance = 0, power = 0;  ///< S at 1 V, 1: I = conductance (V / 1 V)^power V.
  bool joins_first = false;           ///< The contact of conductors 0 and 1 is ideal.
  static const EffectKind& kind();
};

struct Rectifier : Effect {
  const EffectKind& kind() const override { return RectifierOptions::kind(); }
};

const EffectKind& RectifierOptions::kind() {
  static const EffectKind kind = {.name = "rectifier",
                                  .description = "contacts conduct in one direction",
                                  .options = RectifierOptions{},
                                  .make = [](const Scene&) { return std::make_unique<Rectifier>(); },
                                  .sharing = [](const Scene& scene, Contact contact) -> SharingLaw {
                                    const RectifierOptions options = *scene.effects.find<RectifierOptions>();
                                    if (options.joins_first && contact == Contact{0, 1}) return {};
                                    return {.conductance_in_state = [options](const effects::ContactState& state) {
                                      const double volt = state.potential_difference;
                                      return volt > 0 ? options.conductance * std::pow(volt, options.power) : 0;
                                    }};
                                  }};
  return kind;
}

constexpr double near = 2.5, rc = 1e-3;  // Radii between centres, within the contact's gap of one radius; s.
// Transferred charge per change of the potential difference (F).
const double pair_capacitance = std::numbers::pi * 4.2e-11 * 2 * radius / std::log(near);

/// Scene of two conductors in contact.
Scene pair(const std::vector<double>& charges, const RectifierOptions& options, bool moves = false) {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + near * radius, 0.05}});
  for (std::size_t i = 0; i < 2; ++i) scene.conductors[i].charge = charges[i];
  if (!moves) scene.material.density = 1e15;
  scene.mechanics.position_tolerance = 1e-6 * radius;  // 1e-6 of the largest charge per step.
  scene.effects.add(options);
  return scene;
}
ConductorFrame after(const Scene& scene, double time) {
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(time);
  return simulation.now();
}

}  // namespace

TEST_CASE("user-defined rectifier: charges become equal in one direction only") {
  const RectifierOptions diode{.conductance = pair_capacitance / rc};
  CHECK(after(pair({-1e-12, 3e-12}, diode), 20 * rc).charge == std::vector<double>{-1e-12, 3e-12});
  for (const double times : {1.0, 30.0}) {
    const ConductorFrame frame = after(pair({3e-12, -1e-12}, diode), times * rc);
    CHECK(std::abs(frame.charge[0] - 1e-12 - 2e-12 * std::exp(-times)) < 1e-3 * 3e-12);  // Some hundred steps.
    CHECK(frame.charge_held == 3e-12 - 1e-12);
  }
  // I = k V^2: the difference halves in C / (k V).
  const RectifierOptions square{.conductance = pair_capacitance * pair_capacitance / (2e-12 * rc), .power = 1};
  CHECK(std::abs(after(pair({3e-12, -1e-12}, square), rc).charge[0] - 2e-12) < 1e-3 * 3e-12);
}

TEST_CASE("rectifier and ideal contact: an electrode takes charge of one sign only") {
  const RectifierOptions diode{.conductance = 1e3 * pair_capacitance / rc, .joins_first = true};
  for (const double charge : {2e-12, -2e-12}) {
    Scene scene = pair({charge, charge}, diode);
    scene.electrodes = {ball("ground", {0.05 + 2 * near * radius, 0.05}, 0)};
    const ConductorFrame frame = after(scene, 0.1);
    CHECK(frame.charge_held + frame.charge_drained == 2 * charge);
    CHECK(frame.potential[0] == doctest::Approx(frame.potential[1]).epsilon(1e-6));
    CHECK((charge > 0 ? std::abs(frame.charge_held) < 1e-5 * charge : frame.charge_drained == 0));
  }
}

TEST_CASE("rectifier: a blocking contact conducts as soon as its potential rises") {
  const double own = std::log(0.1 / radius), mutual = std::log(0.1 / (near * radius));  // Coefficients of LineCharges.
  const double capacitance = 2 * std::numbers::pi * 4.2e-11 * 2 * radius / (own - mutual * mutual / own);
  Scene scene = pair({-1e-12, 0}, {.conductance = capacitance / rc});
  scene.conductors.pop_back();
  scene.electrodes = {ball("ground", {0.05 - near * radius, 0.05}, 0)};
  scene.effects.add(effects::CurrentInjectionOptions{.current = 1e-12 / 0.05});  // 0 V is reached after 50 ms.
  CHECK(after(scene, 0.05 + rc).charge[0] / (1e-12 / 0.05 * rc) == doctest::Approx(-std::expm1(-1)).epsilon(0.01));
}

TEST_CASE("rectifier, moving conductors: total charge kept, also in a restored run") {
  const Scene scene = pair({3e-12, 1e-12}, {.conductance = pair_capacitance / rc}, true);
  Simulation whole(scene, std::make_unique<LineCharges>()), rest(scene, std::make_unique<LineCharges>());
  whole.advance_to(0.5 * rc);
  rest.restore(whole.checkpoint());
  for (Simulation* simulation : {&whole, &rest}) simulation->advance_to(20 * rc);
  CHECK(whole.now().charge == rest.now().charge);
  CHECK(whole.now().charge_held == 3e-12 + 1e-12);
}

TEST_CASE("rectifier: refuses contact_resistance, no contacts, infinite conductance") {
  Scene scene = pair({3e-12, -1e-12}, {.conductance = INFINITY});
  CHECK_THROWS_WITH_AS(after(scene, rc), doctest::Contains("a conductance of inf S"), InputError);
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1});
  CHECK_THROWS_WITH_AS(after(scene, rc), doctest::Contains("effects.rectifier and effects.contact_res"), InputError);
  scene.effects.remove<effects::ContactDischargeOptions>();
  CHECK_THROWS_WITH_AS(after(scene, rc), doctest::Contains("effects.rectifier needs the table"), InputError);
}

}  // namespace extend_sharing_law
