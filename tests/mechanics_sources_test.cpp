// Sources in time, circuits of several electrodes, capacitors, and floating electrodes.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "src/analysis/circuit.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/line_charges.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace mechanics_sources_test {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;

namespace {

// Capacitance (F) of one ball to the far ground of LineCharges, and of two balls at one potential, 6 cm apart. A line
// charge q has the potential q ln(L/r) / (2 pi eps).
const double line = 2 * std::numbers::pi * 4.2e-11 * 2 * radius;
const double one_ball = line / std::log(0.1 / radius);
const double two_balls = 2 * line / (std::log(0.1 / radius) + std::log(0.1 / 0.06));

/// Scene of a neutral sphere at rest, on which LineCharges exert no force, and of balls in one circuit.
Scene circuit_scene(int balls, const Circuit& circuit) {
  Scene scene = conductor_scene({{0.02, 0.05}});
  scene.conductors[0].fixed = true;
  scene.domain.sides[2].electrode = true;  // the ground of LineCharges
  for (int k = 0; k < balls; ++k) {
    scene.electrodes.push_back(ball(fmt::format("ball {}", k), {0.06, 0.02 + 0.06 * k}, 0));
    scene.electrodes.back().circuit = 0;
  }
  scene.circuits = {circuit};
  scene.mechanics.position_tolerance = 1e-5 * radius;
  return scene;
}

/// Bound on the error of a potential over that of the source. A step h of BDF2 has the error 2/9 h^3 Q''' in the charge
/// Q. Step control (next_step, margin 0.9) keeps it at 0.9^3 of 1e-5 Q, and errors decay with RC. The integral of 1e-5
/// Q exp(-(T - t)/RC) / h over the steps before T is largest at 13e-5 of the source for charging, 14e-5 for the square
/// wave and 15e-5 for the sine.
constexpr double allowed = 16e-5;

Signal sine(double amplitude, double frequency) {
  return Signal(Waveform{.shape = Waveform::Shape::sine, .amplitude = amplitude, .frequency = frequency});
}
Signal square(double amplitude, double frequency) {
  return Signal(Waveform{.shape = Waveform::Shape::square, .amplitude = amplitude, .frequency = frequency});
}
Signal ramp(std::vector<Vec2> points) { return Signal(Waveform{.points = std::move(points)}); }

Simulation simulation_of(const Scene& scene) { return Simulation(scene, std::make_unique<LineCharges>()); }

const TerminalReading& reading(const ConductorFrame& frame, const std::string& name) {
  for (const TerminalReading& terminal : frame.terminals)
    if (terminal.name.find(name) != std::string::npos) return terminal;
  throw std::out_of_range(name);
}

/// Checks that the energy and the charge balance close. The k-th solve of LineCharges is off by 1e-9 k.
void check_balances(const ConductorFrame& frame, double initial_charge = 0, double initial_energy = 0) {
  const auto solves = static_cast<double>(frame.field_solves);
  const EnergyFlows& flows = frame.energy_balance->flows;
  const double turnover = std::abs(flows.by_supplies) + std::abs(flows.by_source) + flows.dissipated() + frame.energy;
  CHECK(std::abs(analysis::energy_account(frame) - initial_energy) < 1e-9 * solves * solves * turnover);
  const double charge = frame.charge_held + frame.charge_drained + frame.charge_leaked - frame.charge_fed;
  CHECK(std::abs(charge - initial_charge) < 1e-13 * (std::abs(frame.charge_held) + std::abs(frame.charge_fed) + 1e-12));
}

}  // namespace

TEST_CASE("circuit: two electrodes behind one resistor charge as 1-exp(-t/RC)") {
  const double ohm = 0.2 / two_balls;  // RC = 0.2 s
  Scene scene = circuit_scene(2, {.name = "pair", .resistance = ohm, .potential = 1000});
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1e12});
  Simulation simulation = simulation_of(scene);
  for (const double time : {0.1, 0.3, 1.0}) {
    simulation.advance_to(time);
    const ConductorFrame frame = simulation.now();
    const double charged = -std::expm1(-time / 0.2);
    for (const std::string name : {"ball 0", "ball 1", "pair"})
      CHECK(std::abs(reading(frame, name).surface_potential / 1000 - charged) < allowed);
    CHECK(std::abs(reading(frame, "pair").delivered / (1000 * two_balls) - charged) < allowed);
    const double shared = reading(frame, "ball 0").delivered + reading(frame, "ball 1").delivered;
    CHECK(shared == near(reading(frame, "pair").delivered, 1e-6));
    check_balances(frame);
  }
}

