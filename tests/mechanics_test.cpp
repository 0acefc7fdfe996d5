#include <doctest/doctest.h>

#include <cmath>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/free_flight.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/mechanics/step_control.hpp"
#include "src/mechanics/stepper.hpp"
#include "tests/line_charges.hpp"
#include "tests/message.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace mechanics_test {

using namespace lichtenberg;
using namespace lichtenberg::mechanics;
using namespace lichtenberg::steel_spheres;

// ---- step control

TEST_CASE("displacement by a linearly growing force: equals a Runge-Kutta solution") {
  // Classical Runge-Kutta for m dv/dt = e t/T - drag v. The 2000 steps are at most 0.05 relaxation times long: error
  // 1e-7.
  for (const double dt : {1e-5, 1e-3, 1e-1}) {
    const int steps = 2000;
    const double h = dt / steps;
    const auto acceleration = [&](double t, double v) { return (1e-6 * t / dt - drag * v) / mass; };
    double x = 0, v = 0;
    for (int k = 0; k < steps; ++k) {
      const double t = k * h;
      const double a1 = acceleration(t, v), v2 = v + 0.5 * h * a1, a2 = acceleration(t + 0.5 * h, v2);
      const double v3 = v + 0.5 * h * a2, a3 = acceleration(t + 0.5 * h, v3);
      const double v4 = v + h * a3, a4 = acceleration(t + h, v4);
      x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    CHECK(displacement(1e-6, dt, mass, drag) == near(x, 1e-6));
  }
}

TEST_CASE("displacement by a growing force: limits where inertia or drag dominates") {
  CHECK(displacement(2, 1e-7, mass, drag) == near(2 * 1e-14 / (6 * mass), 1e-4));
  CHECK(displacement(2, 3, mass, 0) == near(2 * 9 / (6 * mass)));
  CHECK(displacement(2, 100, mass, drag) == near(2 * 100 / (2 * drag), 1e-4));
  // The series and the closed form meet here; the next term of the series is 2e-9.
  const double seam = 0.01 * relaxation;
  CHECK(displacement(1, seam * (1 - 1e-12), mass, drag) == near(displacement(1, seam * (1 + 1e-12), mass, drag), 1e-8));
}

TEST_CASE("time_to_displace: displacement is 0.3 to 1 times the tolerance") {
  for (const double rate : {1e-9, 1e-5, 1e-1, 1e3}) {
    const double dt = time_to_displace(1e-6, rate, mass, drag);
    const double reached = displacement(rate * dt, dt, mass, drag);
    CHECK(reached <= 1e-6 * (1 + 1e-12));
    CHECK(reached > 0.3e-6);
  }
  CHECK(std::isinf(time_to_displace(1e-6, 0, mass, drag)));
}

TEST_CASE("next_step: step times 0.9 error^(-1/order), a factor from 0.2 to 2") {
  CHECK(next_step(1, 0.125, 3) == near(1.8));
  CHECK(next_step(1, 8, 3) == near(0.45));
  CHECK(next_step(1, 0, 3) == 2);
  CHECK(next_step(1, 1e-9, 2) == 2);
  CHECK(next_step(1, 1e9, 2) == 0.2);
}

TEST_CASE("time_to_displace_from_rest: force growing as t^2 moves by the tolerance") {
  // m x'' = growth t^2 / 2 m, integrated twice: x = growth t^4 / 24 m^2.
  const double t = time_to_displace_from_rest(1e-6, 3e-4, mass);
  CHECK(3e-4 * std::pow(t, 4) / (24 * mass * mass) == near(1e-6));
  CHECK(std::isinf(time_to_displace_from_rest(1e-6, 0, mass)));
}

TEST_CASE("time_to_move: solves v t + a t^2 / 2 = path for the time t") {
  const double t = time_to_move(0.3, 2, 5);
  CHECK(2 * t + 2.5 * t * t == near(0.3));
  CHECK(time_to_move(0.3, 2, 0) == near(0.15));
  CHECK(std::isinf(time_to_move(0.3, 0, 0)));
  CHECK(std::isinf(time_to_move(INFINITY, 2, 5)));
}

// ---- CVODE

TEST_CASE("Stokes drag: velocity decays exponentially, position accordingly") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.conductors[0].velocity = {0.1, -0.05};
  scene.effects.add<effects::StokesDragOptions>();
  Simulation simulation(scene);
  const double t = 3e-3;
  simulation.advance_to(t);
  const ConductorFrame frame = simulation.now();
  const double left = std::exp(-t / relaxation);
  // Tolerances hold per step: 1e-6 of the momentum and 1e-6 radius. They may accumulate over some hundred steps.
  CHECK(norm(frame.velocity[0] - left * Vec3{0.1, -0.05, 0}) < 1e-4 * 0.11);
  CHECK(norm(frame.position[0] - Vec3{0.05, 0.05, 0} - relaxation * (1 - left) * Vec3{0.1, -0.05, 0}) < 1e-4 * radius);
}

