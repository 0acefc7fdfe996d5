#include "src/effects/circuit.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "solvers/error.hpp"
#include "src/analysis/circuit.hpp"
#include "src/effects/charges.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/energy_budget.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/mechanics/summary.hpp"
#include "tests/line_charges.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace circuit_test {

using namespace lichtenberg;
using namespace lichtenberg::effects;
using namespace lichtenberg::steel_spheres;

namespace {

/// Scene with a neutral sphere, on which line charges exert no force, and a distant ball at 1 kV behind a resistor. The
/// ball's capacitance to the far ground of LineCharges is `capacitance`; the neutral sphere does not change it.
Scene resistor_scene(double ohm) {
  Scene scene = conductor_scene({{0.02, 0.05}});
  scene.electrodes = {ball("supplied", {0.08, 0.05}, 1000)};
  scene.electrodes[0].series_resistance = ohm;
  scene.domain.sides[2].electrode = true;  // The ground of LineCharges.
  return scene;
}
const double capacitance = 2 * std::numbers::pi * 4.2e-11 * 2 * radius / std::log(0.1 / radius);  // F

double balance(const ConductorFrame& f, double initial_charge = 0) {
  return f.charge_held + f.charge_drained + f.charge_leaked - f.charge_fed - initial_charge;
}

/// Conserved energy (J): stored energy minus supplied energy plus dissipated energy.
double total_energy(const ConductorFrame& f) {
  const EnergyBalance& e = *f.energy_balance;
  return f.energy + e.kinetic + e.elastic - e.flows.supplied() + e.flows.dissipated();
}

}  // namespace

// ---- a step of charge

TEST_CASE("charge_step: integrates a constant current with leakage for any step") {
  const double tau = 0.7, current = 3;
  for (const double dt : {1e-6, 0.1, 5.0, 400.0}) {
    const double exact = current * tau * -std::expm1(-dt / tau);
    CHECK(current * charge_step(dt, 0, tau).weight == near(exact, 1e-12));
    CHECK(current * charge_step(dt, 0, INFINITY).weight == near(current * dt, 1e-12));
    const double before = 0.6 * dt, carried_before = current * tau * -std::expm1(-before / tau);
    const ChargeStep step = charge_step(dt, before, tau);
    CHECK(step.weight * current + step.inherited * carried_before == near(exact, 1e-12));
    CHECK(step.total_weight * current + step.total_inherited * current * before == near(current * dt, 1e-12));
  }
}

TEST_CASE("second charge_step: exact for linear current, O(dt^3) error if leaking") {
  const double dt = 0.3, before = 0.2;
  const auto integral = [](double from, double to) { return 0.5 * (to * to - from * from); };  // of I = t
  const ChargeStep step = charge_step(dt, before, INFINITY);
  const double end = 1.0;
  CHECK(step.weight * end + step.inherited * integral(end - dt - before, end - dt) ==
        near(integral(end - dt, end), 1e-12));
  // With leakage the error is of third order: halving all times divides it by 8.
  const auto over = [&](double scale) {
    const double tau = 1, h = dt * scale, b = before * scale;
    const auto left = [&](double from, double to) {  // integral of s exp(-(to - s) / tau)
      const auto primitive = [&](double s) { return (s - tau) * tau * std::exp(-(to - s) / tau); };
      return primitive(to) - primitive(from);
    };
    const ChargeStep s = charge_step(h, b, tau);
    return std::abs(s.weight * end + s.inherited * left(end - h - b, end - h) - left(end - h, end));
  };
  CHECK(over(0.02) / over(0.01) == doctest::Approx(8).epsilon(0.05));
}

TEST_CASE("charge_error: equals the error of one backward Euler step of charge") {
  // Backward Euler carries dt I(end). For a linear current this is too little by dt (I(start) - I(end)) / 2.
  CHECK(charge_error(0.1 * 1.0, 0.1, 1.2, 1.0, 0) == doctest::Approx(0.01).epsilon(0.2));
  CHECK(charge_error(0.1 * 1.2, 0.1, 1.0, 1.2, 0) == near(0.01, 1e-12));
  // For dQ/dt = -Q and a step z, backward Euler carries z / (1 + z) instead of 1 - e^-z. The estimate is the
  // difference.
  for (const double z : {0.1, 1.0, 10.0, 1000.0})
    CHECK(charge_error(z / (1 + z), z, 1, 1 / (1 + z), 0) == near(std::abs(z / (1 + z) + std::expm1(-z)), 1e-9));
  CHECK(charge_error(1.0, 1, 1.0 + 1e-3, 1.0, 2e-3) < 1e-15);  // The error is below the noise.
}