TEST_CASE("circuit: a capacitor adds to the electrode's capacitance") {
  const double ohm = 0.2 / (4 * one_ball);
  const Scene scene =
      circuit_scene(1, {.name = "tank", .resistance = ohm, .potential = 1000, .capacitance = 3 * one_ball});
  Simulation simulation = simulation_of(scene);
  simulation.advance_to(0.3);
  const ConductorFrame frame = simulation.now();
  const double potential = -1000 * std::expm1(-0.3 / 0.2);
  CHECK(std::abs(reading(frame, "tank").surface_potential - potential) < 1000 * allowed);
  CHECK(frame.charge_held == near(4 * one_ball * potential, 2e-4));
  CHECK(frame.energy == near(2 * one_ball * potential * potential, 4e-4));
  check_balances(frame);
}

// dQ/dt = (A sin wt - Q/C) / R with Q(0) = 0 has the potential A / (1 + z^2) (sin wt - z cos wt + z exp(-t/RC)) with
// z = w RC: the amplitude A / sqrt(1 + z^2) and the phase -atan z.
TEST_CASE("circuit: sine V(t) behind a resistor has amplitude and phase of RC") {
  const double frequency = 2, w = 2 * std::numbers::pi * frequency, rc = 0.1, z = w * rc;
  const Scene scene =
      circuit_scene(1, {.name = "line", .resistance = rc / one_ball, .potential = sine(1000, frequency)});
  Simulation simulation = simulation_of(scene);
  for (const double time : {0.05, 0.4, 1.0, 1.6}) {
    simulation.advance_to(time);
    const ConductorFrame frame = simulation.now();
    const double exact = 1000 / (1 + z * z) * (std::sin(w * time) - z * std::cos(w * time) + z * std::exp(-time / rc));
    CHECK(std::abs(reading(frame, "line").surface_potential - exact) < 1000 * allowed);
    CHECK(reading(frame, "line").potential == near(1000 * std::sin(w * time), 1e-9));
    check_balances(frame);
  }
}

// After a jump of the source at t0 from -A to A, the potential is A + (V(t0) - A) exp(-(t - t0)/RC).
TEST_CASE("circuit: square V(t) behind a resistor follows each half period") {
  const double rc = 0.1;
  const Scene scene = circuit_scene(1, {.name = "line", .resistance = rc / one_ball, .potential = square(1000, 2)});
  Simulation simulation = simulation_of(scene);
  double potential = 0;
  for (int half = 0; half < 4; ++half) {
    const double source = half % 2 == 0 ? 1000 : -1000;
    simulation.advance_to(0.25 * half + 0.1);  // Frames need not be at corners.
    CHECK(std::abs(reading(simulation.now(), "line").surface_potential -
                   (source + (potential - source) * std::exp(-0.1 / rc))) < 1000 * allowed);
    CHECK(reading(simulation.now(), "line").potential == source);
    simulation.advance_to(0.25 * (half + 1));
    potential = source + (potential - source) * std::exp(-0.25 / rc);
    CHECK(std::abs(reading(simulation.now(), "line").surface_potential - potential) < 1000 * allowed);
    CHECK(reading(simulation.now(), "line").potential == -source);  // after the jump
    check_balances(simulation.now());
  }
}

