// Tests of friction and rotation of grains: collisions of two spheres, sliding and rolling on a wall.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "src/granular/rough_motion.hpp"
#include "tests/message.hpp"
#include "tests/rough_grains.hpp"

namespace granular_rough_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using doctest::Approx;

namespace {

constexpr double lighter = 3.5;  // 1 + m R^2 / I of solid spheres

/// Relative velocities of the surfaces of two grains before and after an oblique collision.
struct Oblique {
  double normal_before = 0, normal_after = 0;  ///< approach speed, separation speed
  double across_before = 0, across_after = 0;  ///< velocity of the surface across the normal
  Momenta before, after;
};

/// Collides two grains with the relative velocity (1, across). The contact is so short that its normal rotates by less
/// than the duration times `across`.
Oblique collide(Scene scene, double across, double spin = 0) {
  const Vec3 middle = 0.5 * scene.domain.size;
  constexpr double gap = 1e-3;
  // Offset: at contact the centres are along x.
  const Vec3 half = {0.5 * (1 + gap), 0.5 * gap * across, 0};
  grains::add(scene, middle - half, {0.5, 0.5 * across, 0});
  grains::add(scene, middle + half, {-0.5, -0.5 * across, 0});
  for (Conductor& grain : scene.conductors) grain.angular_velocity = {0, 0, spin};
  Run run(scene);
  const Bodies& b = run.gas.bodies();
  const auto surface = [&] {
    const double turning = 0.5 * (granular::spin_of(b, 0).z + granular::spin_of(b, 1).z);
    return (velocity<3>(b, 0) - velocity<3>(b, 1)).y + turning;  // (w x n)_y = w_z
  };
  Oblique found{.normal_before = 1, .across_before = surface(), .before = momenta(b)};
  run_collision(run);
  found.normal_after = (velocity<3>(b, 1) - velocity<3>(b, 0)).x;
  found.across_after = surface();
  found.after = momenta(b);
  return found;
}

}  // namespace

// Contacts last 2.2e-4 (e = 1) with an overlap of 1e-4, by which the normal rotates during the contact. This changes
// velocities by up to 4 * 2.2e-4 * 4.
TEST_CASE("sliding collision: the tangential impulse is mu times the normal one") {
  for (const double e : {1.0, 0.8})
    for (const double across : {2.0, 4.0}) {
      CAPTURE(e);
      CAPTURE(across);
      constexpr double mu = 0.1;
      const Oblique found = collide(frictional(10, {.stiffness = 1e8, .restitution = e}, {.coefficient = mu}), across);
      CHECK(found.normal_after == Approx(e).epsilon(4e-3));
      CHECK(found.across_after == Approx(across - mu * (1 + e) * lighter).epsilon(4e-3));
    }
}

// Without friction limit, the surfaces oscillate with k_t (1 + 1/q) / m_eff during the normal contact. With equal
// ratios of stiffness and damping of 2/7 both motions are the same, so that beta_0 = e.
TEST_CASE("sticking collision: Walton's beta_0 is that of the tangential spring") {
  for (const double ratio : {0.05, 0.1, 0.2, 2.0 / 7}) {
    CAPTURE(ratio);
    const Oblique found = collide(frictional(10, {.stiffness = 1e8, .damping = 0},
                                             {.coefficient = 1e3, .stiffness_ratio = ratio, .damping_ratio = 0}),
                                  0.5);
    const double beta = -std::cos(std::numbers::pi * std::sqrt(lighter * ratio));
    CHECK(found.across_after == Approx(-beta * 0.5).epsilon(4e-3).scale(0.5));
  }
  const Oblique damped = collide(frictional(10, {.stiffness = 1e8, .restitution = 0.8}, {.coefficient = 1e3}), 0.5);
  CHECK(damped.across_after == Approx(-0.8 * 0.5).epsilon(4e-3));
}

// The cut-off ends the force within a substep, in which the spring rotates by up to pi/2 / 400 of its oscillation.
TEST_CASE("tangential restitution: a sticking collision has the given beta_0") {
  for (const double beta : {-0.5, 0.0, 0.6}) {
    CAPTURE(beta);
    Scene scene =
        frictional(10, {.stiffness = 1e8, .restitution = 0.9}, {.coefficient = 1e3, .tangential_restitution = beta});
    scene.mechanics.contact_steps = 400;
    const Oblique found = collide(scene, 0.5, 0.7);
    CHECK(found.across_before == Approx(1.2));
    CHECK(found.across_after == Approx(-beta * 1.2).epsilon(4e-3).scale(1.2));
  }
}