// ---- leakage

TEST_CASE("leakage: charge relaxes exponentially to I tau, exact for any step") {
  for (const Integrator integrator : {Integrator::cvode, Integrator::euler}) {
    Scene scene = scene_of({{0.05, 0.05}});
    scene.effects.add<effects::FloatingConductorsOptions>();
    scene.domain.sides[0].electrode = true;
    scene.effects.add(effects::LeakageOptions{.conductivity = 4.2e-11 / 0.3});  // tau = 0.3 s
    scene.effects.add(effects::CurrentInjectionOptions{.current = 1e-10});
    scene.conductors[0].charge = -2e-11;
    scene.mechanics.integrator = integrator;
    scene.mechanics.euler_step = scene.mechanics.euler_field_step = 0.05;
    Simulation simulation(scene, no_forces());
    for (const double time : {0.1, 0.5, 3.0}) {
      simulation.advance_to(time);
      const ConductorFrame frame = simulation.now();
      const double steady = 1e-10 * 0.3, exact = steady + (-2e-11 - steady) * std::exp(-time / 0.3);
      CHECK(frame.charge[0] == near(exact, 1e-12));
      CHECK(std::abs(balance(frame, -2e-11)) < 1e-15 * frame.charge_fed);
      CHECK(frame.charge_leaked == near(1e-10 * time - 2e-11 - exact, 1e-11));
    }
  }
}

TEST_CASE("leakage: the source of a fixed potential delivers the lost Q / tau") {
  // At a fixed 1 kV the charge stays Q = C V, and the supply delivers Q / tau.
  Scene scene = scene_of({{0.05, 0.05}});
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.groups = {{.name = "held", .potential = 1000.0}};
  scene.conductors[0].group = 0;
  scene.effects.add(effects::LeakageOptions{.conductivity = 4.2e-11 / 0.3});
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(1.2);
  const ConductorFrame frame = simulation.now();
  const double q = 1000 * capacitance;
  CHECK(frame.charge[0] == near(q, 1e-6));  // LineCharges drifts by 1e-9 per solve.
  CHECK(frame.charge_leaked == near(q * 1.2 / 0.3, 1e-6));
  CHECK(-frame.terminals[0].drained == near(q + q * 1.2 / 0.3, 1e-6));
  CHECK(frame.energy_balance->flows.leakage == near(1000 * q * 1.2 / 0.3, 1e-6));  // V^2 C / tau
}

// ---- resistors

TEST_CASE("series resistor: electrode charges as 1 - exp(-t/RC) within 4 tolerances") {
  const double ohm = 0.2 / capacitance;  // RC = 0.2 s
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    Scene scene = resistor_scene(ohm);
    scene.mechanics.position_tolerance = tolerance * radius;
    scene.mechanics.largest_step = 1;
    Simulation simulation(scene, std::make_unique<LineCharges>());
    double worst = 0;
    for (const double time : {0.1, 0.3, 1.0}) {
      simulation.advance_to(time);
      const ConductorFrame frame = simulation.now();
      worst = std::max(worst, std::abs(frame.terminals[0].surface_potential / 1000 - -std::expm1(-time / 0.2)));
      CHECK(-frame.charge_drained == near(frame.charge_held, 1e-14));
    }
    // Step errors accumulate and decay with RC. The sum is at most a step's tolerance times the number of steps in RC.
    const double steps = static_cast<double>(simulation.counters().steps);
    CHECK(worst < tolerance * steps);
    CHECK(worst < 4 * tolerance);  // Regression values: 0.4, 1.1 and 2.8.
    // A second-order method: the number of steps grows with the cube root of 1 / tolerance.
    CHECK(steps < 10 / std::cbrt(tolerance));
  }
}

