#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "solvers/error.hpp"
#include "solvers/geometry/closed_curve.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/gravity.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/field_methods/field_method.hpp"
#include "tests/conductors.hpp"
#include "tests/line_charges.hpp"

namespace effects_test {

using namespace lichtenberg;
using namespace lichtenberg::conductors;
using namespace lichtenberg::effects;
using std::numbers::pi;

namespace {

std::vector<double> forces_of(const Effect& effect, const Bodies& bodies, const std::vector<Pair>& pairs = {}) {
  std::vector<double> force(bodies.position.size());
  effect.add_forces({0, bodies, pairs}, force);
  return force;
}

/// Largest difference between analytic derivatives and central differences of the forces, relative to the largest
/// derivative.
double jacobian_error(const Effect& effect, Bodies bodies, double step, const std::vector<Pair>& pairs = {}) {
  const std::size_t n = bodies.position.size();
  ForceJacobian jacobian(bodies.dimension);
  effect.add_jacobian({0, bodies, pairs}, jacobian);
  std::vector<double> analytic(n * n);
  for (const auto& entry : jacobian.by_position) analytic[entry.row * n + entry.column] += entry.value;
  double worst = 0, largest = 0;
  for (std::size_t column = 0; column < n; ++column) {
    const double middle = bodies.position[column];
    bodies.position[column] = middle + step;
    const std::vector<double> above = forces_of(effect, bodies, pairs);
    bodies.position[column] = middle - step;
    const std::vector<double> below = forces_of(effect, bodies, pairs);
    bodies.position[column] = middle;
    for (std::size_t row = 0; row < n; ++row) {
      const double difference = (above[row] - below[row]) / (2 * step);
      worst = std::max(worst, std::abs(difference - analytic[row * n + column]));
      largest = std::max(largest, std::abs(difference));
    }
  }
  REQUIRE(largest > 0);
  return worst / largest;
}

}  // namespace

TEST_CASE("surface_of: distance, normal and curvature of plane shapes") {
  const ClosedCurve ellipse = make_ellipse({0.02, 0.015}, {0.008, 0.003}, 0.4, false);
  const ClosedCurve triangle = make_polygon(std::vector<Vec2>{{0.01, 0.01}, {0.03, 0.012}, {0.018, 0.022}}, 0, false);
  const std::vector<Shape> shapes = {Disk{{0.01, 0.02}, 0.003}, Ring{{0.02, 0.02}, 0.02},
                                     Bar{{0.01, 0.01}, {0.03, 0.02}, 0.004}, Freeform{&ellipse}, Freeform{&triangle}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(0.005, 0.035);
  for (const Shape& shape : shapes)
    for (int trial = 0; trial < 50; ++trial) {
      const Vec2 p = {coordinate(random), coordinate(random)};
      const View seen = view(surface_of(shape), in_space(p));
      CHECK(seen.distance == near(signed_distance(shape, p)));
      if (seen.distance < 1e-4) continue;  // The medial axis, where the gradient jumps, is inside.
      const double h = 1e-8;
      const Vec2 gradient = {
          (signed_distance(shape, p + Vec2{h, 0}) - signed_distance(shape, p - Vec2{h, 0})) / (2 * h),
          (signed_distance(shape, p + Vec2{0, h}) - signed_distance(shape, p - Vec2{0, h})) / (2 * h)};
      CHECK(norm(in_space(gradient) - seen.normal) < 1e-6);  // Rounding: 1e-2 * 1e-16 / 1e-8.
      const Vec2 side = perpendicular(plane(seen.normal));
      const Vec2 turned = plane(view(surface_of(shape), in_space(p + h * side)).normal - seen.normal);
      // Relative to the largest curvature, 1 / 0.1 mm.
      CHECK(std::abs(dot(turned, side) / h - seen.turning) < 1e-5 / 1e-4);
    }
}

TEST_CASE("sides_of: distances and inward normals of the domain's four sides") {
  const auto sides = sides_of({.size = {3, 2}, .sides = {}});
  REQUIRE(sides.size() == 4);
  const Vec3 p = {0.5, 0.25, 0};
  const std::vector<double> distance = {0.5, 2.5, 0.25, 1.75};  // Left, right, bottom, top.
  for (int s = 0; s < 4; ++s) CHECK(view(sides[s], p).distance == distance[s]);
  CHECK(view(sides[0], p).normal == Vec3{1, 0, 0});
  CHECK(view(sides[3], p).normal == Vec3{0, -1, 0});
}

TEST_CASE("HertzContact: known force between two steel spheres") {
  // E* = 200e9 / (2 * 0.91) = 1.0989e11 Pa, R_eff = 1 mm / 2, overlap 1 um: F = 4/3 * 1.0989e11 * sqrt(5e-4) * 1e-9 =
  // 3.27629 N.
  Bodies bodies{.position = {0, 0, 2 * radius - 1e-6, 0}, .mass = {1, 1}, .radius = {radius, radius}};
  const effects::HertzContact hertz({.young = 200e9, .poisson = 0.3});
  const std::vector<double> force = forces_of(hertz, bodies, {{0, 1}});
  CHECK(force[0] == near(-3.27629, 1e-5));
  CHECK(force[2] == -force[0]);
  CHECK(force[1] == 0);
  bodies.position[2] = 2 * radius;
  CHECK(forces_of(hertz, bodies, {{0, 1}}) == std::vector<double>(4, 0.0));
}

TEST_CASE("HertzContact: Jacobian agrees with central differences in 2D and 3D") {
  // Steps of 1e-10 m in an overlap of about 1e-5: truncation (1e-5)^2 / 8, rounding 1e-18 / 1e-10 of 1e-5.
  const effects::HertzContact hertz({.young = 1e9, .poisson = 0.3});
  Bodies plane{.position = {0, 0, 1.5e-3, 1.3e-3, -1.2e-3, 1.55e-3}, .mass = {1, 1, 1}, .radius = {1e-3, 1e-3, 1e-3}};
  CHECK(jacobian_error(hertz, plane, 1e-10, {{0, 1}, {0, 2}, {1, 2}}) < 1e-6);
  Bodies space{.dimension = 3, .position = {0, 0, 0, 1e-3, 1.2e-3, 1.2e-3}, .mass = {1, 1}, .radius = {1e-3, 1e-3}};
  CHECK(jacobian_error(hertz, space, 1e-10, {{0, 1}}) < 1e-6);
}

TEST_CASE("HertzContact and WallContact: overlap above one radius throws Failure") {
  Bodies bodies{.position = {0, 0, 1.01 * radius, 0}, .mass = {1, 1}, .radius = {radius, radius}};
  const effects::HertzContact hertz({.young = 1e6, .poisson = 0.3});
  CHECK_NOTHROW(forces_of(hertz, bodies, {{0, 1}}));
  bodies.position[2] = 0.99 * radius;
  CHECK_THROWS_WITH_AS(forces_of(hertz, bodies, {{0, 1}}), doctest::Contains("conductors 0 and 1 overlap by 0.00101 m"),
                       Failure);
  Scene scene = scene_of({{1e-6, 0.05}});
  scene.effects.add<effects::WallContactOptions>();
  const effects::WallContact walls(scene);
  CHECK_NOTHROW(forces_of(walls, make_bodies(scene)));
  scene.conductors[0].position.x = -1e-6;
  CHECK_THROWS_AS(forces_of(walls, make_bodies(scene)), Failure);
}

TEST_CASE("WallContact: normal force with the effective radius of both surfaces") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.effects.add<effects::WallContactOptions>();
  const auto force_at = [&](Vec2 p) {
    Bodies bodies = make_bodies(scene);
    bodies.position = {p.x, p.y};
    const std::vector<double> force = forces_of(effects::WallContact(scene), bodies);
    return Vec2{force[0], force[1]};
  };
  const double overlap = 1e-6;
  // Between equal spheres R_eff = R/2, as above: 3.27629 N. At a flat wall R_eff = R: sqrt(2) times that.
  const double flat = 3.27629 * std::sqrt(2.0);
  CHECK(norm(force_at({0.05, 0.05})) == 0);
  CHECK(force_at({radius - overlap, 0.05}).x == near(flat, 1e-5));
  CHECK(force_at({0.1 - radius + overlap, 0.05}).x == near(-flat, 1e-5));
  CHECK(force_at({0.05, 0.1 - radius + overlap}).y == near(-flat, 1e-5));

  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  CHECK(force_at({0.05 - 2 * radius + overlap, 0.05}).x == near(-3.27629, 1e-5));
  scene.electrodes = {electrode_of("bar", Bar{{0.04, 0.05}, {0.06, 0.05}, 0.01}, 0)};
  CHECK(force_at({0.05, 0.055 + radius - overlap}).y == near(flat, 1e-5));
  const double diagonal = std::sqrt(0.5) * (radius - overlap);
  CHECK(norm(force_at({0.06 + diagonal, 0.055 + diagonal}) - std::sqrt(0.5) * flat * Vec2{1, 1}) < 1e-4 * flat);

  // Inside a ring of 5 mm the curvatures subtract: 1/R_eff = 1/R - 1/5R, R_eff = 5/4 R. The force points inward.
  scene.electrodes = {electrode_of("ring", Ring{{0.05, 0.05}, 5 * radius}, 0)};
  const Vec2 inward = force_at({0.05 + 4 * radius + overlap, 0.05});
  CHECK(inward.x == near(-flat * std::sqrt(1.25), 1e-5));
  CHECK(inward.y == 0);
}

TEST_CASE("WallContact: different materials give the combined modulus") {
  // 1/E* = 0.96 / 4 MPa + 0.96 / 6 MPa = 1 / 2.5 MPa; F = 4/3 E* sqrt(R_eff) overlap^(3/2).
  Scene scene = scene_of({{0.05, 0.05}});
  scene.effects.add(effects::WallContactOptions{.young = 6e6, .poisson = 0.2});
  const double overlap = 1e-5;
  const auto force_at = [&](Vec2 p) {
    Bodies bodies = make_bodies(scene);
    bodies.position = {p.x, p.y};
    return forces_of(effects::WallContact(scene), bodies)[0];
  };
  const auto force = [&](double modulus, double effective) {
    return 4.0 / 3 * modulus * std::sqrt(effective) * std::pow(overlap, 1.5);
  };
  CHECK(force_at({radius - overlap, 0.05}) == near(force(6e6 / 1.92, radius), 1e-9));  // Both of one material.
  scene.effects.add(effects::HertzContactOptions{.young = 4e6, .poisson = 0.2});
  CHECK(force_at({radius - overlap, 0.05}) == near(force(2.5e6, radius), 1e-9));
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  CHECK(force_at({0.05 - 2 * radius + overlap, 0.05}) == near(-force(2.5e6, radius / 2), 1e-9));
  scene.effects.add(effects::HertzContactOptions{.young = 6e6, .poisson = 0.2});
  scene.electrodes.clear();
  CHECK(force_at({radius - overlap, 0.05}) == near(force(6e6 / 1.92, radius), 1e-9));
}

TEST_CASE("HertzContact: pairs of different materials have the combined modulus") {
  // 1/E* = 0.96 / 4 MPa + 0.96 / 6 MPa = 1 / 2.5 MPa.
  const effects::Elasticity soft{4e6, 0.2}, hard{6e6, 0.2};
  const effects::HertzContact hertz({.young = 4e6, .poisson = 0.2, .bodies = {soft, hard, hard}});
  const double overlap = 1e-5, step = 2 * radius - overlap;
  const Bodies bodies{.position = {0, 0, step, 0, 2 * step, 0}, .mass = {1, 1, 1}, .radius = {radius, radius, radius}};
  const auto force = [&](double modulus) { return 4.0 / 3 * modulus * std::sqrt(radius / 2) * std::pow(overlap, 1.5); };
  const std::vector<double> found = forces_of(hertz, bodies, {{0, 1}, {1, 2}});
  CHECK(found[0] == near(-force(2.5e6), 1e-9));
  CHECK(found[4] == near(force(6e6 / 1.92), 1e-9));
  CHECK(std::abs(found[0] + found[2] + found[4]) < 1e-12 * found[4]);
  Bodies plane{.position = {0, 0, 1.5e-3, 1.3e-3, -1.2e-3, 1.55e-3}, .mass = {1, 1, 1}, .radius = {1e-3, 1e-3, 1e-3}};
  Bodies pierced = bodies;
  pierced.position[2] = 0;  // The centres of the first two coincide.
  CHECK_THROWS_WITH_AS(forces_of(hertz, pierced, {{0, 1}, {1, 2}}), doctest::Contains("conductors 0 and 1 overlap"),
                       Failure);
  pierced.position[2] = 0.9 * radius;
  CHECK_THROWS_AS(forces_of(hertz, pierced, {{0, 1}}), Failure);
  const effects::HertzContact stiff({.young = 1e9, .bodies = {{1e9, 0.3}, {3e9, 0.2}, {2e9, 0.1}}});
  CHECK(jacobian_error(stiff, plane, 1e-10, {{0, 1}, {0, 2}, {1, 2}}) < 1e-6);
}

TEST_CASE("HertzContact: a collision of different materials lasts Hertz's time") {
  // The largest overlap is (15 m* v^2 / (16 sqrt(R*) E*))^(2/5). The duration is that over v, times 4/5 sqrt(pi) G(2/5)
  // / G(9/10).
  const double v = 0.1, mass = 1e-3, modulus = 2.5e6;
  const double deepest = std::pow(15 * (mass / 2) * v * v / (16 * std::sqrt(radius / 2) * modulus), 0.4);
  const double expected = 0.8 * std::sqrt(pi) * std::tgamma(0.4) / std::tgamma(0.9) * deepest / v;
  const effects::Elasticity soft{4e6, 0.2}, hard{6e6, 0.2};
  for (const auto& materials : {std::vector{soft, hard}, std::vector{hard, soft}}) {
    const effects::HertzContact hertz({.bodies = materials});
    Bodies bodies{.position = {0, 0, 2 * radius, 0}, .mass = {mass, mass}, .radius = {radius, radius}};
    double time = 0, speed = v, lowest_speed = v;  // Speed of approach.
    for (const double dt = 1e-4 * expected; bodies.position[2] - bodies.position[0] <= 2 * radius; time += dt) {
      speed -= dt / mass * (forces_of(hertz, bodies, {{0, 1}})[2] - forces_of(hertz, bodies, {{0, 1}})[0]);
      bodies.position[2] -= dt * speed;
      lowest_speed = std::min(lowest_speed, speed);
    }
    CHECK(time == near(expected, 1e-3));  // Ten steps.
    CHECK(lowest_speed == near(-v, 1e-3));
  }
}

TEST_CASE("WallContact: each body contributes the modulus of its own material") {
  Scene scene = scene_of({{0.05, 0.05}, {0.05, 0.02}});
  const double overlap = 1e-5;
  const auto forces = [&] {
    Bodies bodies = make_bodies(scene);
    bodies.position = {radius - overlap, 0.05, radius - overlap, 0.02};
    return forces_of(effects::WallContact(scene), bodies);
  };
  const auto force = [&](double modulus) { return 4.0 / 3 * modulus * std::sqrt(radius) * std::pow(overlap, 1.5); };
  scene.effects.add(effects::WallContactOptions{.young = 6e6, .poisson = 0.2, .bodies = {{4e6, 0.2}, {6e6, 0.2}}});
  CHECK(forces()[0] == near(force(2.5e6), 1e-9));
  CHECK(forces()[2] == near(force(6e6 / 1.92), 1e-9));
}

TEST_CASE("WallContact: cached gaps give the forces of a new search") {
  // One body crosses the box repeatedly past a ball and returns at once; the other rises from the bottom and returns.
  Scene scene = scene_of({{0.05, 0.05}, {0.08, 0.05}});
  scene.effects.add<effects::WallContactOptions>();
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.02}, 2 * radius}, 0)};
  const effects::WallContact walls(scene);
  Bodies bodies = make_bodies(scene);
  int pushed = 0;
  for (int step = 0; step < 1000; ++step) {
    const double across = std::fmod(0.1 * radius * step, 0.1);
    bodies.position = {std::clamp(across, 0.9 * radius, 0.1 - 0.9 * radius), 0.02 - 2.9 * radius, 0.08,
                       0.9 * radius + 0.04 * std::abs(std::sin(0.05 * step))};
    const std::vector<double> force = forces_of(walls, bodies);
    CHECK(force == forces_of(effects::WallContact(scene), bodies));
    pushed += std::ranges::any_of(force, [](double f) { return f != 0; });
    const std::vector<double> travel = {0.3 * radius, 0};
    std::vector<bool> marked(2), fresh(2);
    walls.mark_interacting(bodies, travel, marked);
    effects::WallContact(scene).mark_interacting(bodies, travel, fresh);
    CHECK(marked == fresh);
  }
  CHECK(pushed > 20);
}