// At a jump of a direct source the charge jumps by C (V+ - V-) at the mean potential, which supplies the change of
// C V^2 / 2.
TEST_CASE("electrode at V(t): charge follows without delay; table corners are hit") {
  Scene scene = conductor_scene({{0.02, 0.05}});
  scene.conductors[0].fixed = true;
  scene.domain.sides[2].electrode = true;
  scene.electrodes = {ball("driven", {0.06, 0.05}, 0)};
  scene.electrodes[0].potential = ramp({{0, 0}, {0.13, 1000}, {0.13, -500}, {0.37, 700}});
  scene.mechanics.largest_step = 10;
  for (const Integrator integrator : {Integrator::cvode, Integrator::euler}) {
    scene.mechanics.integrator = integrator;
    scene.mechanics.euler_step = scene.mechanics.euler_field_step = 0.05;
    Simulation simulation = simulation_of(scene);
    for (const auto& [time, potential] : {Vec2{0.065, 500}, {0.13, -500}, {0.25, 100}, {0.5, 700}}) {
      simulation.advance_to(time);
      const ConductorFrame frame = simulation.now();
      CHECK(reading(frame, "driven").surface_potential == near(potential, 1e-6));
      CHECK(reading(frame, "driven").delivered == near(one_ball * potential, 1e-6));
      CHECK(frame.energy_balance->flows.by_supplies == near(0.5 * one_ball * potential * potential, 1e-6));
      check_balances(frame);
    }
    if (integrator == Integrator::cvode) CHECK(simulation.counters().steps < 12);  // each corner and frame ends one
  }
}

TEST_CASE("current source: the charge is the integral of I(t), exactly") {
  const Signal current = ramp({{0, 0}, {0.2, 1e-9}, {0.2, -2e-9}, {0.7, 0}});
  for (const Integrator integrator : {Integrator::cvode, Integrator::euler}) {
    Scene scene = circuit_scene(1, {.name = "pump", .current = current});
    scene.mechanics.integrator = integrator;
    scene.mechanics.euler_step = scene.mechanics.euler_field_step = 0.03;
    Simulation simulation = simulation_of(scene);
    for (const auto& [time, charge] : {Vec2{0.1, 2.5e-11}, {0.2, 1e-10}, {0.45, 1e-10 - 3.75e-10}, {1, -4e-10}}) {
      simulation.advance_to(time);
      const ConductorFrame frame = simulation.now();
      CHECK(frame.charge_held == near(charge, 1e-12));
      CHECK(frame.charge_fed == near(charge, 1e-12));
      CHECK(reading(frame, "pump").delivered == near(charge, 1e-12));
      CHECK(reading(frame, "ball 0").surface_potential == near(charge / one_ball, 1e-6));
      check_balances(frame);
    }
  }
}

// In a steady state the current flows through the resistor: V = R I.
TEST_CASE("current source and resistor: the potential settles to R I") {
  const double ohm = 0.02 / one_ball;
  const Scene scene = circuit_scene(1, {.name = "pump", .resistance = ohm, .current = 1e-10});
  Simulation simulation = simulation_of(scene);
  simulation.advance_to(1);
  CHECK(reading(simulation.now(), "pump").surface_potential == near(1e-10 * ohm, 1e-4));
  check_balances(simulation.now());
}

TEST_CASE("floating electrode: keeps its given charge exactly") {
  Scene scene = random_spheres();
  scene.electrodes.push_back(ball("island", {0.062, 0.05}, 0));
  scene.electrodes.back().circuit = 0;
  scene.circuits = {{.name = "island", .charge = 3e-12}};
  Simulation simulation = simulation_of(scene);
  double charge = 3e-12;
  for (const Conductor& conductor : scene.conductors) charge += conductor.charge;
  simulation.advance_to(0.05);
  const ConductorFrame frame = simulation.now();
  CHECK(std::abs(frame.charge_held + frame.charge_drained - frame.charge_fed - charge) < 1e-14 * charge);
  CHECK(simulation.counters().contacts_made > 0);

  Scene alone = circuit_scene(1, {.name = "island", .charge = 5e-12});
  Simulation island = simulation_of(alone);
  island.advance_to(0.3);
  CHECK(island.now().charge_held == 5e-12);
  CHECK(island.now().energy == near(0.5 * 25e-24 / one_ball, 1e-6));
}

TEST_CASE("group in a circuit: shares the node with the circuit's electrode") {
  Scene scene = circuit_scene(1, {.name = "pair", .charge = 4e-12});
  scene.conductors[0].position = {0.06, 0.08};
  scene.conductors[0].group = 0;
  scene.conductors[0].fixed = true;
  scene.groups = {{.name = "wire", .circuit = 0}};
  Simulation simulation = simulation_of(scene);
  simulation.advance_to(0.1);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.potential[0] == near(4e-12 / two_balls, 1e-6));
  CHECK(frame.charge[0] == near(2e-12, 1e-6));
  CHECK(frame.charge_held == near(4e-12, 1e-14));
}