TEST_CASE("Stokes drag: a constant force gives the terminal velocity") {
  Scene scene = conductor_scene({{0.05, 0.05}});
  const double force = 1e-5, terminal = force / drag;
  Simulation simulation(scene, scripted([&](const auto&) { return std::vector<Vec2>{{0, -force}}; }));
  const double t = 0.5;
  simulation.advance_to(t);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.velocity[0].y == near(-terminal, 1e-5));
  const double fallen = terminal * (t - relaxation * (1 - std::exp(-t / relaxation)));
  CHECK(std::abs(0.05 - frame.position[0].y - fallen) < 1e-4 * radius);
}

TEST_CASE("Hertz contact: duration is Hertz's, equal masses exchange velocities") {
  // At maximum overlap 1/2 m v^2 = 2/5 k delta^(5/2), with the reduced mass m and k = 4/3 E* sqrt(R_eff). The contact
  // lasts 2.943275 delta / v (Hertz 1882). Soft spheres make the duration visible in the positions.
  Scene scene = scene_of({{0.03, 0.05}, {0.03 + 2 * radius + 1e-3, 0.05}});
  const double v = 0.02;
  scene.conductors[0].velocity = {v, 0};
  scene.effects.add(effects::HertzContactOptions{.young = 2e6, .poisson = 0.3});
  scene.mechanics.relative_tolerance = 1e-8;
  const double modulus = 2e6 / (2 * 0.91), k = 4.0 / 3.0 * modulus * std::sqrt(radius / 2);
  const double deepest = std::pow(1.25 * 0.5 * mass * v * v / k, 0.4), duration = 2.943275 * deepest / v;
  Simulation simulation(scene);
  simulation.advance_to(0.2);
  const ConductorFrame frame = simulation.now();
  // Equal masses exchange their velocities. In contact both move at v/2 on average.
  CHECK(std::abs(frame.velocity[0].x) < 1e-4 * v);
  CHECK(frame.velocity[1].x == near(v, 1e-4));
  const double free_flight = 0.2 - 1e-3 / v - duration;
  const double gap = frame.position[1].x - frame.position[0].x - 2 * radius;
  CHECK(std::abs(gap - v * free_flight) < 0.02 * v * duration);
  CHECK(frame.velocity[1].y == 0);
}

TEST_CASE("Hertz contact: steel spheres bounce elastically without tunnelling") {
  // The flights between collisions are centimetres long; a collision lasts 10 microseconds.
  Scene scene = scene_of({{0.03, 0.05}, {0.06, 0.05 + 0.7 * radius}});
  scene.conductors[0].velocity = {0.5, 0};
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add<effects::WallContactOptions>();
  Simulation simulation(scene);
  simulation.advance_to(0.5);
  const ConductorFrame frame = simulation.now();
  const double energy = norm2(frame.velocity[0]) + norm2(frame.velocity[1]);
  // The implicit formulas dissipate a little in each of about six collisions; the bound is 1e-3 per collision.
  CHECK(energy == near(0.25, 6e-3));
  CHECK(std::abs(frame.velocity[1].y) > 0.05);  // The collision is off centre.
  for (const Vec3 p : frame.position) {
    CHECK(p.x > 0.9 * radius);
    CHECK(p.x < 0.1 - 0.9 * radius);
  }
}

