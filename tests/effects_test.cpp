#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/petsc.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "src/effects/charge_ledger.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/current_source.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "tests/line_charges.hpp"

using namespace lichtenberg;
using namespace lichtenberg::effects;
using std::numbers::pi;

namespace {

/// Equal within a fraction of the value. (doctest's own scale of 1 would let everything small pass.)
doctest::Approx near(double value, double tolerance = 1e-9) {
  return doctest::Approx(value).epsilon(tolerance).scale(0);
}

constexpr double radius = 1e-3;

/// Conductors of radius 1 mm in a box of 10 cm, contact at a gap of 1 mm.
Scene scene_of(std::vector<Vec2> places) {
  Scene scene;
  scene.domain.size = {0.1, 0.1};
  scene.medium = {.permittivity = 4e-11, .viscosity = 0.7, .depth = 2 * radius};
  for (const Vec2 place : places) scene.conductors.push_back({.position = place, .radius = radius});
  scene.effects.floating_conductors.emplace();
  scene.effects.contact_discharge = lichtenberg::ContactDischarge{.gap = radius, .hysteresis = 0.1};
  scene.mechanics.position_tolerance = 1e-6;
  return scene;
}

Electrode electrode_of(std::string name, Shape shape, double potential) { return {std::move(name), shape, potential}; }

std::vector<double> forces_of(const Effect& effect, const Bodies& bodies, const std::vector<Pair>& pairs = {}) {
  std::vector<double> force(bodies.position.size());
  effect.add_forces({0, bodies, pairs}, force);
  return force;
}

/// Largest difference between the analytic derivatives and central differences of the forces, as a fraction of the
/// largest derivative.
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

TEST_CASE("surfaces: distance as the field's geometry has it, its gradient, and how that turns") {
  const std::vector<Shape> shapes = {Disk{{0.01, 0.02}, 0.003}, Ring{{0.02, 0.02}, 0.02},
                                     Bar{{0.01, 0.01}, {0.03, 0.02}, 0.004}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.005, 0.035);
  for (const Shape& shape : shapes)
    for (int trial = 0; trial < 50; ++trial) {
      const Vec2 p = {place(random), place(random)};
      const View seen = view(surface_of(shape), p);
      CHECK(seen.distance == near(signed_distance(shape, p)));
      if (seen.distance < 1e-4) continue;  // the bar's medial axis, where the gradient jumps, is inside
      const double h = 1e-8;
      const Vec2 gradient = {
          (signed_distance(shape, p + Vec2{h, 0}) - signed_distance(shape, p - Vec2{h, 0})) / (2 * h),
          (signed_distance(shape, p + Vec2{0, h}) - signed_distance(shape, p - Vec2{0, h})) / (2 * h)};
      CHECK(norm(gradient - seen.normal) < 1e-6);  // rounding: 1e-2 * 1e-16 / 1e-8
      const Vec2 side = perpendicular(seen.normal);
      const Vec2 turned = view(surface_of(shape), p + h * side).normal - seen.normal;
      CHECK(std::abs(dot(turned, side) / h - seen.turning) < 1e-5 / 1e-4);  // of the largest, 1 / 0.1 mm
    }
}

TEST_CASE("surfaces: the sides of the domain look inward") {
  const auto sides = sides_of({.size = {3, 2}, .sides = {}});
  const Vec2 p = {0.5, 0.25};
  const std::vector<double> distance = {0.5, 2.5, 0.25, 1.75};  // left, right, bottom, top
  for (int s = 0; s < 4; ++s) CHECK(view(sides[s], p).distance == distance[s]);
  CHECK(view(sides[0], p).normal == Vec2{1, 0});
  CHECK(view(sides[3], p).normal == Vec2{0, -1});
}

TEST_CASE("Hertz: the force between two steel spheres") {
  // E* = 200e9 / (2 * 0.91) = 1.0989e11 Pa, R_eff = 1 mm / 2, overlap 1 um:
  // F = 4/3 * 1.0989e11 * sqrt(5e-4) * 1e-9 = 3.27629 N
  Bodies bodies{.position = {0, 0, 2 * radius - 1e-6, 0}, .mass = {1, 1}, .radius = {radius, radius}};
  const effects::HertzContact hertz({.young = 200e9, .poisson = 0.3});
  const std::vector<double> force = forces_of(hertz, bodies, {{0, 1}});
  CHECK(force[0] == near(-3.27629, 1e-5));
  CHECK(force[2] == -force[0]);
  CHECK(force[1] == 0);
  bodies.position[2] = 2 * radius;
  CHECK(forces_of(hertz, bodies, {{0, 1}}) == std::vector<double>(4, 0.0));
}

TEST_CASE("Hertz: derivatives agree with central differences, in two and three dimensions") {
  // Steps of 1e-10 m in an overlap of some 1e-5: truncation (1e-5)^2 / 8, rounding 1e-18 / 1e-10 of 1e-5.
  const effects::HertzContact hertz({.young = 1e9, .poisson = 0.3});
  Bodies plane{.position = {0, 0, 1.5e-3, 1.3e-3, -1.2e-3, 1.55e-3}, .mass = {1, 1, 1}, .radius = {1e-3, 1e-3, 1e-3}};
  CHECK(jacobian_error(hertz, plane, 1e-10, {{0, 1}, {0, 2}, {1, 2}}) < 1e-6);
  Bodies space{.dimension = 3, .position = {0, 0, 0, 1e-3, 1.2e-3, 1.2e-3}, .mass = {1, 1}, .radius = {1e-3, 1e-3}};
  CHECK(jacobian_error(hertz, space, 1e-10, {{0, 1}}) < 1e-6);
}

TEST_CASE("walls push along their normals, with the radius that both surfaces make") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.effects.wall_contact.emplace();
  const auto push_at = [&](Vec2 p) {
    Bodies bodies = make_bodies(scene);
    bodies.position = {p.x, p.y};
    const std::vector<double> force = forces_of(effects::WallContact(scene), bodies);
    return Vec2{force[0], force[1]};
  };
  const double overlap = 1e-6;
  // Between equal spheres R_eff = R/2, above: 3.27629 N. Against a flat wall R_eff = R: sqrt(2) times that.
  const double flat = 3.27629 * std::sqrt(2.0);
  CHECK(norm(push_at({0.05, 0.05})) == 0);
  CHECK(push_at({radius - overlap, 0.05}).x == near(flat, 1e-5));
  CHECK(push_at({0.1 - radius + overlap, 0.05}).x == near(-flat, 1e-5));
  CHECK(push_at({0.05, 0.1 - radius + overlap}).y == near(-flat, 1e-5));

  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  CHECK(push_at({0.05 - 2 * radius + overlap, 0.05}).x == near(-3.27629, 1e-5));
  scene.electrodes = {electrode_of("bar", Bar{{0.04, 0.05}, {0.06, 0.05}, 0.01}, 0)};
  CHECK(push_at({0.05, 0.055 + radius - overlap}).y == near(flat, 1e-5));
  const double diagonal = std::sqrt(0.5) * (radius - overlap);
  CHECK(norm(push_at({0.06 + diagonal, 0.055 + diagonal}) - std::sqrt(0.5) * flat * Vec2{1, 1}) < 1e-4 * flat);

