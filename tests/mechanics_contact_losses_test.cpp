// Restitution and sliding friction of conductors in contact.
#include "src/effects/contact_losses.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "src/analysis/circuit.hpp"
#include "src/effects/gravity.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/line_charges.hpp"
#include "tests/near.hpp"
#include "tests/scene_texts.hpp"
#include "tests/spheres.hpp"

namespace mechanics_contact_losses_test {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using effects::ContactLosses;

namespace {

constexpr double young = 1e8, g = 9.81;

/// Scene of spheres with contacts that have these losses, without a field.
Scene scene_with(const std::vector<Vec2>& positions, const ContactLosses& losses, const ContactLosses& at_walls) {
  Scene scene = scene_of(positions);
  scene.effects.add(effects::HertzContactOptions{.young = young, .losses = losses});
  scene.effects.add(effects::WallContactOptions{.young = young, .losses = at_walls});
  scene.mechanics.relative_tolerance = 1e-7;
  scene.stop.stationary = false;
  return scene;
}

}  // namespace

TEST_CASE("restitution: collisions at any speed have the given coefficient") {
  for (const double restitution : {1.0, 0.9, 0.5, 0.1})
    for (const double speed : {1e-3, 0.1}) {
      CAPTURE(restitution);
      CAPTURE(speed);
      Scene scene = scene_with({{0.05, 0.05}, {0.0516, 0.0502}}, {.restitution = restitution}, {});
      scene.conductors[1].radius = 0.7 * radius;
      const Vec3 n = scene.conductors[1].position - scene.conductors[0].position;
      scene.conductors[0].velocity = speed / norm(n) * n;  // head-on
      Simulation simulation(scene);
      simulation.advance_to(1e-3 / speed);
      const ConductorFrame frame = simulation.now();
      const Vec3 separating = frame.velocity[1] - frame.velocity[0];
      // The error of a momentum per CVODE step is 1e-7 of itself, and a collision has some 1000 steps.
      CHECK(dot(separating, n) / norm(n) == near(restitution * speed, 1e-3));
      const double small = 0.343 * mass;
      CHECK(frame.velocity[0].x * mass + frame.velocity[1].x * small ==
            near(scene.conductors[0].velocity.x * mass, 1e-9));
    }
}

// The error test bounds each momentum's error in a step by relative_tolerance of the momentum, and of the floor of
// make_cvode(). That floor is the speed of the smaller radius in largest_step. The bodies' speeds add up to at most 2.5
// times the impact speed. In the variable u of ContactLoss the collision is that of a linear spring and dashpot. There,
// errors of the relative velocity do not grow, so that those of the steps add up.
TEST_CASE("restitution: 990 collisions have the errors of their steps") {
  constexpr double small = 0.7;
  for (const double restitution : {0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0})
    for (int speeds = 0; speeds < 10; ++speeds)
      for (int gaps = 0; gaps < 9; ++gaps) {
        const double speed = 1e-3 * std::pow(200, speeds / 9.0), gap = 2.5e-5 * std::pow(1.7, gaps);
        Scene scene =
            scene_with({{0.05, 0.05}, {0.05 + (1 + small) * radius + gap, 0.05}}, {.restitution = restitution}, {});
        scene.conductors[1].radius = small * radius;
        scene.conductors[0].velocity = {speed, 0, 0};
        if (restitution == 1) scene.mechanics.relative_tolerance = 1e-6;  // old Jacobians matter in long steps
        int steps = 0;
        Simulation simulation(scene);
        simulation.advance_to(5e-3 / speed, [&] { return ++steps, false; });
        const ConductorFrame frame = simulation.now();
        const double separating = frame.velocity[1].x - frame.velocity[0].x;
        const double floor = small * radius / scene.mechanics.largest_step;
        const double bound = steps * scene.mechanics.relative_tolerance * (2.5 * speed + 2 * floor);
        CAPTURE(restitution);
        CAPTURE(speed);
        CAPTURE(gap);
        CHECK(std::abs(separating - restitution * speed) <= bound);
      }
}

TEST_CASE("restitution: a wall reflects with the given coefficient") {
  Scene scene = scene_with({{0.05, 0.002}}, {}, {.restitution = 0.6});
  scene.conductors[0].velocity = {0.01, -0.05, 0};
  Simulation simulation(scene);
  simulation.advance_to(0.05);
  const Vec3 velocity = simulation.now().velocity[0];
  CHECK(velocity.y == near(0.03, 1e-3));
  CHECK(velocity.x == near(0.01, 1e-9));  // no friction
}

TEST_CASE("ContactLoss: the slope is the derivative by the velocity") {
  const effects::ContactLoss loss(ContactLosses{.restitution = 0.4, .friction = 0.3, .friction_speed = 1e-2});
  const effects::HertzForce elastic = effects::hertz(1e8, radius, 1e-6);
  const Vec3 normal{0.6, 0, 0.8}, velocity{-0.03, 0.02, 0.01};
  const effects::LossForce at = loss(elastic, mass, normal, velocity);
  CHECK(at.power == near(-dot(at.force, velocity), 1e-12));
  for (int k = 0; k < 3; ++k) {
    const double step = 1e-7;
    Vec3 more = velocity, less = velocity;
    more[k] += step, less[k] -= step;
    const Vec3 difference = loss(elastic, mass, normal, more).force - loss(elastic, mass, normal, less).force;
    for (int row = 0; row < 3; ++row)
      CHECK(at.slope[row][k] == doctest::Approx(difference[row] / (2 * step)).epsilon(1e-6).scale(1e-6));
  }
}

// The normal force is m g, so that the deceleration is mu g until the speed is of the order of friction_speed.
TEST_CASE("friction: a sliding sphere stops after v^2 / (2 mu g)") {
  const double mu = 0.3, speed = 0.05;
  Scene scene = scene_with({{0.02, 0}}, {}, {.restitution = 0.3, .friction = mu, .friction_speed = 1e-6});
  scene.effects.add(effects::GravityOptions{.acceleration = g});
  // The overlap at rest: 4/3 E* sqrt(R) overlap^(3/2) = m g
  const double modulus = young / (2 * (1 - 0.09));
  scene.conductors[0].position.y = radius - std::pow(0.75 * mass * g / (modulus * std::sqrt(radius)), 2.0 / 3);
  scene.conductors[0].velocity = {speed, 0, 0};
  Simulation simulation(scene);
  simulation.advance_to(0.01);
  CHECK(simulation.now().velocity[0].x == near(speed - mu * g * 0.01, 1e-4));
  simulation.advance_to(0.1);
  CHECK(simulation.now().velocity[0].x < 1e-6);
  CHECK(simulation.now().position[0].x - 0.02 == near(speed * speed / (2 * mu * g), 1e-3));
}

// On a slope of angle a, friction mu cos(a) v / sqrt(v^2 + v_s^2) balances sin(a) at a creeping speed below v_s if
// tan(a) < mu / sqrt(2); beyond mu the sphere accelerates.
TEST_CASE("friction: creeps on a flat slope, slides on a steep one") {
  const double mu = 0.5, slow = 1e-4;
  const auto speed_at = [&](double slope, double time) {
    Scene scene = scene_with({{0.02, radius}}, {}, {.restitution = 0.3, .friction = mu, .friction_speed = slow});
    scene.effects.add(effects::GravityOptions{.acceleration = g, .direction = Coordinates{{slope, -1, 0}, 2}});
    Simulation simulation(scene);
    simulation.advance_to(time);
    return simulation.now().velocity[0].x;
  };
  CHECK(speed_at(0.2, 0.1) == near(slow * 0.2 / std::sqrt(mu * mu - 0.04), 1e-3));
  const double steep = 0.8, cosine = 1 / std::hypot(1, steep);
  const double expected = g * cosine * (steep - mu) * 0.1;
  CHECK(speed_at(steep, 0.1) == near(expected, 0.02));  // 2 %: the bounce at the start
}

TEST_CASE("friction between spheres: momentum is conserved, sliding is slowed") {
  Scene scene = scene_with({{0.05, 0.05}, {0.0516, 0.0503}}, {.restitution = 0.8, .friction = 0.4}, {});
  scene.conductors[0].velocity = {0.1, 0, 0};
  Simulation simulation(scene);
  simulation.advance_to(0.02);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.velocity[0].x + frame.velocity[1].x == near(0.1, 1e-9));
  CHECK(std::abs(frame.velocity[0].y + frame.velocity[1].y) < 1e-9 * 0.1);
  // The tangential impulse is mu times the normal one while the surfaces slide, here through the whole collision.
  const Vec3 impulse = frame.velocity[1];
  const Vec3 n = scene.conductors[1].position - scene.conductors[0].position;
  // At the collision the line of centres has this height over the distance 2 R of the centres.
  const double sine = n.y / (2 * radius), cosine = std::sqrt(1 - sine * sine);
  const double along = impulse.x * cosine + impulse.y * sine, across = impulse.x * sine - impulse.y * cosine;
  CHECK(along == near(0.5 * (1 + 0.8) * 0.1 * cosine, 2e-3));
  CHECK(std::abs(across) <= 0.4 * along * (1 + 1e-3));
  CHECK(across > 0);
}