TEST_CASE("collision: a body set in motion within a step hits its neighbour") {
  Scene scene = conductor_scene({{0.03, 0.05}, {0.033, 0.05}, {0.036, 0.05}});
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.effects.remove<effects::StokesDragOptions>();
  scene.effects.add<effects::HertzContactOptions>();
  scene.conductors[0].velocity = {0.1, 0};
  Simulation simulation(scene, no_forces());
  // In this single step the first body could cross both gaps, 2.9 mm, but not pass the second body.
  simulation.advance_to(0.036);
  const ConductorFrame frame = simulation.now();
  // Equal masses exchange their velocities, with an error of 1e-3 in each of two collisions.
  CHECK(std::abs(frame.velocity[0].x) < 2e-4);
  CHECK(std::abs(frame.velocity[1].x) < 2e-4);
  CHECK(frame.velocity[2].x == near(0.1, 2e-3));
}

TEST_CASE("collision: two bodies among hundreds at rest collide as if isolated") {
  Scene scene = scene_of({{0.03, 0.05}, {0.03 + 2.1 * radius, 0.05}});
  scene.conductors[0].velocity = {1e-3, 0};
  scene.effects.add<effects::HertzContactOptions>();
  const auto end = [&] {
    Simulation simulation(scene);
    simulation.advance_to(0.2);
    return simulation.now();
  };
  const ConductorFrame alone = end();
  for (int i = 0; i < 400; ++i)
    scene.conductors.push_back({.position = {2e-3 + i % 40 * 2.2e-3, 0.06 + i / 40 * 2.2e-3}, .radius = radius});
  const ConductorFrame watched = end();
  CHECK(alone.velocity[1].x > 0.9e-3);
  for (const int i : {0, 1}) {
    CHECK(watched.position[i] == alone.position[i]);
    CHECK(watched.velocity[i] == alone.velocity[i]);
  }
}

TEST_CASE("Electrics: an unaccepted trial changes nothing, rollback undoes a step") {
  const Scene scene = random_spheres();
  auto made = std::make_unique<effects::FloatingConductors>(scene, std::make_unique<LineCharges>());
  effects::FloatingConductors& field = *made;
  Model model = effects::make_model(scene, effects::made(std::move(made)));
  const effects::ContactDischarge discharge(scene);
  Counters counters;
  Electrics electrics(scene, model, field, &discharge, counters);
  electrics.connect();
  electrics.accept(electrics.solve(0));
  const ElectricalState before = electrics.now();
  const std::vector<double> charge = model.bodies.charge;

  const Trial trial = electrics.solve(1);
  CHECK(electrics.now().time == 0);
  CHECK(electrics.now().charges.save() == before.charges.save());
  CHECK(electrics.now().field.potential == before.field.potential);
  CHECK(model.bodies.charge == charge);

  electrics.accept(trial);
  CHECK(electrics.now().charges.injected() == near(12 * 0.2e-9));
  for (int i = 0; i < model.bodies.size(); ++i) CHECK(model.bodies.charge[i] == electrics.now().charges.charge(i));
  CHECK(electrics.now().field.potential == trial.field.potential);
  electrics.rollback(before);
  CHECK(electrics.now().charges.save() == before.charges.save());
  CHECK(electrics.now().time == 0);
}

TEST_CASE("Hertz contact: pressed steel in oil rests, below 100 steps per second") {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + 2 * radius, 0.05}});
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.effects.add<effects::HertzContactOptions>();
  auto field = std::make_unique<effects::FloatingConductors>(scene, no_forces());
  const effects::ExtrapolatedField held{.force = {{1e-3, 0}, {-1e-3, 0}}, .force_rate = {{}, {}}};
  field->follow(held);
  Model model = effects::make_model(scene, effects::made(std::move(field)));
  Cvode cvode = make_cvode(scene, model);
  cvode.advance(0, 0.1);
  const std::int64_t before = cvode.steps();
  cvode.advance(0.1, 1.1);
  CHECK(cvode.steps() - before < 100);  // The vibration has a period of 30 us.
  CHECK(norm(velocity(model.bodies, 0)) < 1e-9);
}