  // Inside a ring of 5 mm the curvatures subtract: 1/R_eff = 1/R - 1/5R, R_eff = 5/4 R. It pushes inward.
  scene.electrodes = {electrode_of("ring", Ring{{0.05, 0.05}, 5 * radius}, 0)};
  const Vec2 inward = push_at({0.05 + 4 * radius + overlap, 0.05});
  CHECK(inward.x == near(-flat * std::sqrt(1.25), 1e-5));
  CHECK(inward.y == 0);
}

TEST_CASE("walls: derivatives agree with central differences") {
  Scene scene = scene_of({{0.05, 0.05}});
  scene.effects.wall_contact = lichtenberg::WallContact{.young = 1e9, .poisson = 0.3};
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, 2e-3}, 0),
                      electrode_of("ring", Ring{{0.05, 0.05}, 8e-3}, 0),
                      electrode_of("bar", Bar{{0.02, 0.02}, {0.03, 0.02}, 2e-3}, 0)};
  // In turn: side, ball, ring, the bar's face, its corner; overlaps of some 10 um as for the spheres.
  for (const Vec2 p :
       {Vec2{0.99e-3, 0.06}, Vec2{0.0521, 0.0521}, Vec2{0.0532, 0.05626}, Vec2{0.025, 0.02199}, Vec2{0.0307, 0.0217}}) {
    Bodies bodies = make_bodies(scene);
    bodies.position = {p.x, p.y};
    CHECK(jacobian_error(effects::WallContact(scene), bodies, 1e-10) < 1e-5);
  }
}

