// Tests of gases without sides: grains that leave the initial domain.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>

#include "src/analysis/gas_cells.hpp"
#include "src/analysis/gas_structure.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/homogeneous_gas.hpp"
#include "tests/grains.hpp"

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

}  // namespace granular_open_test
