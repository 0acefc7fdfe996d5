// Tests of conductors in three dimensions: scene keys and the motion of spheres in their field.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "src/effects/contact_discharge.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/surface.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"
#include "tests/near.hpp"
#include "tests/restored.hpp"
#include "tests/scene_texts.hpp"
#include "tests/spheres.hpp"

namespace conductors_in_space_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;
using steel_spheres::cube_of;
using steel_spheres::drag;
using steel_spheres::mass;
using steel_spheres::radius;

namespace {

/// Scene of seven charged spheres around a grounded ball.
Scene random_spheres_in_space() {
  Scene scene = cube_of({}, 1e-3);
  for (const Vec3 at : {Vec3{3.3, 0, 0}, Vec3{-3.6, 0.4, 0}, Vec3{0, 3.4, 0.3}, Vec3{0.2, -3.9, 0}, Vec3{0, 0.5, 4.1},
                        Vec3{0.3, 0, -3.5}, Vec3{6.6, 0.7, 0.4}})
    scene.conductors.push_back({.position = Vec3{0.03, 0.03, 0.03} + radius * at, .radius = radius, .charge = 2e-11});
  scene.electrodes = {{.name = "ground", .shape = Disk{{0.03, 0.03}, radius}, .height = 0.03}};
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.05});
  scene.effects.add(effects::CurrentInjectionOptions{.current = 2e-9});
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add<effects::WallContactOptions>();
  return scene;
}

/// Attraction (N) of two spheres of radius R and charges +-q whose centres are at distance d, by Maxwell's image
/// charges. A charge q at x from a centre has the image q R / (d - x) at R^2 / (d - x) in the other sphere.
double attraction(double q, double d, double permittivity) {
  std::vector<double> charge = {1}, image_position = {0};
  while (charge.back() > 1e-16) {
    const double away = d - image_position.back();
    charge.push_back(charge.back() * radius / away);
    image_position.push_back(radius * radius / away);
  }
  double total = 0, force = 0;
  for (std::size_t i = 0; i < charge.size(); ++i) {
    total += charge[i];
    for (std::size_t j = 0; j < charge.size(); ++j)
      force += charge[i] * charge[j] / std::pow(d - image_position[i] - image_position[j], 2);
  }
  return force * q * q / (total * total * 4 * std::numbers::pi * permittivity);
}

const std::string dish = "domain = { size = [0.02, 0.02, 0.005] }\nmedium = { relative_permittivity = 4.7 }\n";
const std::string floating = "[effects.floating_conductors]\n";

std::string sphere(const std::string& position, const std::string& more = "charge = 0.0\n") {
  return "[[conductor]]\nposition = " + position + "\nradius = 1e-3\n" + more;
}
std::string ball(const std::string& position, const std::string& shape = "shape = \"sphere\"\nradius = 1e-3\n") {
  return "[[electrode]]\nname = \"ball\"\npotential = 5.0\n" + shape + "position = " + position + "\n";
}

}  // namespace

TEST_CASE("domain.uniform_field: a charge moves at charge times field over drag") {
  Scene scene = cube_of({{0.03, 0.03, 0.03}}, 1e-4);
  scene.domain.open = true;
  scene.domain.uniform_field = {3e4, 0, -4e4};
  scene.conductors[0].charge = 2e-11;
  Simulation simulation(scene);
  simulation.advance_to(30 * mass / drag);
  const ConductorFrame frame = simulation.now();
  // Relative errors: 1e-6 of the integrator, 1e-4 of the field.
  CHECK(frame.velocity[0].x == near(2e-11 * 3e4 / drag, 1e-4));
  CHECK(frame.velocity[0].z == near(-2e-11 * 4e4 / drag, 1e-4));
}

TEST_CASE("domain.uniform_field: refused in a box, and with two numbers") {
  const auto text = [](const std::string& keys) {
    return "domain = { size = [0.02, 0.02, 0.02], " + keys + " }\nmedium = { relative_permittivity = 4.7 }\n" +
           sphere("[0.01, 0.01, 0.002]") + floating;
  };
  const Scene scene = parse(text("unbounded = true, uniform_field = [1e5, 0.0, -2e5]"));
  CHECK(scene.domain.uniform_field == Vec3{1e5, 0, -2e5});
  check_refused(text("uniform_field = [1e5, 0.0, 0.0]"), {"domain.uniform_field needs domain.unbounded = true"});
  check_refused(text("unbounded = true, uniform_field = [1e5, 0.0]"),
                {"domain.uniform_field has 2 numbers, but the domain has 3"});
}