TEST_CASE("moving conductors between sources in time: the energy balance closes") {
  Scene scene = random_spheres();
  scene.electrodes[0].potential = sine(30, 20);
  scene.electrodes.push_back(ball("a", {0.062, 0.05}, 0));
  scene.electrodes.push_back(ball("b", {0.05, 0.062}, 0));
  scene.electrodes[1].circuit = scene.electrodes[2].circuit = 0;
  scene.circuits = {{.name = "pair", .resistance = 0.05 / two_balls, .potential = square(50, 7), .capacitance = 1e-13}};
  scene.mechanics.largest_step = 1.0 / 20 / 20;
  Simulation whole = simulation_of(scene), resumed = simulation_of(scene);
  double charge = 0;
  for (const Conductor& conductor : scene.conductors) charge += conductor.charge;
  const double at_start = analysis::energy_account(whole.now());
  whole.advance_to(0.1);
  resumed.restore(whole.checkpoint());
  for (const double time : {0.15, 1.0 / 7, 0.25, 0.4}) {
    whole.advance_to(time);
    resumed.advance_to(time);
    CHECK(resumed.checkpoint().reals == whole.checkpoint().reals);
  }
  const ConductorFrame frame = whole.now();
  const EnergyFlows& flows = frame.energy_balance->flows;
  const double imbalance = std::abs(analysis::energy_account(frame) - at_start);
  CHECK(imbalance < analysis::allowed_energy_imbalance(scene) *
                        (std::abs(flows.by_supplies) + std::abs(flows.by_source) + flows.dissipated()));
  CHECK(whole.counters().contacts_made > 0);
  const double balance = frame.charge_held + frame.charge_drained - frame.charge_fed - charge;
  CHECK(std::abs(balance) < 1e-12 * (frame.charge_fed + charge));
}

// A plate condenser: a side behind a resistor against a side at 0 V. Its capacitance is the charge of the side at 1 V.
TEST_CASE("side behind a resistor: charges as 1 - exp(-t/RC)") {
  for (const bool in_space : {false, true}) {
    const auto scene_of_side = [&](const std::string& left) {
      return parse_scene(
          fmt::format("domain = {{ size = [0.02, 0.02{}], left = {}, right = {{ potential = 0 }} }}\n"
                      "medium = {{ relative_permittivity = 2{} }}\nfield = {{ {} tolerance = 1e-8, moving_tolerance = "
                      "1e-8 }}\n[effects.floating_conductors]\n[[conductor]]\nposition = [0.012, 0.01{}]\nradius = "
                      "2e-3\nfixed = true\n[output]\nevery = 0.1\n",
                      in_space ? ", 0.02" : "", left, in_space ? "" : ", depth = 0.02", in_space ? "" : "cells = 64,",
                      in_space ? ", 0.01" : ""),
          "plates.toml");
    };
    Simulation charged(scene_of_side("{ potential = 1000 }"));
    const double farad = charged.now().terminals.front().delivered == 0
                             ? 2 * charged.now().energy / 1e6  // W = C V^2 / 2
                             : charged.now().terminals.front().delivered / 1000;
    const double plates = 2 * 8.8541878128e-12 * 0.02;
    CHECK(farad > plates);        // The conductor adds to the plates' capacitance:
    CHECK(farad < 1.1 * plates);  // by 2 pi R^2 over the area in the plane, 6 %, and less in space.
    Simulation simulation(scene_of_side(fmt::format("{{ potential = 1000, series_resistance = {} }}", 0.2 / farad)));
    for (const double time : {0.1, 0.3, 1.0}) {
      simulation.advance_to(time);
      const ConductorFrame frame = simulation.now();
      const double exact = -1000 * std::expm1(-time / 0.2);
      CHECK(std::abs(frame.terminals.front().surface_potential - exact) < 4.0);  // 4 tolerances of 1e-3
      CHECK(frame.energy == near(0.5 * farad * exact * exact, 1e-2));
      CHECK(std::abs(analysis::energy_account(frame)) < 1e-6 * frame.energy_balance->flows.supplied());
    }
  }
}

}  // namespace mechanics_sources_test