TEST_CASE("events: a body under constant force does not step over an event") {
  // A second-order formula is exact for x = a t^2 / 2, so only the longest step of the event search limits the step.
  Scene scene = conductor_scene({{0.02, 0.05}});
  scene.effects.remove<effects::StokesDragOptions>();
  auto field = std::make_unique<effects::FloatingConductors>(scene, no_forces());
  const effects::ExtrapolatedField held{.force = {{mass, 0}}, .force_rate = {{}}};
  field->follow(held);
  Model model = effects::make_model(scene, effects::made(std::move(field)));
  Cvode cvode = make_cvode(scene, model);
  Events events;
  const auto x = [&] { return position(model.bodies, 0).x; };
  events.direction = {-1};
  events.values = [&](std::span<double> value) { value[0] = std::abs(x() - 0.05) - 1e-4; };
  events.longest_step = [&](std::span<const double> force) {
    return time_to_move(std::max(2e-4, std::abs(x() - 0.05) - 1e-4), velocity(model.bodies, 0).x, force[0] / mass);
  };
  CHECK(cvode.advance(0, 1, events) == near(std::sqrt(2 * 0.0299), 1e-6));
}

TEST_CASE("cvode: an integration ends at the first event in the given direction") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.conductors[0].velocity = {1, 0};
  Model model = effects::make_model(scene);
  Cvode cvode(model, {.relative = 1e-8, .position = 1e-12, .momentum = {1e-15}});
  Events events;
  const auto beyond = [&](double x) { return position(model.bodies, 0).x - x; };
  events.direction = {-1, +1, +1};
  events.values = [&](std::span<double> value) {
    value[0] = beyond(0.055);  // This value rises, but its event requires a fall.
    value[1] = beyond(0.07);
    value[2] = beyond(0.06);
  };
  CHECK(cvode.advance(0, 1, events) == near(0.01, 1e-9));
  CHECK(position(model.bodies, 0).x == near(0.06, 1e-9));
  CHECK(beyond(0.06) >= 0);
  CHECK(cvode.advance(0.01, 0.015, events) == 0.015);
}

TEST_CASE("cvode: an interval as short as a rounding error is skipped") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.conductors[0].velocity = {1, 0};
  Model model = effects::make_model(scene);
  Cvode cvode(model, {.relative = 1e-8, .position = 1e-12, .momentum = {1e-15}});
  const double start = 11 * 0.03, end = 0.33;  // An event just before the end leaves such an interval.
  REQUIRE(start < end);
  CHECK(cvode.advance(start, end) == end);
  CHECK(position(model.bodies, 0).x == 0.05);
}

TEST_CASE("cvode: a tolerance below rounding is refused with its scene key") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.conductors[0].velocity = {1, 0};
  Model model = effects::make_model(scene);
  // A position of 0.05 is rounded by 1.1e-17. CVODE refuses tolerances below its epsilon of the position, 1.1e-17.
  Cvode cvode(model, {.relative = 1e-15, .position = 1e-18, .momentum = {1e-15}});
  const std::string sentence = message_of([&] { cvode.advance(0, 1); });
  CHECK_NE(sentence.find("mechanics.relative_tolerance = 1e-15 is below the rounding error"), std::string::npos);
  CHECK_EQ(sentence.find("CVODE"), std::string::npos);
}

TEST_CASE("monolithic coupling: field failures are errors only at accepted states") {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.mechanics.coupling = FieldCoupling::monolithic;
  int solves = 0;
  Simulation once(scene, scripted([&](const auto&) -> std::vector<Vec2> {
                    if (++solves == 5) throw Failure("here is no field");
                    return {{1e-5, 0}};
                  }));
  CHECK_NOTHROW(once.advance_to(0.1));
  scene.conductors[0].velocity = {100, 0};
  Simulation out(scene, no_forces());
  CHECK_THROWS_WITH_AS(out.advance_to(0.1), doctest::Contains("conductor 0 has left the domain"), Failure);
}

TEST_CASE("monolithic coupling: an exception while integrating is passed on") {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.mechanics.coupling = FieldCoupling::monolithic;
  int solves = 0;
  Simulation simulation(scene, scripted([&](const auto&) -> std::vector<Vec2> {
                          if (++solves > 5) throw Failure("the field solver gave up");
                          return {{1e-5, 0}};
                        }));
  CHECK_THROWS_WITH_AS(simulation.advance_to(0.1), "the field solver gave up", Failure);
}

// ---- Euler