TEST_CASE("scene in space: the field method is spheres with default tolerances") {
  const Scene scene = parse(dish + sphere("[0.01, 0.01, 0.002]") + ball("[0.004, 0.01, 0.002]") + floating);
  CHECK(scene.field().method == &spheres_method());
  CHECK(scene.field().moving_tolerance == 1e-3);
  CHECK(scene.electrodes.at(0).centre() == Vec3{0.004, 0.01, 0.002});
  const Scene exact = parse(dish + "field = { accuracy = 1e-5 }\n" + sphere("[0.01, 0.01, 0.002]") + floating);
  CHECK(exact.field().tolerance == 1e-5);
  CHECK(exact.field().moving_tolerance == 1e-5);
}

TEST_CASE("scene in space: keys for the plane and bad positions are refused") {
  const std::string one = sphere("[0.01, 0.01, 0.002]");
  check_refused(dish + one +
                    "[[electrode]]\nshape = \"disk\"\ncentre = [0.004, 0.01]\nradius = 1e-3\npotential = 0.0\n" +
                    floating,
                {"electrode.shape = \"disk\"", "three dimensions", "\"sphere\" and \"torus\" are"});
  check_refused(dish + one + ball("[0.0005, 0.01, 0.002]") + floating, {"on or through a side"});
  check_refused(dish + one + ball("[0.004, 0.01]") + floating, {"electrode.position has 2 numbers"});
  check_refused(dish + one + ball("[0.0085, 0.01, 0.002]") + floating, {"overlaps the electrode \"ball\""});
  check_refused(dish + sphere("[0.01, 0.01, 0.0045]") + floating, {"reaches out of the domain", "whole sphere"});
  check_refused(dish + "[[population]]\ncount = 2\nradius = 3e-3\n" + floating, {"no space for even one"});
  check_refused(dish + "field = { method = \"cut-cell\" }\n" + one + floating,
                {"field.method = \"cut-cell\"", "three dimensions", "\"spheres\""});
  check_refused(dish + "field = { cells = 64 }\n" + one + floating, {"field.cells", "three dimensions"});
  check_refused(
      "domain = { size = [0.02, 0.02] }\nmedium = { relative_permittivity = 4.7 }\nfield = { method = "
      "\"spheres\" }\n" +
          sphere("[0.01, 0.01]") + floating,
      {"field.method = \"spheres\"", "two dimensions"});
  check_refused(dish + one + sphere("[0.012, 0.01, 0.002]") + floating, {"touches the one at [0.012, 0.01, 0.002]"});
  CHECK_THROWS_AS(effects::make_sphere_solver({.method = &spheres_method(), .device = FieldDevice::cuda}, 1),
                  InputError);
}

TEST_CASE("conductors without discharge: contact across a periodic side is refused") {
  const auto scene = [](const std::string& sides, const std::string& one, const std::string& other) {
    return "domain = { size = [0.02, 0.02, 0.005], " + sides + " }\nmedium = { relative_permittivity = 4.7 }\n" +
           sphere("[0.01, 0.005, 0.0025]") + sphere(one) + sphere(other) + floating;
  };
  const std::string along_x = "left = \"periodic\", right = \"periodic\"",
                    along_y = "bottom = \"periodic\", top = \"periodic\"";
  check_refused(scene(along_x, "[0.0007, 0.01, 0.002]", "[0.0187, 0.01, 0.002]"),
                {"touches the one at [0.0007, 0.01, 0.002]"});
  check_refused(scene(along_y, "[0.01, 0.0187, 0.002]", "[0.01, 0.0007, 0.002]"),
                {"touches the one at [0.01, 0.0007, 0.002]"});
  CHECK(parse(scene(along_x, "[0.0007, 0.01, 0.002]", "[0.0186, 0.01, 0.002]")).conductors.size() == 3);
}

TEST_CASE("spherical electrode: its surface is found across a periodic side") {
  const std::string open_dish =
      "domain = { size = [0.02, 0.02, 0.005], left = \"periodic\", right = \"periodic\" }\n"
      "medium = { relative_permittivity = 4.7 }\n";
  const std::string across = ball("[0.0005, 0.01, 0.002]");
  const Scene scene = parse(open_dish + sphere("[0.0175, 0.01, 0.002]") + across + floating);
  const effects::Surface surface = effects::surface_of(scene.electrodes[0], scene.domain);
  const effects::View seen = effects::view(surface, scene.conductors[0].position);
  CHECK(seen.distance == near(0.002, 1e-9));
  CHECK(seen.normal.x == near(-1, 1e-9));
  check_refused(open_dish + sphere("[0.0192, 0.01, 0.002]") + across + floating, {"overlaps the electrode \"ball\""});
  check_refused(open_dish + sphere("[0.01, 0.01, 0.002]") + ball("[-0.001, 0.01, 0.002]") + floating,
                {"on or through a side"});
}