TEST_CASE("Stokes drag") {
  const effects::StokesDrag drag(0.7);
  // 6 pi * 0.7 * 0.775e-3 = 1.022588e-2 kg/s
  CHECK(drag.coefficient(0.775e-3) == near(1.022588e-2, 1e-6));
  Bodies bodies{.position = {0, 0}, .momentum = {2e-6, -1e-6}, .mass = {1e-5}, .radius = {0.775e-3}};
  const std::vector<double> force = forces_of(drag, bodies);
  CHECK(force[0] == near(-1.022588e-2 * 0.2, 1e-6));
  CHECK(force[1] == near(1.022588e-2 * 0.1, 1e-6));
  ForceJacobian jacobian(2);
  drag.add_jacobian({0, bodies, {}}, jacobian);
  REQUIRE(jacobian.by_momentum.size() == 2);
  CHECK(jacobian.by_momentum[1].value * bodies.momentum[1] == near(force[1]));
}

TEST_CASE("a group is named after its smallest member, however its contacts are listed") {
  const Scene scene = scene_of(std::vector<Vec2>(6));
  const std::vector<Contact> contacts = {{1, 4}, {2, 3}, {3, 4}};
  const ElectricalGroups groups = electrical_groups(scene, contacts);
  CHECK(groups.id == std::vector<int>{0, 1, 1, 1, 1, 5});
  CHECK(std::ranges::none_of(groups.potential, [](const auto& p) { return p.has_value(); }));
}

TEST_CASE("wires connect what does not touch, and hold it if their potential is given") {
  Scene scene = scene_of(std::vector<Vec2>(5));
  scene.groups = {{.name = "loose"}, {.name = "held", .potential = 3.0}};
  scene.conductors[1].group = scene.conductors[3].group = 0;
  scene.conductors[4].group = 1;
  CHECK(electrical_groups(scene, {}).id == std::vector<int>{0, 1, 2, 1, 4});
  const std::vector<Contact> contact = {{2, 4}};
  const ElectricalGroups groups = electrical_groups(scene, contact);
  CHECK(groups.potential[2] == 3.0);
  CHECK(!groups.potential[1]);
}

TEST_CASE("contact with an electrode or an electrode side holds a group; all held at one potential are one") {
  Scene scene = scene_of(std::vector<Vec2>(4));
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, 1e-3}, 5)};
  scene.domain.sides[2] = {.electrode = true, .potential = 5};
  const std::vector<Contact> contacts = {{0, 1}, {1, 4}, {3, 5}};  // 4: the ball, 5: the bottom
  const ElectricalGroups groups = electrical_groups(scene, contacts);
  CHECK(groups.id == std::vector<int>{0, 0, 2, 0});
  CHECK(groups.potential[3] == 5.0);
  CHECK(!groups.potential[2]);

  scene.domain.sides[2].potential = 6;
  CHECK(electrical_groups(scene, contacts).id == std::vector<int>{0, 0, 2, 3});
  const std::vector<Contact> shorted = {{0, 1}, {0, 4}, {1, 5}};
  CHECK_THROWS_WITH_AS(
      electrical_groups(scene, shorted),
      "the group of conductor 0 connects the electrode \"ball\" at 5 V with the bottom side of the domain "
      "at 6 V: a short circuit of perfect conductors, whose current has no limit, is not allowed",
      InputError);
}

TEST_CASE("a group parts when its members do, when it is let go and when another potential takes it") {
  const ElectricalGroups held = {{0, 0, 2}, {5.0, 5.0, {}}};
  CHECK(!parts(held, held));
  CHECK(!parts({{0, 1, 2}, {5.0, {}, {}}}, held));  // a merger
  CHECK(parts(held, {{0, 1, 2}, {5.0, {}, {}}}));   // one leaves
  CHECK(parts(held, {{0, 0, 2}, {{}, {}, {}}}));    // both leave the electrode together
  CHECK(parts(held, {{0, 0, 2}, {6.0, 6.0, {}}}));  // for another electrode, at once
}