TEST_CASE("Euler: explicit steps of euler_step, a field solve per euler_field_step") {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.mechanics.integrator = Integrator::euler;
  scene.conductors[0].velocity = {0.1, 0};
  int solves = 0;
  Simulation simulation(scene, scripted([&](const auto&) {
                          ++solves;
                          return std::vector<Vec2>{{0, 0}};
                        }));
  simulation.advance_to(0.01);
  // v_n = v_0 (1 - dt/tau)^n and x_n = x_0 + dt * sum of v_k, over 1000 steps with rounding only.
  const double q = 1 - 1e-5 / relaxation, decayed = std::pow(q, 1000);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.velocity[0].x == near(0.1 * decayed, 1e-10));
  CHECK(frame.position[0].x - 0.05 == near(0.1 * 1e-5 * (1 - decayed) / (1 - q), 1e-9));
  CHECK(solves == 11);  // One solve at the first instant and one per millisecond.
}

TEST_CASE("Euler: its difference from CVODE is proportional to the step") {
  Scene scene = conductor_scene({{0.048, 0.05}, {0.053, 0.051}, {0.05, 0.0545}});
  scene.conductors[0].charge = 1.5e-10, scene.conductors[1].charge = -1e-10, scene.conductors[2].charge = 1.25e-10;
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.mechanics.coupling = FieldCoupling::monolithic;
  const auto run = [&](Integrator integrator, double step) {
    scene.mechanics.integrator = integrator;
    scene.mechanics.euler_step = 0.01 * step;
    scene.mechanics.euler_field_step = step;
    Simulation simulation(scene, std::make_unique<LineCharges>());
    simulation.advance_to(0.2);
    return simulation.now();
  };
  const ConductorFrame reference = run(Integrator::cvode, 0);
  const double coarse = largest_distance(run(Integrator::euler, 4e-3), reference);
  const double fine = largest_distance(run(Integrator::euler, 1e-3), reference);
  CHECK(coarse > 1e-7);
  CHECK(coarse / fine == near(4, 0.1));  // First order; the next term is smaller by step * force rate = 0.01.
}

// ---- coupling

TEST_CASE("split coupling: converges to monolithic coupling with second order") {
  Scene scene = conductor_scene({{0.048, 0.05}, {0.053, 0.051}, {0.05, 0.0545}, {0.0458, 0.0463}});
  const double charges[] = {1.5e-10, -1e-10, 1.25e-10, -1e-10};
  for (int i = 0; i < 4; ++i) scene.conductors[i].charge = charges[i];
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.mechanics.relative_tolerance = 1e-9;
  const auto run = [&](FieldCoupling coupling, double step) {
    scene.mechanics.coupling = coupling;
    scene.mechanics.largest_step = step;
    scene.mechanics.position_tolerance = 1;  // Every step is accepted.
    Simulation simulation(scene, std::make_unique<LineCharges>());
    simulation.advance_to(0.32);
    return simulation.now();
  };
  const ConductorFrame reference = run(FieldCoupling::monolithic, 0.01);
  const double e1 = largest_distance(run(FieldCoupling::split, 0.04), reference);
  const double e2 = largest_distance(run(FieldCoupling::split, 0.02), reference);
  const double e4 = largest_distance(run(FieldCoupling::split, 0.01), reference);
  CHECK(e1 > 1e-8);  // The integrator's error is 1e-9 of a radius per step.
  CHECK(e1 < 1e-7);  // Without the defect correction the error would exceed this bound.
  // The first step has a constant force and also an error of H^2; the remaining terms are not negligible yet.
  CHECK(std::log2(e1 / e2) == near(2, 0.2));
  CHECK(std::log2(e2 / e4) == near(2, 0.15));
}