TEST_CASE("make_sphere_problem: a sphere in contact with a side gets a small gap") {
  Scene scene = cube_of({{0.03, 0.03, 1.0005 * radius}}, 1e-3);
  scene.domain.sides[4].electrode = true;
  const Bodies bodies = make_bodies(scene);
  const auto height = [&](std::vector<effects::Contact> contacts) {
    const auto groups = effects::electrical_groups(scene, contacts);
    return effects::make_sphere_problem(scene, bodies, groups, {.charge = {0}}).spheres[0].centre.z;
  };
  CHECK(height({}) == 1.0005 * radius);
  CHECK(height({{.conductor = 0, .partner = 1}}) == near(1.001 * radius, 1e-12));
}

TEST_CASE("two oppositely charged spheres: approach as Maxwell's images predict") {
  const double charge = 4e-10, start = 6 * radius, until = 0.3;
  Scene scene = cube_of({{0.3 - 0.5 * start, 0.3, 0.3}, {0.3 + 0.5 * start, 0.3, 0.3}}, 1e-7);
  scene.domain.size = {0.6, 0.6, 0.6};
  scene.conductors[0].charge = charge;
  scene.conductors[1].charge = -charge;
  scene.mechanics.position_tolerance = 1e-6 * radius;
  Simulation simulation(scene);
  simulation.advance_to(until);

  // Classical Runge-Kutta for m x'' = F - drag v of one sphere: 1e5 steps of 3 us, 500 per relaxation time.
  double d = start, v = 0;  // d' = -2 v
  const int steps = 100000;
  const double h = until / steps;
  const auto acceleration = [&](double distance, double speed) {
    return (attraction(charge, distance, scene.medium.permittivity) - drag * speed) / mass;
  };
  for (int k = 0; k < steps; ++k) {
    const double a1 = acceleration(d, v), v2 = v + 0.5 * h * a1, a2 = acceleration(d - h * v, v2);
    const double v3 = v + 0.5 * h * a2, a3 = acceleration(d - h * v2, v3);
    const double v4 = v + h * a3, a4 = acceleration(d - 2 * h * v3, v4);
    d -= 2 * h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  const ConductorFrame frame = simulation.now();
  REQUIRE(start - d > radius);  // The spheres have approached each other.
  // Each step has an error of at most one tolerance for either sphere. The error grows with the inverse square of the
  // distance, by (6 / 4.6)^2. The images in the walls are 60 cm away and change the force by about 4 (6 R / 60 cm)^3 =
  // 2e-6.
  const double allowed = 4 * static_cast<double>(simulation.counters().steps) * scene.mechanics.position_tolerance;
  REQUIRE(allowed < 2e-3 * radius);
  CHECK(std::abs(norm(frame.position[1] - frame.position[0]) - d) < allowed);
  CHECK(frame.charge[0] == charge);
}

TEST_CASE("force on a sphere: negative energy derivative along each axis") {
  const std::vector<Vec3> positions = {{0.03, 0.03, 0.03}, {0.0321, 0.0305, 0.0299}, {0.0308, 0.0297, 0.0325}};
  const auto now_at = [&](std::vector<Vec3> at) {
    Scene scene = cube_of(at, 1e-9);
    for (int i = 0; i < 3; ++i) scene.conductors[i].charge = std::array{1e-10, -3e-10, 2e-10}[i];
    return Simulation(scene).now();
  };
  const ConductorFrame middle = now_at(positions);
  const double step = 1e-3 * radius;
  for (int k = 0; k < 3; ++k) {
    std::vector<Vec3> ahead = positions, behind = positions;
    ahead[1][k] += step;
    behind[1][k] -= step;
    const double slope = (now_at(ahead).energy - now_at(behind).energy) / (2 * step);
    // The truncation error is (step / gap)^2 of the force, with a smallest gap of 0.9 radii. The solver adds 1e-9 /
    // 1e-3.
    CHECK(std::abs(middle.force[1][k] + slope) < 1e-5 * norm(middle.force[1]));
  }
}

TEST_CASE("charge balance of spheres: exact over injection, contact, discharge") {
  Simulation simulation(random_spheres_in_space());
  const ConductorFrame start = simulation.now();
  simulation.advance_to(0.5);
  const ConductorFrame frame = simulation.now();
  CHECK(simulation.counters().contacts_made > 0);
  CHECK(frame.charge_drained > 0);
  CHECK(frame.charge_fed == near(7 * 2e-9 * 0.5, 1e-12));
  const double before = start.charge_held + start.charge_drained;
  CHECK(std::abs(frame.charge_held + frame.charge_drained - frame.charge_fed - before) < 1e-15 * frame.charge_fed);
  double most = 0;
  for (const Vec3 v : frame.velocity) most = std::max(most, std::abs(v.z));
  CHECK(most > 0);  // The force along z is not zero.
}

TEST_CASE("run of spheres in space: restored from a checkpoint with identical bits") {
  check_restored(random_spheres_in_space(), 0.1, 0.2);
}

TEST_CASE("periodic side: spheres attract across it, cross it and are wrapped") {
  Scene scene = cube_of({{0.0001, 0.03, 0.03}, {0.0562, 0.03, 0.03}}, 1e-3);
  scene.domain.sides[0].periodic = scene.domain.sides[1].periodic = true;
  scene.conductors[0].charge = 4e-10;
  scene.conductors[1].charge = -4e-10;
  Simulation simulation(scene);
  CHECK(simulation.now().force[0].x < 0);
  CHECK(simulation.now().force[1].x > 0);
  simulation.advance_to(0.1);
  CHECK(simulation.now().position[0].x > 0.05);
  CHECK(simulation.frame().integers("image") == std::vector<int>{-1, 0, 0, 0, 0, 0});
}

TEST_CASE("series resistor: a ball in space charges as 1 - exp(-t/RC)") {
  Scene scene = cube_of({{0.045, 0.03, 0.03}}, 1e-6);
  scene.domain.sides[4].electrode = true;
  scene.electrodes = {{.name = "supplied", .shape = Disk{{0.02, 0.03}, radius}, .potential = 1000, .height = 0.03}};
  scene.conductors[0].fixed = true;
  laplace::SphereProblem alone =
      effects::make_sphere_problem(scene, make_bodies(scene), effects::electrical_groups(scene, {}), {.charge = {0}});
  const double capacitance = laplace::SphereSolver({.accuracy = 1e-6}).solve(alone).sphere_charge[1] / 1000;
  scene.electrodes[0].series_resistance = 0.2 / capacitance;  // RC = 0.2 s
  scene.mechanics.position_tolerance = 1e-3 * radius;
  scene.mechanics.largest_step = 1;
  Simulation simulation(scene);
  double worst = 0;
  for (const double time : {0.1, 0.3, 1.0}) {
    simulation.advance_to(time);
    const ConductorFrame frame = simulation.now();
    worst = std::max(worst, std::abs(frame.terminals[0].surface_potential / 1000 + std::expm1(-time / 0.2)));
  }
  // The tolerances of 1e-3 per step decay with RC; circuit_test.cpp has the same test in the plane.
  CHECK(worst < 4e-3);
  const EnergyFlows flows = simulation.now().energy_balance->flows;
  // Half of the supplied energy Q V is in the field and half is heat, except for the exp(-5) not yet supplied.
  CHECK(flows.series_resistors == near(0.5 * flows.by_supplies, 2e-2));
}

namespace {

/// Scene of two balls behind resistors in an insulated cube and a chain of three spheres with contact resistances
/// between them.
Scene series_circuit() {
  Scene scene = cube_of({{0.028, 0.03, 0.03}, {0.03, 0.03, 0.03}, {0.032, 0.03, 0.03}}, 1e-7);
  const double ohm = 1e10;
  scene.electrodes = {{.name = "high",
                       .shape = Disk{{0.026, 0.03}, radius},
                       .potential = 400,
                       .series_resistance = ohm,
                       .height = 0.03},
                      {.name = "low",
                       .shape = Disk{{0.034, 0.03}, radius},
                       .potential = -200,
                       .series_resistance = 3 * ohm,
                       .height = 0.03}};
  for (Conductor& conductor : scene.conductors) conductor.fixed = true;
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.05});
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 0.5 * ohm});
  return scene;
}

}  // namespace