TEST_CASE("oblique collision: momentum and angular momentum are conserved") {
  const Oblique found =
      collide(frictional(10, {.stiffness = 1e3}, {.coefficient = 0.4, .rolling_coefficient = 0.1}), 1, 2);
  CHECK(norm(found.after.linear - found.before.linear) < 1e-13);
  CHECK(norm(found.after.angular - found.before.angular) < 1e-12);
  CHECK(found.after.angular.z != Approx(0));
}

// Dashpots act with predicted velocities, too large by (w h)^2 / 2 = pi^2 / (2 n^2). The other errors are of the order
// of 1 - e = 0.1 of this one, or of n^-2.5.
TEST_CASE("rough contact: the energy error is pi^2/2 (1 - e^2)/n^2 at weak damping") {
  for (const double e : {0.95, 0.9})
    for (const int n : {16, 32, 64}) {
      CAPTURE(e);
      CAPTURE(n);
      double worst = 0;
      for (int k = 0; k < 5; ++k) {
        Scene scene = cube(10);
        scene.effects.add(effects::LinearContactOptions{.stiffness = 1e5, .restitution = e});
        add_walls(scene, {2});
        scene.mechanics.contact_steps = n;
        add_pair(scene, 1, 0.013 + 0.0017 * k);
        Run run(scene);
        run_collision(run);
        worst = std::max(worst, std::abs(run.gas.energy().total() / 0.25 - 1));
      }
      MESSAGE("e = " << e << ", n = " << n << ": " << worst);
      CHECK(worst == Approx(0.5 * std::numbers::pi * std::numbers::pi * (1 - e * e) / (n * n)).epsilon(0.15));
    }
}

namespace {

/// Grain on the bottom wall under gravity 1, at its equilibrium overlap.
Scene on_floor(Vec3 velocity, const effects::FrictionOptions& friction, int dimension = 3) {
  constexpr double stiffness = 1e4;
  Scene scene = frictional(10, {.stiffness = stiffness, .restitution = 0.5}, friction);
  if (dimension == 2) scene.domain.size.z = 0;
  add_walls(scene, {1});
  scene.effects.add(effects::UniformForceOptions{.acceleration = {{0, -1, 0}, dimension}});
  scene.mechanics.step = 0.002;
  grains::add(scene, {2, 0.5 - 1 / stiffness, dimension == 3 ? 5.0 : 0.0}, velocity);
  return scene;
}

}  // namespace

// Sphere of I = 2/5 m R^2: it slides with the deceleration mu g until t = 2/7 v0 / (mu g), then rolls with 5/7 v0. The
// tangential spring of length mu g / k_t = 1e-4 begins unstretched.
TEST_CASE("sliding sphere on a wall: it rolls on with 5/7 of its speed") {
  for (const int dimension : {2, 3}) {
    constexpr double mu = 0.3;
    Run run(on_floor({1, 0, 0}, {.coefficient = mu}, dimension));
    run.to(0.5);
    CHECK(run.gas.bodies().momentum[0] == Approx(1 - mu * 0.5).epsilon(2e-3));
    CHECK(granular::spin_of(run.gas.bodies(), 0).z == Approx(-2.5 * mu * 0.5 / 0.5).epsilon(2e-3));
    run.to(1.5);
    CHECK(run.gas.bodies().momentum[0] == Approx(5.0 / 7).epsilon(2e-3));
    CHECK(granular::spin_of(run.gas.bodies(), 0).z == Approx(-10.0 / 7).epsilon(2e-3));
    const double slid = 12.0 / 49 / mu, rolled = 5.0 / 7 * (1.5 - 2.0 / 7 / mu);
    CHECK(run.gas.bodies().position[0] == Approx(2 + slid + rolled).epsilon(2e-3));
  }
}

TEST_CASE("rolling resistance: a rolling sphere decelerates by 5/7 mu_r g") {
  Scene scene = on_floor({1, 0, 0}, {.coefficient = 0.5, .rolling_coefficient = 0.05});
  scene.conductors[0].angular_velocity = {0, 0, -2};
  Run run(scene);
  run.to(2);
  CHECK(run.gas.bodies().momentum[0] == Approx(1 - 5.0 / 7 * 0.05 * 2).epsilon(2e-3));
}

