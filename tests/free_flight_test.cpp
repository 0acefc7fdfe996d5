// Tests of the closed-form motion of bodies without contacts (src/mechanics/free_flight.hpp).
#include <doctest/doctest.h>

#include <cmath>

#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/free_flight.hpp"
#include "src/mechanics/stepper.hpp"
#include "tests/line_charges.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace free_flight_test {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using mechanics::FreeFall;

namespace {

/// Two fast conductors in oil with a constant force that reverses them, and the data for CVODE.
struct FlyingPair {
  FlyingPair() : scene(conductor_scene({{0.01, 0.05}, {0.05, 0.05}})), model(with_contacts()) {
    model.bodies.momentum = {0.3 * mass, 0.1 * mass, -0.2 * mass, 0};
  }
  Model with_contacts() {
    scene.effects.add<effects::HertzContactOptions>();
    scene.effects.add<effects::WallContactOptions>();
    scene.mechanics.relative_tolerance = 1e-10;
    auto field = std::make_unique<effects::FloatingConductors>(scene, std::make_unique<LineCharges>());
    field->follow(held);
    return effects::make_model(scene, effects::made(std::move(field)));
  }

  Scene scene;
  effects::ExtrapolatedField held{
      .time = 1, .force = {{1e-3, -2e-3}, {-3e-3, 1e-3}}, .force_rate = {{-0.5, 0.1}, {0.4, 0}}};
  Model model;
};

}  // namespace

TEST_CASE("FreeFall without drag: closed form of displacement and velocity") {
  const double t = 0.02, v = 0.3, f = 1e-3, rate = 0.7;
  const FreeFall fall(t, mass, 0);
  CHECK(fall.displacement(v, f, rate) == near(v * t + f * t * t / (2 * mass) + rate * t * t * t / (6 * mass), 1e-14));
  CHECK(fall.final_velocity(v, f, rate) == near(v + f * t / mass + rate * t * t / (2 * mass), 1e-14));
}

TEST_CASE("FreeFall with drag: solves m dv/dt = F + rate t - drag v") {
  const double v = 0.3, f = 1e-3, rate = 0.7;
  for (const double z : {1e-4, 0.03, 0.0999, 0.1, 1.0, 30.0}) {
    const double t = z * relaxation;
    // The particular solution and the decay in full: for small z they cancel with 1/z^2 roundings.
    const double slope = rate / drag, start = f / drag - slope * relaxation;
    const double speed = start + slope * t + (v - start) * std::exp(-z);
    const double displacement = start * t + slope * t * t / 2 - (v - start) * relaxation * std::expm1(-z);
    const FreeFall fall(t, mass, drag);
    const double cancelled = 1e-15 + 1e-16 / (z * z);
    CHECK(fall.final_velocity(v, f, rate) == near(speed, 10 * cancelled));
    CHECK(fall.displacement(v, f, rate) == near(displacement, 10 * cancelled));
  }
}

TEST_CASE("FreeFlight: one closed-form step equals CVODE's motion") {
  FlyingPair exact, solved;
  mechanics::FreeFlight flight(exact.model);
  CHECK(flight.advance(1, 1.02, exact.held, {}) == 1.02);
  mechanics::make_cvode(solved.scene, solved.model).advance(1, 1.02);
  for (int c = 0; c < 4; ++c) {
    CHECK(std::abs(exact.model.bodies.position[c] - solved.model.bodies.position[c]) < 1e-7 * radius);
    CHECK(std::abs(exact.model.bodies.momentum[c] - solved.model.bodies.momentum[c]) < 1e-7 * 0.3 * mass);
  }
}

TEST_CASE("FreeFlight: ends at an event's first zero crossing in its direction") {
  FlyingPair pair;
  mechanics::FreeFlight flight(pair.model);
  // The first conductor moves to the right and is driven back: x - 0.0101 rises through zero at 0.4 ms and falls later.
  const double line = 0.0101;
  const auto first_passage = [&](int direction) {
    FlyingPair fresh;
    mechanics::FreeFlight f(fresh.model);
    const mechanics::Events events{.direction = {direction, +1},
                                   .values =
                                       [&](std::span<double> value) {
                                         value[0] = fresh.model.bodies.position[0] - line;
                                         value[1] = -1;
                                       },
                                   .longest_step = [](std::span<const double>) { return 1e-3; }};
    const double time = f.advance(1, 1.05, fresh.held, events);
    CHECK(direction * (fresh.model.bodies.position[0] - line) >= 0);
    // 1e-9 of an interval of 1 ms between checks, at most at 1 m/s.
    CHECK(std::abs(fresh.model.bodies.position[0] - line) < 1e-9 * 1e-3);
    return time;
  };
  const double up = first_passage(+1), down = first_passage(-1);
  CHECK(up < 1.002);
  CHECK(down > up);
  CHECK(down < 1.05);
}

TEST_CASE("FreeFlight of one body, CVODE of the other: event of the first is found") {
  const double line = 0.0101;
  FlyingPair mixed, solved;
  const auto events_of = [&](FlyingPair& pair) {
    return mechanics::Events{.direction = {-1, +1},
                             .values =
                                 [&](std::span<double> value) {
                                   value[0] = pair.model.bodies.position[0] - line;
                                   value[1] = -1;
                                 },
                             .longest_step = [](std::span<const double>) { return 1e-3; },
                             .watched = {0, 1}};
  };
  mechanics::FreeFlight flight(mixed.model);
  mechanics::Cvode cvode = mechanics::make_cvode(mixed.scene, mixed.model);
  const double time = flight.advance(1, 1.05, mixed.held, events_of(mixed), {1}, cvode);
  const double expected = mechanics::make_cvode(solved.scene, solved.model).advance(1, 1.05, events_of(solved));
  CHECK(cvode.steps() > 0);
  CHECK(expected < 1.05);
  CHECK(std::abs(time - expected) < 1e-8);  // 1e-7 of a radius at 1/40 of the speed or more.
  for (int c = 0; c < 4; ++c) {
    CHECK(std::abs(mixed.model.bodies.position[c] - solved.model.bodies.position[c]) < 1e-7 * radius);
    CHECK(std::abs(mixed.model.bodies.momentum[c] - solved.model.bodies.momentum[c]) < 1e-5 * 0.3 * mass);
  }
}

TEST_CASE("FreeFlight::interacting: lists bodies that may reach bodies or walls") {
  FlyingPair pair;
  const mechanics::FreeFlight flight(pair.model);
  const double gap = 0.04 - 2 * radius, to_side = 0.01 - radius;
  const std::vector<int> none, first{0}, both{0, 1};
  CHECK(flight.interacting(std::vector{0.1 * gap, 0.85 * gap}) == none);
  CHECK(flight.interacting(std::vector{0.1 * gap, 0.95 * gap}) == both);
  CHECK(flight.interacting(std::vector{0.99 * to_side, 0.0}) == none);
  CHECK(flight.interacting(std::vector{1.01 * to_side, 0.0}) == first);
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05, 0.05 + 1.999 * radius}});
  scene.effects.add<effects::HertzContactOptions>();
  Model touching = effects::make_model(
      scene, effects::made(std::make_unique<effects::FloatingConductors>(scene, std::make_unique<LineCharges>())));
  CHECK(mechanics::FreeFlight(touching).interacting(std::vector{0.0, 0.0}) == both);
}

}  // namespace free_flight_test