TEST_CASE("WallContact: Jacobian agrees with central differences") {
  // A side, a ball, a ring from inside, and a bar's face and corner, with overlaps of about 10 um as for the spheres.
  const Shape nothing = Disk{{0.09, 0.09}, 1e-3}, ball = Disk{{0.05, 0.05}, 2e-3}, ring = Ring{{0.05, 0.05}, 8e-3},
              bar = Bar{{0.02, 0.02}, {0.03, 0.02}, 2e-3};
  for (const auto& [shape, p] : {std::pair{nothing, Vec2{0.99e-3, 0.06}}, std::pair{ball, Vec2{0.0521, 0.0521}},
                                 std::pair{ring, Vec2{0.0532, 0.05626}}, std::pair{bar, Vec2{0.025, 0.02199}},
                                 std::pair{bar, Vec2{0.0307, 0.0217}}}) {
    Scene scene = scene_of({p});
    scene.effects.add(effects::WallContactOptions{.young = 1e9, .poisson = 0.3});
    scene.electrodes = {electrode_of("wall", shape, 0)};
    CHECK(jacobian_error(effects::WallContact(scene), make_bodies(scene), 1e-10) < 1e-5);
  }
}

TEST_CASE("Stokes drag: force and derivative follow 6 pi viscosity R") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.conductors[0].radius = 0.775e-3;
  scene.effects.add<effects::StokesDragOptions>();
  Model model = effects::make_model(scene);
  // 6 pi * 0.7 * 0.775e-3 = 1.022588e-2 kg/s.
  CHECK(model.drag.linear()[0] == near(1.022588e-2, 1e-6));
  CHECK(model.drag.is_linear());
  const double mass = model.bodies.mass[0];
  model.bodies.momentum = {0.2 * mass, -0.1 * mass};
  std::vector<double> force(2);
  model.forces(0, force);
  CHECK(force[0] == near(-1.022588e-2 * 0.2, 1e-6));
  CHECK(force[1] == near(1.022588e-2 * 0.1, 1e-6));
  ForceJacobian jacobian(2);
  model.jacobian(0, jacobian);
  REQUIRE(jacobian.by_momentum.size() == 2);
  CHECK(jacobian.by_momentum[1].value * model.bodies.momentum[1] == near(force[1]));
}