TEST_CASE("contacts are made at the gap and lost a little beyond it") {
  const Scene scene = scene_of({{0, 0}, {0, 0}});
  effects::ContactDischarge discharge(scene);
  CHECK(discharge.release_gap() == near(1.1 * radius));
  Bodies bodies = make_bodies(scene);
  const auto at_gap = [&](double gap) {
    bodies.position = {0, 0, 2 * radius + gap, 0};
    discharge.update(bodies);
    return discharge.contacts().size();
  };
  CHECK(at_gap(1.05 * radius) == 0);  // between the two gaps it stays what it was
  CHECK(at_gap(0.99 * radius) == 1);
  CHECK(at_gap(1.05 * radius) == 1);
  CHECK(at_gap(1.11 * radius) == 0);
  CHECK(at_gap(1.05 * radius) == 0);
}

TEST_CASE("the release gap is never closer to the gap than positions are known") {
  Scene scene = scene_of({{0, 0}});
  scene.effects.contact_discharge->hysteresis = 0;
  scene.mechanics.position_tolerance = 3e-6;
  CHECK(effects::ContactDischarge(scene).release_gap() == near(radius + 3e-6));
}

TEST_CASE("a contact within a tolerance of its threshold comes along if it is on its way there") {
  const Scene scene = scene_of({{0, 0}, {0, 0}});
  Bodies bodies = make_bodies(scene);
  bodies.position = {0, 0, 3 * radius + 0.5e-6, 0};  // half a tolerance to go
  for (const double velocity : {-1e-3, 1e-3}) {
    effects::ContactDischarge discharge(scene);
    bodies.momentum = {0, 0, bodies.mass[1] * velocity, 0};
    CHECK(discharge.update(bodies).made == (velocity < 0 ? 1 : 0));
  }
}

TEST_CASE("unequal radii, electrodes and electrode sides count surface to surface") {
  Scene scene = scene_of({{0.03, 0.0021}, {0.03, 0.0021}});
  scene.conductors[1].radius = 3e-3;
  scene.conductors[1].position.y += 5.01e-3;                                           // gap 1.01 mm
  scene.electrodes = {electrode_of("ball", Disk{{0.03 + 3.99e-3, 0.0021}, 2e-3}, 0)};  // gap to conductor 0: 0.99 mm
  scene.domain.sides[2] = {.electrode = true, .potential = 0};                         // gap 1.1 mm
  effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  CHECK(discharge.gap(bodies, {0, 1}) == near(1.01e-3));
  CHECK(discharge.gap(bodies, {0, 2}) == near(0.99e-3));
  CHECK(discharge.gap(bodies, {0, 3}) == near(1.1e-3));
  discharge.update(bodies);
  CHECK(discharge.contacts() == std::vector<Contact>{{0, 2}});
}

TEST_CASE("gap rates are the derivatives of gaps") {
  Scene scene = scene_of({{0.03, 0.02}, {0.034, 0.023}});
  scene.electrodes = {electrode_of("ring", Ring{{0.03, 0.03}, 0.02}, 0)};
  scene.conductors[0].velocity = {1e-3, -2e-3};
  scene.conductors[1].velocity = {-3e-3, 1e-3};
  const effects::ContactDischarge discharge(scene);
  const Bodies bodies = make_bodies(scene);
  Bodies later = bodies;
  const double dt = 1e-6;
  for (int k = 0; k < 4; ++k) later.position[k] += dt * bodies.momentum[k] / bodies.mass[k / 2];
  for (const Contact contact : {Contact{0, 1}, Contact{1, 2}})  // truncation: v dt / distance = 1e-6
    CHECK(discharge.gap_rate(bodies, contact) ==
          near((discharge.gap(later, contact) - discharge.gap(bodies, contact)) / dt, 1e-4));
}

TEST_CASE("only contacts that can change are watched") {
  Scene scene = scene_of({{0.02, 0.02}, {0.0232, 0.02}, {0.0264, 0.02}, {0.0264, 0.0229}});
  effects::ContactDischarge discharge(scene);
  const Bodies bodies = make_bodies(scene);
  discharge.update(bodies);
  REQUIRE(discharge.contacts() == std::vector<Contact>{{2, 3}});  // gaps: 1.2 mm, 1.2 mm, 0.9 mm
  const auto watched = [&](double travel) {
    const std::vector<double> all(4, travel);
    return discharge.watch(bodies, electrical_groups(scene, discharge.contacts()), all);
  };
  CHECK(watched(0.09e-3).empty());  // 0.1 mm each to meet, 0.1 mm each to part
  REQUIRE(watched(0.11e-3).size() == 3);
  CHECK(watched(0.11e-3)[0].contact == Contact{0, 1});
  CHECK(!watched(0.11e-3)[0].made);
  CHECK(watched(0.11e-3)[2].made);
  CHECK(discharge.excess(bodies, watched(0.11e-3)[0]) == near(0.2e-3));
  CHECK(discharge.excess(bodies, watched(0.11e-3)[2]) == near(-0.2e-3));
  // Were 1, 2 and 3 one already, a contact between 1 and 2 would change nothing.
  const std::vector<Contact> ring = {{1, 3}, {2, 3}};
  discharge.set_contacts(ring);
  for (const auto& w : watched(0.11e-3)) CHECK(w.contact != Contact{1, 2});
}