TEST_CASE("series circuit in an insulated cube: potentials obey Kirchhoff's laws") {
  const Scene scene = series_circuit();
  Simulation simulation(scene);
  const double current = 600 / (4e10 + 4 * 0.5e10);
  // Initially the capacitances are uncharged, and the potential level gives both resistors the same current.
  const ConductorFrame first = simulation.now();
  CHECK(first.terminals[0].surface_potential == near(250, 1e-6));
  CHECK(first.terminals[1].surface_potential == near(250, 1e-6));
  simulation.advance_to(0.4);  // The RC of a ball is 4e-3 s.
  const ConductorFrame before = simulation.now();
  simulation.advance_to(0.5);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.terminals[0].delivered - before.terminals[0].delivered == near(0.1 * current, 1e-4));
  CHECK(frame.terminals[1].delivered - before.terminals[1].delivered == near(-0.1 * current, 1e-4));
  CHECK(frame.terminals[0].surface_potential == near(400 - 1e10 * current, 1e-4));
  CHECK(frame.terminals[1].surface_potential == near(-200 + 3e10 * current, 1e-4));
  CHECK(frame.potential[1] == near(400 - 2e10 * current, 1e-4));
  const EnergyBalance &now = *frame.energy_balance, &start = *first.energy_balance;
  const double gained = frame.energy + now.kinetic - first.energy - start.kinetic;
  CHECK(std::abs(gained + now.flows.dissipated() - now.flows.supplied()) < 1e-4 * now.flows.supplied());
}