TEST_CASE("series resistor: the error of the charge stays below field.accuracy") {
  const double ohm = 0.2 / capacitance;
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-5}) {  // LineCharges drifts by 1e-9 per solve.
    CAPTURE(accuracy);
    Scene scene = resistor_scene(ohm);
    scene.field().chosen_for = FieldAccuracy{.requested = accuracy, .estimate = accuracy};
    scene.field().moving_tolerance = 0.1 * accuracy;  // The chosen solver tolerance is finer than the accuracy.
    scene.mechanics.largest_step = 1;
    Simulation simulation(scene, std::make_unique<LineCharges>());
    for (const double time : {0.1, 0.3, 1.0}) {
      simulation.advance_to(time);
      const double charged = simulation.now().terminals[0].surface_potential / 1000;  // Relative to the final charge.
      CHECK(std::abs(charged + std::expm1(-time / 0.2)) < accuracy);
    }
  }
}

// Q_a(t) = Q (a + b exp(-t / tau)) / (a + b) with tau = R 4 pi eps a b / (a + b). The spheres are so far apart that
// their mutual capacitance changes tau by less than 1 %. The field gives this change at the start and at the end.
TEST_CASE("two spheres joined by a resistance: charge error below field.accuracy") {
  const double farad = 4 * std::numbers::pi * 8.8541878128e-12 * 0.01 * 0.02 / 0.03, ohm = 1 / farad;
  const auto charge_at = [&](double accuracy, double time) {
    Simulation simulation(effects::with_field_chosen(parse_scene(
        fmt::format("domain = {{ size = [3, 1, 1], open = true }}\nmedium = {{ relative_permittivity = 1 }}\n"
                    "field = {{ accuracy = {} }}\n[[conductor]]\nposition = [0.5, 0.5, 0.5]\nradius = 0.01\n"
                    "charge = 1e-9\nfixed = true\n[[conductor]]\nposition = [2.5, 0.5, 0.5]\nradius = 0.02\n"
                    "fixed = true\n[effects.floating_conductors]\n[effects.contact_discharge]\ncontact_distance = 2.5\n"
                    "[effects.contact_resistance]\nresistance = {}\n[stop]\ntime = 50\n[output]\nevery = 50\n",
                    accuracy, ohm),
        "wire.toml")));
    simulation.advance_to(time);
    return simulation.now().charge[0] / 1e-9;
  };
  // Initial rate: d(V_a - V_b)/dQ of two spheres 2 m apart is 1 / (4 pi eps) (1/a + 1/b - 2/d). The next term is below
  // 1e-5 of it.
  const double rate = 1 - 2.0 / 2 / 150, end = (1 / 0.02 - 0.5) / (1 / 0.01 + 1 / 0.02 - 1);
  for (const double accuracy : {1e-3, 1e-4})
    for (const double time : {0.5, 1.0, 2.0}) {
      CAPTURE(accuracy);
      const double expected = end + (1 - end) * std::exp(-rate * time);
      CHECK(std::abs(charge_at(accuracy, time) - expected) < accuracy);
    }
}

TEST_CASE("series resistor: the charge error is of second order in the step") {
  const double ohm = 0.2 / capacitance;
  const auto error = [&](double dt) {
    Scene scene = resistor_scene(ohm);
    scene.mechanics.integrator = Integrator::euler;
    scene.mechanics.euler_step = scene.mechanics.euler_field_step = dt;
    Simulation simulation(scene, std::make_unique<LineCharges>());
    simulation.advance_to(0.2);
    return simulation.now().terminals[0].surface_potential / 1000 + std::expm1(-1);
  };
  CHECK(error(0.01) / error(0.005) == doctest::Approx(4).epsilon(0.1));
  CHECK(error(0.005) / error(0.0025) == doctest::Approx(4).epsilon(0.05));
}

TEST_CASE("series resistor: a tiny one acts as none, a huge one insulates") {
  Scene scene = resistor_scene(1e-3 / capacitance * 1e-6);  // RC = 1 ns
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(0.3);
  CHECK(simulation.now().terminals[0].surface_potential == near(1000, 1e-7));
  CHECK(simulation.counters().field_solves < 30);  // Regression value: 20; RC fits 3e8 times into the time.
  scene.electrodes[0].series_resistance = 1e12 / capacitance;
  Simulation open(scene, std::make_unique<LineCharges>());
  open.advance_to(0.3);
  CHECK(open.now().terminals[0].surface_potential == near(1000 * 0.3e-12, 1e-3));
}