TEST_CASE("one body that may move far brings its own contacts under watch, no others") {
  Scene scene = scene_of({{0.02, 0.02}, {0.08, 0.02}, {0.02, 0.08}, {0.08, 0.08}});
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  const effects::ContactDischarge discharge(scene);
  const std::vector<double> travel = {0, 0, 0.06, 0};
  std::vector<Contact> watched;
  for (const auto& w : discharge.watch(make_bodies(scene), electrical_groups(scene, {}), travel))
    watched.push_back(w.contact);
  // 6 cm to 0 and 3, less 3 mm; 4.2 cm to the ball; 8.5 cm to 1.
  CHECK(watched == std::vector<Contact>{{0, 2}, {2, 3}, {2, 4}});
}

TEST_CASE("between two looks a gap dips by no more than a tolerance") {
  // On a straight line past each other whose least gap is a tolerance below the threshold, two looks a blind way apart,
  // where the gap is at its threshold, are no closer than the chord beyond it.
  Scene scene = scene_of({{0.05, 0.05}, {0.05, 0.05}});
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  const double tolerance = 1e-6, arm = 3 * radius;
  bodies.position = {0.05, 0.05, 0.05 + std::sqrt(arm * arm - std::pow(arm - tolerance, 2)), 0.05 + arm - tolerance};
  const effects::ContactDischarge::Watch pair = {{0, 1}, false};
  REQUIRE(std::abs(discharge.excess(bodies, pair)) < 1e-15);
  const double chord = 2 * (bodies.position[2] - 0.05);
  CHECK(discharge.blind_way(bodies, pair) == near(chord, tolerance / arm));
  bodies.position = {0.05, 0.05, 0.05 + arm + 0.01, 0.05};  // far away, the gap itself is the way
  CHECK(discharge.blind_way(bodies, pair) == near(0.01));
}

TEST_CASE("a compensated sum keeps what a plain one loses") {
  // 1e-11 C a time into 1 C: each addition is rounded to a multiple of 2^-52, the same way each time
  const double step = 1e-11 / 3;
  CompensatedSum sum(1.0);
  double plain = 1.0;
  for (int k = 0; k < 1000000; ++k) sum.add(step), plain += step;
  const double exact = 1.0 + 1e6 * step;
  CHECK(std::abs(sum.total() - exact) < 3e-16);
  CHECK(std::abs(plain - exact) > 1e-13);
}

TEST_CASE("the ledger conserves charge through any history of merges, splits, feeding and draining") {
  const int n = 20;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::uniform_int_distribution<int> pick(0, n - 1);
  const Scene scene = [&] {
    Scene s = scene_of(std::vector<Vec2>(n));
    s.electrodes = {electrode_of("ground", Disk{{0.05, 0.05}, 1e-3}, 0)};
    return s;
  }();
  std::vector<double> initial(n), current(n, 0.2e-9), by_field(n);
  for (double& q : initial) q = 1e-10 * noise(random);
  const double start = [&] {
    CompensatedSum sum;
    for (const double q : initial) sum.add(q);
    return sum.total();
  }();
  ChargeLedger ledger(initial);
  double time = 0;
  for (int step = 0; step < 20000; ++step) {
    const double dt = 1e-3 * (1 + noise(random));
    time += dt;
    ledger.feed(current, dt);
    std::vector<Contact> contacts;
    for (int k = step % 12; k > 0; --k) {
      const int i = pick(random), j = pick(random);
      if (i != j) contacts.push_back({std::min(i, j), std::max(i, j)});
      if (k == 5) contacts.push_back({i, n});
    }
    std::ranges::sort(contacts);
    for (double& q : by_field) q = 1e-10 * noise(random);  // a field solver that knows nothing of the charges
    ledger.settle(electrical_groups(scene, contacts), by_field);
  }
  // Rounding happens only where the sums' two parts are added up: a few 1e-16 of the largest of them, fed.
  CHECK(ledger.fed() == near(n * 0.2e-9 * time, 1e-13));  // `time` itself is a plain sum
  CHECK(std::abs(ledger.held() + ledger.drained() - ledger.fed() - start) < 1e-15 * ledger.fed());
}