TEST_CASE("contact resistance of two spheres: its heat is the initial field energy") {
  Scene scene = cube_of({{0.028, 0.03, 0.03}, {0.03, 0.03, 0.03}}, 1e-6);
  scene.conductors[0].charge = 1e-11, scene.conductors[1].charge = -1e-11;
  for (Conductor& conductor : scene.conductors) conductor.fixed = true;
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.05});
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1e10});
  Simulation simulation(scene);
  const ConductorFrame first = simulation.now();
  CHECK(first.potential[0] == near(-first.potential[1], 1e-9));  // The mean potential is 0.
  CHECK(first.potential[0] > 0);
  simulation.advance_to(0.1);  // RC is about 2e-3 s.
  const ConductorFrame frame = simulation.now();
  CHECK(std::abs(frame.potential[0]) < 1e-6 * first.potential[0]);
  CHECK(frame.energy_balance->flows.contacts == near(first.energy, 1e-3));
}

TEST_CASE("contact resistance: compressed spheres get the charges of ideal contact") {
  Scene scene =
      cube_of({{0.028, 0.03, 0.03}, {0.028 + 2 * radius - 1e-8, 0.03, 0.03}, {radius - 1e-8, 0.03, 0.03}}, 1e-3);
  scene.domain.sides[0].electrode = true;
  scene.domain.sides[0].potential = 100;
  for (Conductor& conductor : scene.conductors) conductor.fixed = true;
  scene.conductors[0].charge = 2e-11;
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = 0.1 * radius, .hysteresis = 0.05});
  Scene merged = scene;
  scene.effects.add(effects::ContactResistanceOptions{.resistance = 1e3});
  Simulation resistive(scene), ideal(merged);
  resistive.advance_to(0.1), ideal.advance_to(0.1);
  const ConductorFrame got = resistive.now(), expected = ideal.now();
  for (int i = 0; i < 3; ++i) CHECK(got.potential[i] == near(expected.potential[i], 2e-3));  // Twice the accuracy.
  for (int i = 0; i < 2; ++i) CHECK(got.charge[i] == near(expected.charge[i], 2e-3));
}

TEST_CASE("circuit of spheres: restored from a checkpoint with identical bits") {
  check_restored(series_circuit(), 0.005, 0.01);
}

TEST_CASE("49 spheres with preconditioner: a restored run has identical bits") {
  Scene scene = cube_of({}, 1e-2);
  for (int i = 0; i < 49; ++i)  // More spheres than the direct pair sum takes.
    scene.conductors.push_back(
        {.position = Vec3{0.012, 0.012, 0.03} + radius * Vec3{3.4 * (i % 7), 3.4 * (i / 7), 0.1 * (i % 3)},
         .radius = radius,
         .charge = 1e-10});
  scene.domain.sides[4].electrode = true;
  check_restored(scene, 0.01, 0.02);
}