TEST_CASE("electrode behind a resistor: contact with a fixed potential is refused") {
  Scene scene = resistor_scene(1e9);
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.conductors[0] = {.position = {0.08 - 1.9 * radius, 0.05}, .radius = radius, .group = 0};
  scene.groups = {{.name = "held", .potential = 1000.0}};
  Simulation touching(scene, std::make_unique<LineCharges>());
  CHECK_THROWS_AS(touching.now(), InputError);
  scene.electrodes[0].series_resistance = 0;
  Simulation one(scene, std::make_unique<LineCharges>());
  CHECK_NOTHROW(one.now());
}

TEST_CASE("series resistor: monolithic coupling of the field is refused") {
  Scene scene = resistor_scene(1e9);
  scene.mechanics.coupling = FieldCoupling::monolithic;
  CHECK_THROWS_WITH_AS(Simulation(scene, std::make_unique<LineCharges>()), doctest::Contains("\"monolithic\""),
                       InputError);
}

TEST_CASE("series resistor: energy balances; half of it becomes heat once charged") {
  for (const double rc : {1e-9, 0.2, 100.0})
    for (const double tau : {0.0, 0.1}) {
      Scene scene = resistor_scene(rc / capacitance);
      if (tau > 0) scene.effects.add(effects::LeakageOptions{.conductivity = 4.2e-11 / tau});
      Simulation simulation(scene, std::make_unique<LineCharges>());
      simulation.advance_to(1.1);
      const ConductorFrame frame = simulation.now();
      const EnergyFlows& flows = frame.energy_balance->flows;
      // The k-th solve of LineCharges has a relative error of 1e-9 k, hence also the energy that a step records.
      const auto solves = static_cast<double>(frame.field_solves);
      CHECK(std::abs(total_energy(frame)) < 0.5e-9 * solves * solves * flows.supplied());
      if (tau == 0) {
        CHECK(flows.leakage == 0);
        if (rc < 0.3) CHECK(flows.series_resistors == near(0.5 * capacitance * 1e6, rc < 1e-3 ? 1e-6 : 2e-2));
      }
      CHECK(flows.by_supplies == near(1000 * frame.terminals[0].delivered, 1e-12));
      CHECK(flows.contacts == 0);
      CHECK(std::abs(balance(frame)) < 1e-14 * frame.terminals[0].delivered);
    }
}

TEST_CASE("contact resistance tending to 0: charges and heat as in ideal contact") {
  Scene scene = scene_of({{0.05, 0.05}, {0.05 + 2.5 * radius, 0.05}});
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.01});
  scene.conductors[0].charge = 3e-12;
  scene.conductors[1].charge = -1e-12;
  scene.electrodes = {ball("ground", {0.01, 0.01}, 0)};
  for (Conductor& conductor : scene.conductors) conductor.radius = radius;
  scene.material.density = 1e15;  // The mass keeps all bodies at rest.
  Scene separate = scene;
  separate.effects.remove<effects::ContactDischargeOptions>();
  const double first_energy = Simulation(separate, std::make_unique<LineCharges>()).now().energy;
  Simulation ideal(scene, std::make_unique<LineCharges>());
  ideal.advance_to(1e-3);
  const ConductorFrame merged = ideal.now();
  for (const double rc : {1e-4, 1e-6, 1e-9}) {
    scene.effects.add(effects::ContactResistanceOptions{.resistance = rc / capacitance});
    Simulation resistive(scene, std::make_unique<LineCharges>());
    resistive.advance_to(1e-3);
    const ConductorFrame frame = resistive.now();
    CHECK(frame.group == std::vector<int>{0, 0});
    CHECK(resistive.counters().field_solves < 60);  // Regression values: 30, 52, 2.
    CHECK(frame.charge[0] + frame.charge[1] == near(2e-12, 1e-14));
    // The difference decays with R C_pair, where C_pair = 2 pi eps depth / (2 ln(d/R)). One implicit step of length t
    // leaves R C_pair / t of it; more steps leave less.
    const double relaxation = rc * std::log(0.1 / radius) / (2 * std::log(2.5));
    const double left = (frame.charge[0] - merged.charge[0]) / (3e-12 - merged.charge[0]);
    CHECK(std::abs(left) < relaxation / 1e-3 + 1e-7);
    // The heat in the contact equals the field's loss, as in the spark of an ideal contact.
    const EnergyBalance& energy = *frame.energy_balance;
    CHECK(energy.flows.contacts == near(first_energy - frame.energy, 1e-5));
    if (rc < 1e-5) CHECK(energy.flows.contacts == near(first_energy - merged.energy, 1e-2));
  }
}

