// Tests of gases without sides: grains that leave the initial domain.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>

#include "src/analysis/gas_cells.hpp"
#include "src/analysis/gas_structure.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/uniform_field.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/homogeneous_gas.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

namespace granular_open_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using doctest::Approx;

namespace {

/// Viscoelastic grains in free space, which start in a cube.
Scene cloud(Integrator integrator) {
  Scene scene = viscoelastic(10, integrator);
  for (DomainSide& side : scene.domain.sides) side.periodic = false;
  scene.domain.open = true;
  return scene;
}

}  // namespace

// A grain leaves the cube of edge 10 at x = 10, and flies on along a straight line.
TEST_CASE("open cloud: free grains leave the domain at constant velocity") {
  for (const Integrator integrator : all_integrators) {
    CAPTURE(integrator->name);
    Scene scene = cloud(integrator);
    add(scene, {8, 5, 5}, {3, 1, -2});
    add(scene, {2, 5, 5}, {-3, 0, 0});
    Run run(scene);
    run.to(20);
    const Bodies& b = run.gas.bodies();
    CHECK(b.position[0] == Approx(68).epsilon(1e-12));
    CHECK(b.position[2] == Approx(-35).epsilon(1e-12));
    CHECK(b.position[3] == Approx(-58).epsilon(1e-12));
    CHECK(run.gas.energy().kinetic == Approx(0.5 * (14 + 9)).epsilon(1e-12));
  }
}

// Two pairs of grains: one meets inside of the cube, the same pair shifted by 40 edges meets outside. Contacts depend
// on relative positions, which the shift rounds by 2e-14.
TEST_CASE("open cloud: a collision outside of the domain is that inside") {
  for (const Integrator integrator : all_integrators) {
    CAPTURE(integrator->name);
    Scene scene = cloud(integrator);
    add(scene, {4, 5, 5}, {1, 0, 0});
    add(scene, {6, 5.3, 5}, {-1, 0, 0});
    Run inside(scene);
    for (Conductor& grain : scene.conductors) grain.position += Vec3{-400, 400, 0};
    Run outside(scene);
    for (Run* run : {&inside, &outside}) run->to(3);
    REQUIRE(inside.gas.collisions == 1);
    CHECK(outside.gas.collisions == 1);
    for (int k = 0; k < 6; ++k)
      CHECK(outside.gas.bodies().momentum[k] == Approx(inside.gas.bodies().momentum[k]).epsilon(1e-8));
  }
}

TEST_CASE("open cloud: a resumed run has identical bits") {
  Scene scene = cloud(Integrator::multirate);
  for (int i = 0; i < 60; ++i)
    add(scene, {0.8 + 2.2 * (i % 4), 0.8 + 2.2 * (i / 4 % 4), 0.8 + 2.2 * (i / 16)},
        {std::sin(3.0 * i), std::cos(5.0 * i), std::sin(7.0 * i)});
  Run whole(scene);
  whole.to(3);
  Checkpoint checkpoint = whole.gas.save();
  whole.integrator->save(checkpoint);
  whole.to(10);
  Run resumed(scene);
  resumed.restore(checkpoint);
  resumed.to(10);
  CHECK(whole.gas.collisions > 0);
  CHECK(whole.gas.bodies().position == resumed.gas.bodies().position);
  CHECK(whole.gas.bodies().momentum == resumed.gas.bodies().momentum);
}

TEST_CASE("open cloud: cells contain all grains, and have no periodic images") {
  Bodies bodies{.dimension = 2, .box = {.lengths = {10, 10, 0}}};
  bodies.position = {-15, 2, 24, 9};
  bodies.radius = {0.5, 0.5};
  const analysis::Cells cells = analysis::cells_of(bodies, 5);
  CHECK(cells.count[0] == 8);  // 39 / 5 rounded
  CHECK(cells.count[1] == 2);
  CHECK(cells.index(std::span(bodies.position).first(2)) == 0);
  CHECK(cells.index(std::span(bodies.position).last(2)) == 15);
  CHECK(cells.next(7, 0) == -1);
  CHECK(cells.next(6, 0) == 7);
  CHECK(std::isnan(analysis::structure_factors(bodies, 2).density[0]));
}