TEST_CASE("heap: three spheres with friction stay, without friction they spread") {
  const auto spread = [&](double mu) {
    const double half = 1.001 * radius, height = radius + std::sqrt(4 - 1.001 * 1.001) * radius;
    const ContactLosses losses{.restitution = 0.3, .friction = mu, .friction_speed = 1e-4};
    Scene scene = scene_with({{0.05 - half, radius}, {0.05 + half, radius}, {0.05, height}}, losses, losses);
    scene.effects.add(effects::GravityOptions{.acceleration = g});
    Simulation simulation(scene);
    simulation.advance_to(0.3);
    const ConductorFrame frame = simulation.now();
    return 0.5 * (frame.position[1].x - frame.position[0].x) - half;
  };
  CHECK(spread(0.5) < 1e-4 * 0.3 + 1e-3 * radius);  // creeping below friction_speed, and the first contact
  CHECK(spread(0) > 0.2 * radius);
}

// The energy balance of a scene with a circuit includes the heat of losses in contacts, with that of drag.
TEST_CASE("losses in contacts: their heat closes the energy balance") {
  Scene scene = scene_with({{0.05, 0.05}, {0.0516, 0.0503}}, {.restitution = 0.7, .friction = 0.3}, {});
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add(effects::LeakageOptions{.conductivity = 1e-12});  // makes a circuit
  scene.electrodes = {ball("ground", {0.01, 0.01}, 0)};
  scene.conductors[0].velocity = {0.1, 0, 0};
  Simulation simulation(scene, std::make_unique<LineCharges>());
  const double before = 0.5 * mass * 0.01;
  simulation.advance_to(0.01);
  const ConductorFrame frame = simulation.now();
  const EnergyBalance& energy = *frame.energy_balance;
  CHECK(energy.flows.drag > 0.1 * before);
  // Regression value: 1.4e-5. The damped force ends with 2.9 % of the energy stored, whose loss heat_of_losses()
  // resolves.
  CHECK(energy.kinetic + energy.flows.drag == near(before, 1e-4));
}

TEST_CASE("friction_speed: is refused without friction") {
  using namespace scene_texts;
  for (const std::string effect : {"hertz_contact", "wall_contact"})
    for (const std::string losses : {"friction_speed = 1e-4\n", "friction = 0.0\nfriction_speed = 1e-4\n"})
      check_refused(box + electrostatics + grounded + disk("[0.01, 0.01]") + "[effects." + effect + "]\n" + losses,
                    {"effects." + effect + ".friction_speed needs effects." + effect + ".friction"});
}

}  // namespace mechanics_contact_losses_test