TEST_CASE("make_laplace_problem: bodies, groups, charge per depth, sides of a scene") {
  Scene scene = scene_of({{0.01, 0.01}, {0.02, 0.01}, {0.03, 0.01}, {0.04, 0.01}});
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, 1e-3}, 7)};
  scene.domain.sides[1] = {.electrode = true, .potential = 2};
  const Bodies bodies = make_bodies(scene);
  const std::vector<Contact> contacts = {{0, 2}, {3, 4}};
  const laplace::LaplaceProblem problem =
      make_laplace_problem(scene, bodies, electrical_groups(scene, contacts), {.charge = {1e-12, 2e-12, 4e-12, 8e-12}});
  problem.check();
  REQUIRE(problem.bodies.size() == 5);
  REQUIRE(problem.groups.size() == 4);
  CHECK(problem.bodies[0].group == problem.bodies[2].group);
  CHECK(problem.groups[0].charge == near(5e-12 / (2 * radius)));
  CHECK(problem.groups[1].charge == near(2e-12 / (2 * radius)));
  CHECK(!problem.groups[problem.bodies[3].group].floating);
  CHECK(problem.groups[problem.bodies[3].group].potential == 7);
  CHECK(problem.groups[problem.bodies[4].group].potential == 7);
  CHECK(problem.permittivity == 4e-11);
  CHECK(problem.sides[0].kind == laplace::Side::Kind::insulating);
  CHECK(problem.sides[1].kind == laplace::Side::Kind::electrode);
  CHECK(problem.sides[1].potential == 2);
}