TEST_CASE("open cloud: scenes in plane and space run, without homogeneous gas") {
  for (const char* size : {"[20, 20]", "[20, 20, 20]"}) {
    const std::string text = fmt::format(
        "[units]\n[domain]\nsize = {}\nunbounded = true\n[[population]]\ncount = 120\ntemperature = 1\n"
        "[effects.viscoelastic_contact]\n[stop]\ntime = 3\n",
        size);
    GranularMotion motion(parse_scene(text, "cloud.toml"));
    const auto column = [&](const Frame& frame, const std::string& name) { return frame.reals(name); };
    while (!motion.finished()) motion.advance_to(motion.next_frame(), {});
    const std::vector<double> position = column(motion.frame(), "position");
    CHECK(std::ranges::any_of(position, [](double x) { return x < 0 || x > 20; }));
    const granular::Gas gas(parse_scene(text, "cloud.toml"));
    CHECK_FALSE(granular::HomogeneousGas::of(gas).has_value());
  }
}

// Two equal charges at rest at distance r move apart: their kinetic energy is q^2 (1/r_0 - 1/r).
TEST_CASE("open cloud: two charges move apart by Coulomb's law, in plane and space") {
  for (const int dimension : {2, 3}) {
    CAPTURE(dimension);
    Scene scene = cloud(Integrator::multirate);
    if (dimension == 2) scene.domain.size.z = 0;
    scene.effects.add(effects::CoulombOptions{});
    add(scene, {4, 5, 0}, {}, 2);
    add(scene, {6, 5, 0}, {}, 2);
    scene.mechanics.step = 0.002;
    Run run(scene);
    run.to(10);
    const Bodies& b = run.gas.bodies();
    const double distance = b.position[dimension] - b.position[0];
    CHECK(distance > 20);
    CHECK(run.gas.kinetic_energy() == Approx(4 * (0.5 - 1 / distance)).epsilon(1e-5));
    CHECK(run.gas.energy().potential == Approx(4 / distance).epsilon(1e-12));
  }
}

// The cloud grows to many times its size, so that its mesh changes several times.
TEST_CASE("open cloud: an exploding cloud conserves energy, resumes bit by bit") {
  Scene scene = cloud(Integrator::multirate);
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-4});
  add_gas(scene, 60, 9, 0.1);
  for (Conductor& grain : scene.conductors) grain.charge = 0.3;
  scene.mechanics.step = 0.02;
  Run whole(scene);
  const double before = whole.gas.energy().total();
  whole.to(6);
  Checkpoint checkpoint = whole.gas.save();
  whole.integrator->save(checkpoint);
  whole.to(12);
  const granular::GasEnergy after = whole.gas.energy();
  CHECK(after.potential < 0.5 * before);
  CHECK(after.total() == Approx(before).epsilon(2e-4));
  Run resumed(scene);
  resumed.restore(checkpoint);
  resumed.to(12);
  CHECK(whole.gas.bodies().position == resumed.gas.bodies().position);
  CHECK(whole.gas.bodies().momentum == resumed.gas.bodies().momentum);
}

// A layer of thickness 0: a square lattice of alternating charges at distance 1 has Madelung's constant 1.6155426.
TEST_CASE("open sides: a plane of alternating charges has the energy of its lattice") {
  Scene scene = cube(16);
  scene.domain.size = {16, 16, 0};
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-5});
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y) grains::add(scene, {x + 0.5, y + 0.5, 0}, {}, (x + y) % 2 == 0 ? 1 : -1);
  Bodies bodies = make_bodies(scene);
  bodies.charge = initial_charges(scene);
  const effects::Coulomb coulomb(scene);
  CHECK(coulomb.stored_energy({.bodies = bodies, .neighbours = {}}) == Approx(-0.5 * 256 * 1.6155426267).epsilon(1e-5));
}

// The image of a charge q at height z attracts it with q^2 / (4 z^2) and has half of the pair's energy -q^2 / (2 z). At
// a distance L the periodic images are dipoles 2 q z: they change the force by about 9 (2 z / L)^3 = 3e-4.
TEST_CASE("grounded side: a grain is attracted by its image, in plane and space") {
  for (const int dimension : {2, 3}) {
    CAPTURE(dimension);
    Scene scene = cube(60);
    if (dimension == 2) scene.domain.size.z = 0;
    const int upper = 2 * dimension - 1, axis = dimension - 1;
    scene.domain.sides[upper] = {.electrode = true}, scene.domain.sides[upper - 1] = {};
    scene.effects.add(effects::CoulombOptions{.strength = 3, .accuracy = 1e-5});
    Vec3 position{30, 30, 0};
    position[axis] = 59;
    add(scene, position, {}, 2);
    Bodies bodies = make_bodies(scene);
    bodies.charge = initial_charges(scene);
    const effects::Coulomb coulomb(scene);
    std::vector<double> force(dimension);
    coulomb.add_forces({.bodies = bodies, .neighbours = {}}, force);
    CHECK(force[axis] == Approx(3).epsilon(1e-3));
    CHECK(std::abs(force[0]) < 1e-5);
    CHECK(coulomb.stored_energy({.bodies = bodies, .neighbours = {}}) == Approx(-3).epsilon(1e-3));
  }
}