TEST_CASE("contact resistance: conductors that touch at the start are refused") {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + 2 * radius, 0.05}});
  scene.conductors[0].charge = 1e-12;
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1e14});
  CHECK_THROWS_WITH_AS(Simulation(scene, std::make_unique<LineCharges>()).now(),
                       doctest::Contains("they touch at the start: begin with a gap between them"), Failure);
}

/// Scene of a series circuit: two balls behind resistors in an insulated box and a chain of three spheres between them.
Scene series_circuit() {
  Scene scene = conductor_scene({{0.0175, 0.0195}, {0.0195, 0.0195}, {0.0215, 0.0195}});
  scene.domain.size = {0.039, 0.039};
  scene.electrodes = {ball("high", {0.0155, 0.0195}, 400), ball("low", {0.0235, 0.0195}, -200)};
  scene.field().cells = 128;
  scene.field().moving_tolerance = 1e-6;
  scene.material.density = 1e15;  // The mass keeps all bodies at rest.
  return scene;
}

TEST_CASE("series circuit in an insulated box: potentials obey Kirchhoff's laws") {
  const double farad = 1e-13;  // An arbitrary value.
  Scene scene = series_circuit();
  scene.electrodes[0].series_resistance = 1e-3 / farad;
  scene.electrodes[1].series_resistance = 3e-3 / farad;
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 0.5e-3 / farad});
  Simulation simulation(scene);
  const double ohm = (1e-3 + 3e-3 + 4 * 0.5e-3) / farad, current = 600 / ohm;
  // Initially the capacitances are uncharged, and the potential level gives both resistors the same current.
  const ConductorFrame first = simulation.now();
  CHECK(first.terminals[0].surface_potential == near(400 - 600.0 / 4, 1e-6));
  CHECK(first.terminals[1].surface_potential == near(400 - 600.0 / 4, 1e-6));
  simulation.advance_to(0.2);  // More than 30 times the longest RC.
  const ConductorFrame before = simulation.now();
  simulation.advance_to(0.3);
  const ConductorFrame frame = simulation.now();
  const auto delivered = [&](int k) { return frame.terminals[k].delivered - before.terminals[k].delivered; };
  CHECK(delivered(0) == near(0.1 * current, 1e-5));
  CHECK(delivered(1) == near(-0.1 * current, 1e-5));
  CHECK(frame.terminals[0].surface_potential == near(400 - scene.electrodes[0].series_resistance * current, 1e-5));
  CHECK(frame.terminals[1].surface_potential == near(-200 + scene.electrodes[1].series_resistance * current, 1e-5));
  const EnergyFlows& flows = frame.energy_balance->flows;
  CHECK(flows.by_supplies == near(400 * frame.terminals[0].delivered - 200 * frame.terminals[1].delivered, 1e-12));
  CHECK(std::abs(total_energy(frame) - total_energy(first)) < 1e-5 * flows.supplied());
}

TEST_CASE("injected current: divides between two series resistors by conductance") {
  const double farad = 1e-13;
  Scene scene = series_circuit();
  scene.electrodes[0].series_resistance = 1e-3 / farad;
  scene.electrodes[1].series_resistance = 3e-3 / farad;
  scene.electrodes[1].potential = 400;
  scene.effects.add(effects::CurrentInjectionOptions{.current = 1e-9});
  Simulation simulation(scene);  // Ideal contacts: all conductors form one group.
  CHECK(simulation.now().potential[1] == near(400 + 3e-9 * 0.75e-3 / farad, 1e-6));
  simulation.advance_to(0.1);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.terminals[0].delivered == near(-0.75 * 3e-10, 1e-5));
  CHECK(frame.terminals[1].delivered == near(-0.25 * 3e-10, 1e-5));
  CHECK(std::abs(balance(frame)) < 1e-14 * frame.charge_fed);
}

