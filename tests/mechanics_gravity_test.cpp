// Tests of gravity on conductors in space: weight, buoyancy, stored energy, and rest on the bottom.
#include "src/effects/gravity.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "src/effects/effects.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace mechanics_gravity_test {

using namespace lichtenberg;
using steel_spheres::cube_of;
using steel_spheres::mass;
using steel_spheres::radius;

TEST_CASE("fix_z: the field moves bodies only in x and y; vertical force is zero") {
  Scene scene = cube_of({{0.028, 0.03, 0.02}, {0.032, 0.03, 0.021}}, 1e-3);
  scene.conductors[0].charge = 4e-10;
  scene.conductors[1].charge = -4e-10;
  scene.effects.add<effects::GravityOptions>();
  scene.mechanics.fix_z = true;
  Simulation simulation(scene);
  simulation.advance_to(0.1);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.position[0].z == 0.02);
  CHECK(frame.position[1].z == 0.021);
  CHECK(frame.position[0].x > 0.028 + 1e-5);
  CHECK(frame.force[0].z == 0);  // The vertical force includes that of the support.
  CHECK(frame.force[0].x > 0);
}

TEST_CASE("gravity: a heavy sphere sinks with Stokes' terminal velocity") {
  Scene scene = cube_of({{0.03, 0.03, 0.03}}, 1e-3);
  scene.effects.add(effects::GravityOptions{.acceleration = 9.81, .fluid_density = 960});
  Simulation simulation(scene);
  simulation.advance_to(0.1);
  // v = 2/9 (density - 960) g R^2 / viscosity after 65 relaxation times.
  const double speed = 2.0 / 9 * (8050 - 960) * 9.81 * radius * radius / 0.7;
  CHECK(simulation.now().velocity[0].z == near(-speed, 1e-6));
}

TEST_CASE("gravity: stored energy is height times (weight minus buoyancy)") {
  Scene low = cube_of({{0.03, 0.03, 0.02}, {0.04, 0.03, 0.02}}, 1e-3);
  low.effects.add(effects::GravityOptions{.acceleration = 9.81, .fluid_density = 960});
  Scene high = low;
  high.conductors[1].position.z = 0.035;
  const auto stored = [](const Scene& scene) { return effects::make_model_without_field(scene).stored_energy(0); };
  const double weight = (8050 - 960) * 9.81 * 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
  CHECK(stored(high) - stored(low) == near(weight * 0.015, 1e-12));
}

TEST_CASE("gravity: weight acts along the given direction, a vector of any length") {
  Scene scene = cube_of({{0.03, 0.03, 0.03}}, 1e-3);
  const double weight = 8050 * 9.81 * 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
  const auto check = [&](effects::GravityOptions options, Vec3 down) {
    scene.effects.add(options);
    const effects::Gravity gravity(scene);
    Bodies bodies = make_bodies(scene);
    std::vector<double> force(3);
    gravity.add_forces({0, bodies, {}}, force);
    for (int k = 0; k < 3; ++k) CHECK(std::abs(force[k] - weight * down[k]) < 1e-12 * weight);
    const double before = gravity.stored_energy({0, bodies, {}});
    for (int k = 0; k < 3; ++k) bodies.position[k] += 0.01 * (k + 1);
    const double work = 0.01 * (force[0] + 2 * force[1] + 3 * force[2]);
    CHECK(gravity.stored_energy({0, bodies, {}}) - before == near(-work, 1e-9));
  };
  check({.acceleration = 9.81}, {0, 0, -1});
  check({.acceleration = 9.81, .direction = Coordinates{{0, -3, 0}, 3}}, {0, -1, 0});
  check({.acceleration = 9.81, .direction = Coordinates{{2, 0, -1.5}, 3}}, {0.8, 0, -0.6});
}

TEST_CASE("gravity: stored energy is continuous across a periodic side") {
  Scene scene = cube_of({{0.03, 0.03, 0.002}}, 1e-3);
  scene.domain.sides[4].periodic = scene.domain.sides[5].periodic = true;
  scene.effects.add<effects::GravityOptions>();
  Model model = effects::make_model_without_field(scene);
  const double before = model.stored_energy(0);
  model.bodies.position[2] -= 0.005;  // Below the front.
  const double weight = 8050 * 9.80665 * 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
  CHECK(model.stored_energy(0) - before == near(-0.005 * weight, 1e-9));
  wrap(model.bodies);
  CHECK(model.bodies.position[2] > 0);
  CHECK(model.stored_energy(0) - before == near(-0.005 * weight, 1e-9));
}

TEST_CASE("sphere at rest on the bottom: Hertz force of its overlap is its weight") {
  Scene scene = cube_of({{0.03, 0.03, radius}}, 1e-3);
  scene.conductors[0].charge = 0;
  scene.effects.add<effects::GravityOptions>();
  scene.effects.add<effects::WallContactOptions>();
  Simulation simulation(scene);
  simulation.advance_to(0.05);
  const ConductorFrame frame = simulation.now();
  // Hertz: weight 1.54e-4 N = 4/3 E* sqrt(R) overlap^1.5, E* = 200e9 / 1.82.
  const double overlap = std::pow(0.75 * mass * 9.80665 / (200e9 / 1.82 * std::sqrt(radius)), 2.0 / 3);
  CHECK(radius - frame.position[0].z == near(overlap, 1e-3));
}

}  // namespace mechanics_gravity_test
