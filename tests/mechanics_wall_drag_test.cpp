// Tests of motion with drag near walls: sedimentation towards and along a wall, heat of drag, restored runs.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "src/effects/gravity.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/wall_drag.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/near.hpp"
#include "tests/restored.hpp"
#include "tests/spheres.hpp"

namespace mechanics_wall_drag_test {

using namespace lichtenberg;
using steel_spheres::cube_of;
using steel_spheres::drag;
using steel_spheres::mass;
using steel_spheres::radius;
using steel_spheres::relaxation;

namespace {

constexpr double start_gap = 2;  // radii
constexpr double acceleration = 0.3;

/// Scene of a sphere above the front side of a cube, on which gravity acts along `direction`.
Scene falling(Vec3 direction, bool field) {
  Scene scene = cube_of({{0.03, 0.03, (1 + start_gap) * radius}}, 1e-3);
  if (!field) {
    scene.effects = {};
  }
  scene.effects.add(effects::StokesDragOptions{.walls = true});
  scene.effects.add(effects::GravityOptions{.acceleration = acceleration, .direction = Coordinates{direction, 3}});
  return scene;
}

/// Returns the drag on the sphere over Stokes's at a gap (radii) from the front side. All sides count, as in the
/// effect.
double factor_at(double gap) {
  const double across = (0.06 - (1 + gap) * radius) / radius - 1, aside = 0.03 / radius - 1;
  return effects::drag_towards_wall(gap) + effects::drag_towards_wall(across) - 1 +
         4 * (effects::drag_along_wall(aside) - 1);
}

/// Time (s) in which a sphere sinks from rest at start_gap to `gap`. By the balance of momentum, weight times time is
/// the integral of the drag over the path plus the final momentum. The integral is by Simpson's rule in the logarithm
/// of the gap. In the small final momentum the speed is that without inertia.
double sinking_time(double gap) {
  constexpr int intervals = 400;
  const double step = std::log(start_gap / gap) / intervals;
  double sum = 0;
  for (int k = 0; k <= intervals; ++k) {
    const double g = gap * std::exp(k * step);
    sum += (k == 0 || k == intervals ? 1 : k % 2 == 1 ? 4 : 2) * g * factor_at(g);
  }
  return sum * step / 3 * radius * drag / (mass * acceleration) + relaxation / factor_at(gap);
}

}  // namespace

TEST_CASE("sphere sinks to a wall: time is the integral of Brenner's drag") {
  for (const bool field : {false, true}) {
    CAPTURE(field);
    for (const double gap : {0.5, 0.05, 0.01}) {
      CAPTURE(gap);
      Scene scene = falling({0, 0, -1}, field);
      scene.mechanics.relative_tolerance = 1e-8;
      Simulation simulation(scene);
      simulation.advance_to(sinking_time(gap));
      const ConductorFrame frame = simulation.now();
      // Some hundred steps with errors of 1e-8, and the interpolation of the factors, 1e-6 of the path.
      CHECK(std::abs(frame.position[0].z / radius - 1 - gap) < 5e-6);
      CHECK(-frame.velocity[0].z == near(mass * acceleration / (drag * factor_at(gap)), 1e-2));
    }
  }
}

TEST_CASE("sphere falls along a wall: terminal speed has O'Neill's factor") {
  Scene scene = falling({1, 0, 0}, false);
  scene.conductors[0].position.z = 1.1 * radius;
  Simulation simulation(scene);
  simulation.advance_to(20 * relaxation);
  const double aside = 0.03 / radius - 1, across = (0.06 - 1.1 * radius) / radius - 1;
  const double factor = effects::drag_along_wall(0.1) + effects::drag_along_wall(across) - 1 +
                        2 * (effects::drag_along_wall(aside) - 1) + 2 * (effects::drag_towards_wall(aside) - 1);
  CHECK(simulation.now().velocity[0].x == near(mass * acceleration / (drag * factor), 1e-5));
}

TEST_CASE("drag near a wall: heat of drag balances the energy of the fall") {
  for (const Integrator integrator : {Integrator::cvode, Integrator::euler}) {
    Scene scene = falling({0, 0, -1}, true);
    scene.effects.add(effects::LeakageOptions{.conductivity = 1e-12});  // a circuit, whose energy is recorded
    scene.mechanics.integrator = integrator;
    Simulation simulation(scene);
    const double height = scene.conductors[0].position.z;
    simulation.advance_to(0.3);
    const ConductorFrame frame = simulation.now();
    const double fallen = mass * acceleration * (height - frame.position[0].z);
    const double kinetic = mass / 2 * norm2(frame.velocity[0]);
    CHECK(fallen > 0);
    // Euler's steps of 1e-5 s have relative errors of step / relaxation time.
    CHECK(frame.energy_balance->flows.drag == near(fallen - kinetic, integrator == Integrator::euler ? 0.02 : 1e-4));
  }
}

TEST_CASE("drag near a wall: a restored run continues with identical bits") {
  Scene scene = falling({0.3, 0, -1}, true);
  scene.conductors.push_back({.position = {0.034, 0.03, 2 * radius}, .radius = radius, .charge = 3e-11});
  scene.conductors[0].charge = -3e-11;
  check_restored(scene, 0.1, 0.2);
}

}  // namespace mechanics_wall_drag_test