TEST_CASE("dense circuit: charge balances to 1e-12; restored run has identical bits") {
  for (const auto& [integrator, every] : {std::tuple{Integrator::cvode, 0.05}, {Integrator::euler, 0.02}}) {
    Scene scene = random_spheres();
    scene.electrodes.push_back(ball("high", {0.062, 0.05}, 50));
    scene.electrodes.back().series_resistance = 0.05 / capacitance;
    scene.effects.add(effects::ContactResistanceOptions{.resistance = 0.01 / capacitance});
    scene.effects.add(effects::LeakageOptions{.conductivity = 4.2e-11 / 0.5});
    scene.mechanics.integrator = integrator;
    const double initial = [&] {
      double sum = 0;
      for (const Conductor& c : scene.conductors) sum += c.charge;
      return sum;
    }();
    Simulation whole(scene, std::make_unique<LineCharges>());
    Checkpoint middle;
    for (int k = 1; k <= 8; ++k) {
      whole.advance_to(k * every);
      const ConductorFrame frame = whole.now();
      const Checkpoint checkpoint = whole.checkpoint();
      if (k == 4) middle = checkpoint;
      CHECK(std::abs(balance(frame, initial)) < 1e-12 * (frame.charge_fed + initial));
      CHECK(frame.charge_leaked != 0);
    }
    CHECK(whole.counters().contacts_made > 0);
    Simulation resumed(scene, std::make_unique<LineCharges>());
    resumed.restore(middle);
    for (int k = 5; k <= 8; ++k) {
      resumed.advance_to(k * every);
      resumed.checkpoint();
    }
    CHECK(resumed.checkpoint().reals == whole.checkpoint().reals);
  }
}

TEST_CASE("EnergyBudget: flows up to a contact use extrapolated potentials") {
  Scene scene = conductor_scene({{0.02, 0.05}});
  scene.electrodes = {ball("high", {0.08, 0.05}, 1000), ball("low", {0.05, 0.02}, 0)};
  scene.effects.add(effects::LeakageOptions{.conductivity = scene.medium.permittivity / 4.0});  // tau = 4 s
  mechanics::EnergyBudget budget(scene, 4);
  // The conductor's potential and the electrodes' charges grow linearly, from 2 V and 1 C at 1 s, by 3 V/s and 2 C/s.
  const auto instant = [](double time, double jump) {
    const double charge = 1 + 2 * (time - 1) + jump;
    return mechanics::EnergyBudget::Instant{time, 0, {2 + 3 * (time - 1) + jump}, {charge, -charge}, {0, 0}};
  };
  budget.record(instant(1, 0), {}, {});
  budget.record(instant(2, 0), {}, {});
  const EnergyFlows before = budget.flows();
  const double current = 0.1, leaked = 0.01;
  budget.add_step_charges(std::vector{current}, 0.5, std::vector{leaked});
  SUBCASE("with known rates") {
    SUBCASE("as they were recorded") {}
    SUBCASE("from a checkpoint") {
      mechanics::EnergyBudget same(scene, 4);
      same.restore(budget.save());
      same.add_step_charges(std::vector{current}, 0.5, std::vector{leaked});
      budget = same;
    }
    budget.record_merger(instant(2.5, -4), 0);
    CHECK(budget.flows().by_source - before.by_source == near(current * 0.5 * (5 + 6.5) / 2, 1e-12));
    // The electrode at 1 kV has 3 C at 2 s and 4 C before the merge. It leaks for 0.5 s with tau = 4 s.
    CHECK(budget.flows().leakage - before.leakage == near(leaked * (5 + 6.5) / 2 + 1000 * 0.5 / 4 * 3.5, 1e-12));
  }
  SUBCASE("after a jump: first order, with the last potential and charge") {
    budget.reset_rates();
    budget.record_merger(instant(2.5, -4), 0);
    CHECK(budget.flows().by_source - before.by_source == near(current * 0.5 * 5, 1e-12));
    CHECK(budget.flows().leakage - before.leakage == near(leaked * 5 + 1000 * 0.5 / 4 * 3, 1e-12));
  }
}

TEST_CASE("scene without circuit: records no energy balance and no link currents") {
  Simulation simulation(random_spheres(), std::make_unique<LineCharges>());
  simulation.advance_to(0.01);
  CHECK_FALSE(simulation.now().energy_balance);
  const Checkpoint checkpoint = simulation.checkpoint();
  CHECK_FALSE(checkpoint.reals.contains("energy_book"));
  CHECK_FALSE(checkpoint.reals.contains("link_currents"));
}

}  // namespace circuit_test