TEST_CASE("a floating group keeps its charge and shares it as the field does, a held one takes the field's") {
  Scene scene = scene_of(std::vector<Vec2>(4));
  scene.electrodes = {electrode_of("ground", Disk{{0.05, 0.05}, 1e-3}, 0)};
  const std::vector<double> initial = {1, 2, 3, 4};
  ChargeLedger ledger(initial);
  const std::vector<Contact> contacts = {{0, 1}, {2, 4}};
  const std::vector<double> by_field = {2.0, 1.2, -7, 99};  // 0 and 1 together hold 3: the field has 0.2 too much
  ledger.settle(electrical_groups(scene, contacts), by_field);
  CHECK(ledger.charge(0) == near(1.9));
  CHECK(ledger.charge(1) == near(1.1));
  CHECK(ledger.charge(0) + ledger.charge(1) == 3);
  CHECK(ledger.charge(2) == -7);
  CHECK(ledger.drained() == 10);
  CHECK(ledger.charge(3) == 4);  // alone: it has what it has
}

TEST_CASE("a ledger is saved and restored to the last bit") {
  const std::vector<double> initial = {1e-10, -2e-10}, current = {1e-9 / 3, 1e-9 / 7};
  ChargeLedger ledger(initial), copy(initial);
  for (int k = 0; k < 1000; ++k) ledger.feed(current, 1e-3 / 3);
  copy.restore(ledger.save());
  ledger.feed(current, 0.1);
  copy.feed(current, 0.1);
  CHECK(copy.save() == ledger.save());
  CHECK_THROWS_AS(copy.restore(std::vector<double>(6)), Failure);
}

TEST_CASE("the field problem of a scene: bodies, groups, charges per metre of depth, sides") {
  Scene scene = scene_of({{0.01, 0.01}, {0.02, 0.01}, {0.03, 0.01}, {0.04, 0.01}});
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, 1e-3}, 7)};
  scene.domain.sides[1] = {.electrode = true, .potential = 2};
  Bodies bodies = make_bodies(scene);
  bodies.charge = {1e-12, 2e-12, 4e-12, 8e-12};
  const std::vector<Contact> contacts = {{0, 2}, {3, 4}};
  const laplace::LaplaceProblem problem = make_laplace_problem(scene, bodies, electrical_groups(scene, contacts));
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

TEST_CASE("field forces, charges and energies are SI: per metre of depth times the depth") {
  // Two line charges q at distance d repel with q^2 / (2 pi eps d) per metre.
  Scene scene = scene_of({{0.04, 0.05}, {0.05, 0.05}});
  auto log = std::make_shared<SolverLog>();
  effects::FloatingConductors field(scene, std::make_unique<LineCharges>(log));
  Bodies bodies = make_bodies(scene);
  bodies.charge = {1e-10, 1e-10};
  const Electrostatics& found = field.solve(bodies, electrical_groups(scene, {}));
  const double depth = 2 * radius, q = 1e-10 / depth;
  CHECK(found.force[1].x == near(depth * q * q / (2 * pi * 4e-11 * 0.01)));
  CHECK(found.charge[0] == near(1e-10));
  CHECK(found.potential[0] == near(q / (2 * pi * 4e-11) * (std::log(0.1 / radius) + std::log(10))));
  CHECK(found.energy == near(0.5 * 1e-10 * (found.potential[0] + found.potential[1])));
  CHECK(field.solves() == 1);
  CHECK(field.iterations() == 1);

  field.hold(2.0, {{1, 2}, {3, 4}}, {{0.5, 0}, {0, -0.5}});
  std::vector<double> force(4);
  field.add_forces({4.0, bodies, {}}, force);
  CHECK(force == std::vector<double>{2, 2, 3, 3});
  CHECK(log->solves == 1);  // held forces cost no solve
}