TEST_CASE("FloatingConductors: SI force, charge, energy are plane value times depth") {
  // Two line charges q at distance d repel with q^2 / (2 pi eps d) per metre.
  Scene scene = scene_of({{0.04, 0.05}, {0.05, 0.05}});
  auto log = std::make_shared<SolverLog>();
  effects::FloatingConductors field(scene, std::make_unique<LineCharges>(log));
  Bodies bodies = make_bodies(scene);
  const Electrostatics found = field.solve(bodies, electrical_groups(scene, {}), {.charge = {1e-10, 1e-10}});
  const double depth = 2 * radius, q = 1e-10 / depth;
  CHECK(found.force[1].x == near(depth * q * q / (2 * pi * 4e-11 * 0.01)));
  CHECK(found.charge[0] == near(1e-10));
  CHECK(found.potential[0] == near(q / (2 * pi * 4e-11) * (std::log(0.1 / radius) + std::log(10))));
  CHECK(found.energy == near(0.5 * 1e-10 * (found.potential[0] + found.potential[1])));
  CHECK(field.solves() == 1);
  CHECK(field.iterations() == 1);

  const ExtrapolatedField held{.time = 2.0, .force = {{1, 2}, {3, 4}}, .force_rate = {{0.5, 0}, {0, -0.5}}};
  field.follow(held);
  std::vector<double> force(4);
  field.add_forces({4.0, bodies, {}}, force);
  CHECK(force == std::vector<double>{2, 2, 3, 3});
  CHECK(log->solves == 1);  // Constant forces need no solve.
}