TEST_CASE("unbounded domain: potential of one sphere; wrong keys are refused") {
  const std::string open =
      "domain = { size = [0.02, 0.02, 0.005], open = true }\nmedium = { relative_permittivity = 4.7 }\n";
  const Scene scene = parse(open + sphere("[0.01, 0.01, 0.002]", "charge = 1e-10\n") + floating);
  CHECK(scene.domain.open);
  Simulation simulation(scene);
  const double expected = 1e-10 / (4 * std::numbers::pi * scene.medium.permittivity * 1e-3);
  CHECK(simulation.now().potential[0] == near(expected, 1e-9));
  CHECK(norm(simulation.now().force[0]) == 0);
  const std::string one = sphere("[0.01, 0.01, 0.002]");
  check_refused("domain = { size = [0.02, 0.02], open = true }\nmedium = { relative_permittivity = 4.7 }\n" +
                    sphere("[0.01, 0.01]") + floating,
                {"domain.unbounded = true", "two dimensions"});
  check_refused(
      "domain = { size = [0.02, 0.02, 0.005], open = true, left = { potential = 5.0 } }\n"
      "medium = { relative_permittivity = 4.7 }\n" +
          one + floating,
      {"domain.left is not allowed with domain.unbounded = true"});
  check_refused(
      "domain = { size = [0.02, 0.02, 0.005], open = true }\n[effects.hertz_contact]\n"
      "[[conductor]]\nposition = [0.01, 0.01, 0.002]\nradius = 1e-3\n",
      {"domain.unbounded = true needs the table [effects.floating_conductors]"});
}

TEST_CASE("unbounded domain: spheres leave the initial box without a wall force") {
  Scene scene = cube_of({{0.002, 0.03, 0.03}, {0.0075, 0.03, 0.03}}, 1e-3);
  scene.domain.open = true;
  scene.effects.add<effects::WallContactOptions>();
  for (Conductor& conductor : scene.conductors) conductor.velocity = {-0.3, 0, 0};
  scene.effects.remove<effects::StokesDragOptions>();
  Simulation simulation(scene);
  simulation.advance_to(0.01);
  CHECK(simulation.now().position[0].x == near(0.002 - 0.003, 1e-9));
}

TEST_CASE("collision without contact force: ends the run and names the remedy") {
  Scene scene = cube_of({{0.027, 0.03, 0.03}, {0.033, 0.03, 0.03}}, 1e-3);
  scene.conductors[0].velocity = {0.5, 0, 0};
  scene.effects.remove<effects::StokesDragOptions>();
  scene.mechanics.largest_step = 1e-4;
  scene.domain.sides[4].electrode = true;
  scene.groups = {{.name = "wired", .charge = 1e-14}};  // The force is negligible.
  for (Conductor& conductor : scene.conductors) conductor.group = 0;
  const auto end_of = [](const Scene& one) {
    Simulation simulation(one);
    return message_of([&] { simulation.advance_to(0.06); });
  };
  const std::string bare = end_of(scene);
  CHECK(contains(bare, "conductors 0 and 1 overlap by"));
  CHECK(contains(bare, "[effects.hertz_contact] in the scene would keep them apart"));
  scene.effects.add(effects::HertzContactOptions{.young = 1e3});
  CHECK(contains(end_of(scene), "a larger effects.hertz_contact.young"));
  scene.conductors[0].velocity = {-0.5, 0, 0};
  CHECK(contains(end_of(scene), "conductor 0 is pressed into the left side of the domain by"));
  scene.effects.add(effects::WallContactOptions{.young = 1e3});
  CHECK(contains(end_of(scene), "a larger effects.wall_contact.young"));
}

TEST_CASE("sphere gap too small for the accuracy: the message names a possible one") {
  // Two small spheres whose images in a large one interact.
  Scene scene =
      cube_of({{0.03, 0.03, 0.03}, {0.03 + 8.081 * radius, 0.03, 0.03}, {0.03, 0.03 + 8.081 * radius, 0.03}}, 1e-12);
  scene.conductors[0].radius = 8 * radius;
  scene.conductors[1].radius = scene.conductors[2].radius = 0.08 * radius;
  scene.domain.sides[4].electrode = true;
  scene.groups = {{.name = "wired", .charge = 1e-12}};
  for (Conductor& conductor : scene.conductors) conductor.group = 0;
  const std::string sentence = message_of([&] { Simulation(scene).now(); });
  CHECK(contains(sentence, "the gap at sphere 0 would need harmonics of degree"));
  CHECK(contains(sentence, "for an accuracy of 1e-12: 200 is the largest, which suffices for"));
}

}  // namespace conductors_in_space_test