TEST_CASE("the field solver is the one that the scene asks for") {
  CHECK(dynamic_cast<laplace::CutCellSolver*>(make_field_solver({.method = "cut-cell"}).get()));
  CHECK(dynamic_cast<laplace::RelaxationSolver*>(make_field_solver({.method = "relaxation"}).get()));
  CHECK(dynamic_cast<laplace::MultipoleSolver*>(make_field_solver({.method = "multipole"}).get()));
  CHECK_THROWS_AS(make_field_solver({.method = "multipole", .device = "cuda"}), InputError);
  CHECK_THROWS_AS(make_field_solver({.method = "relaxation", .device = "cuda"}), InputError);
}

TEST_CASE("the multipole method moves only what contact forces keep apart") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.03}});
  scene.field.method = "multipole";
  CHECK_THROWS_AS(make_model(scene), InputError);
  scene.effects.hertz_contact.emplace();
  CHECK_THROWS_AS(make_model(scene), InputError);
  scene.effects.wall_contact.emplace();
  CHECK_NOTHROW(make_model(scene));
}

TEST_CASE("different potentials that touch end a run, if no discharge makes them one") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.02}});
  scene.effects.contact_discharge.reset();
  scene.domain.sides[0] = {true, 0};
  effects::FloatingConductors field(scene, std::make_unique<LineCharges>(std::make_shared<SolverLog>()));
  Bodies bodies = make_bodies(scene);
  bodies.charge = {1e-10, 0};
  const ElectricalGroups apart = electrical_groups(scene, {});
  bodies.position[2] = 0.02 + 1.99 * radius;
  CHECK_THROWS_AS(field.solve(bodies, apart), InputError);  // the first instant
  bodies.position[2] = 0.02 + 2.01 * radius;
  CHECK_NOTHROW(field.solve(bodies, apart));
  bodies.position[2] = 0.02 + 1.99 * radius;
  CHECK_THROWS_AS(field.solve(bodies, apart), Failure);
  CHECK_NOTHROW(field.solve(bodies, electrical_groups(scene, std::vector{Contact{0, 1}})));
  bodies.position[2] = 0.99 * radius;  // in the left side, an electrode
  CHECK_THROWS_AS(field.solve(bodies, apart), Failure);
}

TEST_CASE("a model has the effects whose tables stand in the scene, and nothing of the others") {
  Scene scene = scene_of({{0.02, 0.02}, {0.03, 0.03}});
  scene.effects = {};
  const Model nothing = make_model(scene);
  CHECK(nothing.effects.empty());
  CHECK(nothing.bodies.charge.empty());
  CHECK(!nothing.neighbours);

  scene.effects.stokes_drag.emplace();
  scene.effects.hertz_contact.emplace();
  const Model neutral = make_model(scene);
  CHECK(neutral.effects.size() == 2);
  CHECK(neutral.find<effects::StokesDrag>());
  CHECK(!neutral.find<effects::FloatingConductors>());
  CHECK(neutral.bodies.charge.empty());
  CHECK(neutral.neighbours);

  scene.effects.floating_conductors.emplace();
  scene.effects.current_source.emplace();
  scene.effects.wall_contact.emplace();
  scene.effects.contact_discharge.emplace();
  const Model all = make_model(scene);
  CHECK(all.effects.size() == 6);
  CHECK(all.bodies.charge == std::vector<double>{0, 0});
  CHECK(!laplace::petsc_started());  // not before the first solve
}

TEST_CASE("effects can be listed with what they are and what they need") {
  Scene scene = scene_of({{0.02, 0.02}});
  scene.effects = {};
  scene.effects.hertz_contact.emplace();
  scene.effects.contact_discharge.emplace();
  for (const EffectSummary& effect : summarize_effects(scene)) {
    CHECK(!effect.description.empty());
    CHECK(effect.in_scene == (effect.name == "hertz_contact" || effect.name == "contact_discharge"));
    CHECK(effect.needs.field == (effect.name == "contact_discharge"));
    CHECK(effect.needs.neighbour_range.has_value() == (effect.name == "hertz_contact"));
  }
  scene.effects = {
      {}, {}, {}, lichtenberg::HertzContact{}, lichtenberg::WallContact{}, lichtenberg::ContactDischarge{}};
  scene.effects.floating_conductors.emplace();
  scene.effects.current_source.emplace();
  scene.effects.stokes_drag.emplace();
  const Model model = make_model(scene);
  const std::vector<EffectSummary> listed = summarize_effects(scene);
  REQUIRE(listed.size() == model.effects.size());
  for (std::size_t k = 0; k < listed.size(); ++k) CHECK(listed[k].name == model.effects[k]->name());
}