TEST_CASE("make_field_solver: returns the solver of the scene's field method") {
  CHECK(dynamic_cast<laplace::CutCellSolver*>(make_field_solver({.method = &cut_cell_method()}).get()));
  CHECK(dynamic_cast<laplace::RelaxationSolver*>(make_field_solver({.method = &relaxation_method()}).get()));
  CHECK(dynamic_cast<laplace::MultipoleSolver*>(make_field_solver({.method = &multipole_method()}).get()));
  CHECK_THROWS_AS(make_field_solver({.method = &multipole_method(), .device = FieldDevice::cuda}), InputError);
  CHECK_THROWS_AS(make_field_solver({.method = &relaxation_method(), .device = FieldDevice::cuda}), InputError);
}

TEST_CASE("multipole method: a model without Hertz or wall contacts is refused") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.03}});
  scene.field().method = &multipole_method();
  CHECK_THROWS_AS(make_model(scene), InputError);
  scene.effects.add<effects::HertzContactOptions>();
  CHECK_THROWS_AS(make_model(scene), InputError);
  scene.effects.add<effects::WallContactOptions>();
  CHECK_NOTHROW(make_model(scene));
}

TEST_CASE("overlap at different potentials: InputError at the start, Failure later") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.02}});
  scene.effects.remove<effects::ContactDischargeOptions>();
  scene.domain.sides[0] = {true, 0};
  effects::FloatingConductors field(scene, std::make_unique<LineCharges>(std::make_shared<SolverLog>()));
  Bodies bodies = make_bodies(scene);
  const effects::NodeCharges charges{.charge = {1e-10, 0}};
  const ElectricalGroups separate_groups = electrical_groups(scene, {});
  bodies.position[2] = 0.02 + 1.99 * radius;
  CHECK_THROWS_AS(field.solve(bodies, separate_groups, charges), InputError);  // The first instant.
  bodies.position[2] = 0.02 + 2.01 * radius;
  CHECK_NOTHROW(field.solve(bodies, separate_groups, charges));
  bodies.position[2] = 0.02 + 1.99 * radius;
  CHECK_THROWS_AS(field.solve(bodies, separate_groups, charges), Failure);
  CHECK_NOTHROW(field.solve(bodies, electrical_groups(scene, std::vector{Contact{0, 1}}), charges));
  bodies.position[2] = 0.99 * radius;  // In the left side, an electrode.
  CHECK_THROWS_AS(field.solve(bodies, separate_groups, charges), Failure);
}

