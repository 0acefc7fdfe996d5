// Mergers that wait for each other, come along before their time, or meet a parting: what is left of it in the end.
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "src/mechanics/simulation.hpp"
#include "tests/spheres.hpp"

namespace mergers_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::steel_spheres;

namespace {

/// Equal within a fraction of the value. (doctest's own scale of 1 would let everything small pass.)
doctest::Approx near(double value) { return doctest::Approx(value).epsilon(1e-9).scale(0); }

constexpr double tolerance = 1e-5;  // m
constexpr double speed = 0.01;      // m/s, at which the force below drives a body against drag
const double force = speed * drag;  // N
constexpr double until = 0.05;      // s: twenty relaxation times after the last merger

/// Bodies i and i + 1 for even i, a way (m) from where they meet, far from all others.
Scene pairs(const std::vector<double>& ways) {
  std::vector<Vec2> places;
  for (std::size_t pair = 0; pair < ways.size(); ++pair) {
    const double x = 0.02 + 0.02 * static_cast<double>(pair);
    places.push_back({x, 0.05});
    places.push_back({x, 0.05 + 3 * radius + ways[pair]});
  }
  Scene scene = conductor_scene(places);
  scene.mechanics.relative_tolerance = 1e-9;
  scene.mechanics.position_tolerance = tolerance;
  return scene;
}

bool one(const LaplaceProblem& problem, int i, int j) { return problem.bodies[i].group == problem.bodies[j].group; }

/// Forces (N) that drive the members of a pair at each other, by the index of a body.
template <class OfBody>
Scripted::Forces together(OfBody of_body) {
  return [=](const LaplaceProblem& problem) {
    std::vector<Vec2> forces;
    for (int i = 0; i < static_cast<int>(problem.bodies.size()); ++i)
      forces.push_back({0, (i % 2 ? -1 : 1) * of_body(problem, i)});
    return forces;
  };
}

std::unique_ptr<Simulation> run(const Scene& scene, const Scripted::Forces& forces) {
  auto simulation = std::make_unique<Simulation>(scene, scripted(forces));
  simulation->advance_to(until);
  return simulation;
}

/// How far bodies are in the end from where they are if every force acts from the instant on from which it should: the
/// field in each of CVODE's steps, events to a hundred thousandth of the tolerance.
double error(Scene scene, const Scripted::Forces& forces) {
  const ConductorFrame frame = run(scene, forces)->now();
  scene.mechanics.coupling = FieldCoupling::monolithic;
  scene.mechanics.position_tolerance = 1e-5 * tolerance;
  return largest_distance(frame, run(scene, forces)->now());
}

}  // namespace

TEST_CASE("a jump much larger than those before is made up for whole") {
  // The first pair's jump, a hundredth of its force, lets the next wait for longer than theirs, .9, would: these move
  // some tolerances without it.
  const auto forces = together(
      [](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? (i < 2 ? 0.99 : 0.1) : 1) * force; });
  CHECK(error(pairs({2e-4, 4e-4, 4e-4 + 2 * speed * 1e-3}), forces) < 1e-3 * tolerance);
}

TEST_CASE("of contacts that join the same two groups the first is the merger") {
  // Two wires, each of a member of the second and of the third pair.
  Scene scene = pairs({2e-4, 4e-4, 4e-4 + 3 * tolerance});
  scene.groups = {{.name = "lower"}, {.name = "upper"}};
  for (int i = 2; i < 6; ++i) scene.conductors[i].group = i % 2;
  const auto forces =
      together([](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? 0.9 : 1) * force; });
  CHECK(error(scene, forces) < 1e-3 * tolerance);
}

TEST_CASE("a merger that comes along before its time leaves nothing behind") {
  for (const double behind : {0.3, 0.6, 0.95}) {
    const auto forces =
        together([](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? 0.1 : 1) * force; });
    Scene scene = pairs({4e-4, 4e-4 + behind * tolerance});
    // Or the two thresholds would be too close for as much as a tolerance.
    scene.effects.find<effects::ContactDischargeOptions>()->hysteresis = 0.05;
    CHECK(run(scene, forces)->counters().regroupings == 1);
    CHECK(error(scene, forces) < 1e-3 * tolerance);
  }
}

TEST_CASE("a contact that is carried across its threshold by what is made up for is made at once") {
  // The third pair rests just above its threshold until the second meets; what that changes drives it across while the
  // second waits. When it crossed is known from its gap and its speed then, as if that had been its speed throughout:
  // that is within the wait, t = .5 drag tolerance / jump at most, and in it the jump's difference, .08 of the force,
  // moves it by .08 / .1 * half a tolerance at most.
  for (const double beyond : {0.05, 0.1, 0.2}) {
    const auto forces = together([](const LaplaceProblem& problem, int i) {
      if (i < 4) return (one(problem, i, i ^ 1) ? 0.9 : 1) * force;
      return one(problem, 2, 3) ? (one(problem, 4, 5) ? 0.02 : 0.1) * force : 0;
    });
    CHECK(error(pairs({2e-4, 4e-4, beyond * tolerance}), forces) < 0.4 * tolerance);
  }
}

TEST_CASE("a merger and a parting that share a solve happen in their order") {
  // The third conductor leaves the fourth while the fifth comes, each at the speed of its force, .1 ms before or after.
  // The first pair has told that a merger may wait for longer.
  for (const double lead : {-1e-4, 1e-4}) {
    Scene scene = pairs({2e-4, 1, 1});
    const double meet = 0.02, part = meet + lead;
    const double release = tolerance;  // beyond the gap: hysteresis is less
    const Vec3 middle = {0.06, 0.05, 0}, up = {0, 1, 0};
    scene.conductors[2].position = middle + (3 * radius + release - speed * part) * up;
    scene.conductors[3].position = middle;
    scene.conductors[4].position = middle - (3 * radius + speed * meet) * up;
    scene.conductors[5].position = {0.02, 0.02, 0};
    for (const int i : {2, 4}) scene.conductors[i].velocity = speed * up;
    scene.conductors[2].charge = scene.conductors[3].charge = 3e-12;
    const auto simulation = run(scene, [](const LaplaceProblem& problem) {
      const double of_first = (one(problem, 0, 1) ? 0.9 : 1) * force;
      return std::vector<Vec2>{{0, of_first}, {0, -of_first}, {0, force}, {}, {0, one(problem, 3, 4) ? 0 : force}, {}};
    });
    const std::vector<double> charge = simulation->now().charge;
    const double left = lead > 0 ? 2e-12 : 3e-12;  // with which the third leaves
    CHECK(charge[2] == near(left));
    CHECK(charge[3] == near(0.5 * (6e-12 - left)));
    CHECK(charge[4] == near(0.5 * (6e-12 - left)));
    CHECK(simulation->counters().contacts_lost == 1);
  }
}

}  // namespace mergers_test