// x = q E t^2 / 2 with m = 1; the field's energy -q E x balances the kinetic energy, also across a periodic side.
TEST_CASE("uniform field: a charge accelerates by q E, and the energy is conserved") {
  for (const bool open : {false, true}) {
    CAPTURE(open);
    Scene scene = open ? cloud(Integrator::multirate) : viscoelastic(10);
    scene.effects.add(effects::UniformFieldOptions{.field = {{0.5, -1, 0}, 3}});
    add(scene, {5, 5, 5}, {}, 2);
    add(scene, {5, 5, 8}, {}, 0);
    Run run(scene);
    const double before = run.gas.energy().total();
    run.to(8);
    const Bodies& b = run.gas.bodies();
    CHECK(b.position[0] + b.image[0] * 10 == Approx(5 + 0.5 * 1 * 64).epsilon(1e-12));
    CHECK(b.position[1] + b.image[1] * 10 == Approx(5 - 0.5 * 2 * 64).epsilon(1e-12));
    CHECK(b.position[5] == 8);
    CHECK(run.gas.energy().potential - before == Approx(-(32 + 2 * 64)).epsilon(1e-12));
    CHECK(run.gas.energy().total() == Approx(before).epsilon(1e-12));
  }
}

TEST_CASE("open and grounded sides: scenes that are not possible are refused") {
  const std::string text =
      "[units]\n[domain]\nsize = [20, 20, 20]\nunbounded = true\n[[population]]\ncount = 4\n"
      "[effects.viscoelastic_contact]\n";
  const auto refused = [&](const std::string& more, const std::string& sentence) {
    CAPTURE(more);
    const std::string message = message_of([&] { parse_scene(text + more, "cloud.toml"); });
    CHECK_MESSAGE(message.find(sentence) != std::string::npos, message);
  };
  refused("[effects.coulomb]\nsum = \"ewald\"\n",
          "sum = \"ewald\" is not allowed in a domain that is not periodic along all axes: \"mesh\" is");
  refused("[effects.coulomb]\n[effects.induced_dipoles]\nsum = \"minimum-image\"\n",
          "effects.induced_dipoles.sum = \"minimum-image\" is not allowed in a domain that is not periodic");
  refused("[effects.uniform_field]\nfield = [1, 0]\n", "field has 2 numbers, but the domain has 3");
  refused("[effects.coulomb]\n[effects.induced_dipoles]\n[effects.uniform_field]\nfield = [1, 0, 0]\n",
          "effects.uniform_field is not allowed with effects.induced_dipoles");
}

TEST_CASE("open and grounded sides: a scene with walls reads them") {
  const std::string text =
      "[units]\n[domain]\nsize = [20, 20, 20]\nleft = \"periodic\"\nright = \"periodic\"\nfront = { potential = 0 }\n"
      "[[population]]\ncount = 40\n[effects.viscoelastic_contact]\n[effects.coulomb]\n";
  const std::string message = message_of([&] { parse_scene(text, "walls.toml"); });
  CHECK_MESSAGE(message.find("is not allowed without the table [effects.flat_walls]") != std::string::npos, message);
  const std::string walls = "[effects.flat_walls]\n";
  const Scene scene = parse_scene(text + walls, "walls.toml");
  const std::vector<ExplanationLine> lines = effects::CoulombOptions::kind().explain(scene);
  CHECK(lines.back().text == "image charges beyond front; empty space beyond bottom, top, back");
  const std::string outside = "[[conductor]]\nposition = [3, 3, 0.4]\nradius = 0.5\n";
  CHECK(message_of([&] {
          parse_scene(text + outside + walls, "walls.toml");
        }).find("this conductor reaches out of the domain by 0.1 d0") != std::string::npos);
}

}  // namespace granular_open_test