TEST_CASE("make_model: has the effects of the scene's tables and no others") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.03}});
  scene.effects = {};
  const Model nothing = make_model(scene);
  CHECK(nothing.effects.empty());
  CHECK(nothing.bodies.charge.empty());
  CHECK(!nothing.neighbours);

  scene.effects.add<effects::StokesDragOptions>();
  scene.effects.add<effects::HertzContactOptions>();
  const Model neutral = make_model(scene);
  CHECK(neutral.effects.size() == 2);
  CHECK(neutral.effects[0]->name() == "stokes_drag");
  CHECK(neutral.effects[1]->name() == "hertz_contact");
  CHECK(neutral.bodies.charge.empty());
  CHECK(neutral.neighbours);

  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add<effects::CurrentInjectionOptions>();
  scene.effects.add<effects::WallContactOptions>();
  scene.effects.add<effects::ContactDischargeOptions>();
  const Model all = make_model(scene);
  CHECK(all.effects.size() == 6);
  CHECK(all.bodies.charge == std::vector<double>{0, 0});
  CHECK(!parallel::petsc_started());  // PETSc starts with the first solve.
}

TEST_CASE("summarize_effects: lists description, presence and needs of each effect") {
  Scene scene = scene_of({{0.02, 0.02}});
  scene.effects = {};
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add<effects::ContactDischargeOptions>();
  for (const EffectSummary& effect : summarize_effects(scene)) {
    CHECK(!effect.description.empty());
    CHECK(effect.in_scene == (effect.name == "hertz_contact" || effect.name == "contact_discharge"));
    CHECK(effect.needs.field == (effect.name == "contact_discharge"));
    CHECK(effect.needs.neighbour_range.has_value() == (effect.name == "hertz_contact"));
  }
  // No scene may combine all of them, but the list does not check this.
  scene.effects = {};
  for (const EffectKind* kind : effects::all_kinds())
    if (!kind->grains) scene.effects.add(*kind, kind->options);
  scene.effects.find<effects::LeakageOptions>()->conductivity = 1e-12;
  scene.effects.find<effects::ContactResistanceOptions>()->resistance = 1;
  const Model model = make_model(scene);
  const std::vector<EffectSummary> listed = summarize_effects(scene);
  REQUIRE(listed.size() == model.effects.size());
  for (std::size_t k = 0; k < listed.size(); ++k) CHECK(listed[k].name == model.effects[k]->name());
}

}  // namespace effects_test