// Between two elastic walls the period is two flights and two half periods of the spring, pi sqrt(m/A).
TEST_CASE("grain between two walls: it bounces with the known period") {
  for (const double stiffer : {1.0, 4.0}) {
    CAPTURE(stiffer);
    constexpr double stiffness = 1e3, speed = 0.8;
    Scene scene = cube(4);
    scene.effects.add(effects::LinearContactOptions{.stiffness = 1, .damping = 0});
    add_walls(scene, {0}, {.stiffness = stiffness});
    if (stiffer > 1) scene.stages = {{.duration = 200, .stiffness = stiffer}};
    grains::add(scene, {2, 2, 2}, {speed, 0, 0});
    const double period = 2 * (4 - 1) / speed + 2 * std::numbers::pi / std::sqrt(stiffer * stiffness);
    Run run(scene);
    run.to(10 * period);
    CHECK(run.gas.bodies().position[0] == Approx(2).epsilon(1e-3));
    CHECK(run.gas.bodies().momentum[0] == Approx(speed).epsilon(1e-4));
    CHECK(run.gas.energy().total() == Approx(0.5 * speed * speed).epsilon(1e-4));
  }
}

TEST_CASE("elastic stage: walls of their own material dissipate no energy") {
  Scene scene = frictional(4, {.stiffness = 1e3, .restitution = 0.5}, {.coefficient = 0.5});
  add_walls(scene, {0}, {.damping = 10, .friction = 0.3});
  scene.stages = {{.duration = 8}};
  grains::add(scene, {2, 2, 2}, {0.8, 0.3, 0});
  Run run(scene);
  run.to(7);
  CHECK(run.gas.energy().dissipated == 0);
  CHECK(norm(granular::spin_of(run.gas.bodies(), 0)) == 0);
  run.to(12);
  CHECK(run.gas.energy().dissipated > 0.1);
}

TEST_CASE("wall of its own material: the restitution is that of the wall") {
  Scene scene = cube(4);
  scene.effects.add(effects::LinearContactOptions{.stiffness = 1e4, .damping = 0});
  add_walls(scene, {0}, {.damping = linear_damping(1e4, 0.6, 1)});
  grains::add(scene, {3, 2, 2}, {1, 0, 0});
  Run run(scene);
  run.to(1.5);
  CHECK(run.gas.bodies().momentum[0] == Approx(-0.6).epsilon(1e-3));
}

// The first grain gives the second its speed of 5 within 7e-3. The second then closes the gap of 0.02 to the third,
// which was at rest relative to it. Separate calls search before each substep.
TEST_CASE("contact search of rough grains: one hit within a call hits another") {
  Scene scene = grains::cube(20);
  grains::add(scene, {8.99, 10, 10}, {5, 0, 0});
  grains::add(scene, {10, 10, 10});
  grains::add(scene, {11.02, 10, 10});
  const auto onset = [&](int steps) {
    Bodies bodies = make_bodies(scene);
    std::vector<GrainContact> contacts;
    const auto motion = granular::make_rough_motion(LinearSpringLaw{1e5, 0}, {.friction = {.coefficient = 0.5}}, 3);
    motion->begin(bodies);
    constexpr double h = 2e-4;
    for (int n = 0; n < 60; n += steps) {
      const granular::ContactSteps all{.begin = n * h, .time = steps * h, .steps = steps, .search_path = 1};
      for (const GrainContact& one : motion->advance(bodies, contacts, {}, all, parallel::Team::single()).record.begun)
        if (one.pair == Pair{1, 2}) return one.since;
    }
    return -1.0;
  };
  const double since = onset(1);
  CHECK(since > 6e-3);
  CHECK(onset(3) == Approx(since).epsilon(1e-9));
  CHECK(onset(60) == Approx(since).epsilon(1e-9));
}

// The linear spring stops the unit mass at an overlap of v sqrt(1/A): 0.4 of the radius 0.5 at A = 6.25, beyond the
// centre at A = 1.
TEST_CASE("wall that is too soft: a grain at its depth ends the run") {
  const auto message = [](double stiffness) {
    Scene scene = cube(4);
    scene.effects.add(effects::LinearContactOptions{.stiffness = 1e4, .damping = 0});
    add_walls(scene, {0}, {.stiffness = stiffness});
    grains::add(scene, {3, 2, 2}, {1, 0, 0});
    Run run(scene);
    return message_of([&] { run.to(4); });
  };
  CHECK(message(6.25).empty());
  const std::string found = message(1);
  CHECK_MESSAGE(found.starts_with("grain 0 flies through the wall at the right side: the contact is too soft"), found);
}

}  // namespace granular_rough_test