TEST_CASE("split coupling: position tolerance kept, below 1/5 of monolithic solves") {
  Scene scene = conductor_scene({{0.048, 0.05}, {0.053, 0.051}, {0.05, 0.0545}});
  scene.conductors[0].charge = 1.5e-10, scene.conductors[1].charge = -1e-10, scene.conductors[2].charge = 1.25e-10;
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.mechanics.relative_tolerance = 1e-9;
  const auto run = [&](FieldCoupling coupling, double tolerance) {
    scene.mechanics.coupling = coupling;
    scene.mechanics.position_tolerance = tolerance;
    Simulation simulation(scene, std::make_unique<LineCharges>());
    simulation.advance_to(0.3);
    return simulation.now();
  };
  const ConductorFrame reference = run(FieldCoupling::monolithic, 1e-6);
  const ConductorFrame coarse = run(FieldCoupling::split, 1e-6), fine = run(FieldCoupling::split, 1e-8);
  // The tolerance bounds a step's error before the defect correction. The errors that remain after some tens of steps
  // are smaller.
  CHECK(largest_distance(coarse, reference) < 1e-6);
  CHECK(largest_distance(fine, reference) < 1e-8);
  CHECK(largest_distance(fine, reference) < largest_distance(coarse, reference));
  CHECK(5 * coarse.field_solves < reference.field_solves);
}

TEST_CASE("split coupling, trap 100 times faster than a step: body comes to rest") {
  // The trap's time is 1 ms with drag, and steps are up to 0.1 s. Extrapolation alone would oscillate and diverge.
  Scene scene = conductor_scene({{0.05, 0.05}});
  const double stiffness = 1000 * drag;
  Simulation simulation(scene, scripted([&](const laplace::LaplaceProblem& problem) {
                          return std::vector<Vec2>{-stiffness * (centre(problem, 0) - Vec2{0.051, 0.05})};
                        }));
  simulation.advance_to(1);
  const ConductorFrame frame = simulation.now();
  CHECK(norm(frame.position[0] - Vec3{0.051, 0.05, 0}) < 2 * scene.mechanics.position_tolerance);
  CHECK(frame.field_solves < 3000);
}

// ---- effects that the scene requests

TEST_CASE("scene without charges: no field, no charge columns, no PETSc") {
  Scene scene = scene_of({{0.03, 0.05}, {0.05, 0.05}});
  scene.effects.add<effects::StokesDragOptions>();
  scene.conductors[0].velocity = {0.01, 0};
  Simulation simulation(scene);
  simulation.advance_to(0.1);
  const ConductorFrame frame = simulation.now();
  CHECK(frame.charge.empty());
  CHECK(frame.potential.empty());
  CHECK(frame.force.empty());
  CHECK(frame.group.empty());
  CHECK(simulation.counters().field_solves == 0);
  CHECK(!simulation.model().neighbours);
  CHECK(!simulation.stationary());
  CHECK_FALSE(simulation.field());
  CHECK(!parallel::petsc_started());
}

TEST_CASE("leakage: costs no extra field solves and exerts no force") {
  Scene scene = conductor_scene({{0.03, 0.05}, {0.05, 0.05}});
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.effects.add(effects::LeakageOptions{.conductivity = 1e-12});
  const auto log = std::make_shared<SolverLog>();
  Simulation simulation(scene, std::make_unique<LineCharges>(log));
  Model model = effects::make_model(scene);
  CHECK(model.effects.back()->name() == "leakage");
  CHECK(mechanics::FreeFlight(model).interacting(std::vector{1.0, 1.0}).empty());
  simulation.advance_to(1);
  CHECK(log->solves == 11);
  // The fluid is an insulator and all potentials are equal: there is no circuit and no energy budget.
  scene.effects.remove<effects::LeakageOptions>();
  Simulation without(scene, std::make_unique<LineCharges>());
  without.advance_to(0.1);
  CHECK_FALSE(without.now().energy_balance);
  CHECK(without.now().charge_leaked == 0);
}

TEST_CASE("scene without contact_discharge: no contact search, one solve per step") {
  Scene scene = conductor_scene({{0.03, 0.05}, {0.05, 0.05}});
  scene.effects.remove<effects::ContactDischargeOptions>();
  const auto log = std::make_shared<SolverLog>();
  Simulation simulation(scene, std::make_unique<LineCharges>(log));
  CHECK(log->solves == 0);
  simulation.advance_to(1);
  CHECK(log->solves == 11);  // One solve at the first instant and one per largest step of 0.1 s; all charges are zero.
  simulation.now();
  simulation.stationary();
  CHECK(log->solves == 11);
  CHECK(simulation.counters().field_solves == 11);
  CHECK(simulation.counters().contact_seconds == 0);
  CHECK(!simulation.model().neighbours);
}

}  // namespace mechanics_test
