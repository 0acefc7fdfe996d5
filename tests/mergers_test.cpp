// Tests of deferred group merges, early contacts and simultaneous splits: the errors at the end.
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "src/mechanics/simulation.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace mergers_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::steel_spheres;

namespace {

constexpr double tolerance = 1e-5;  // m
constexpr double speed = 0.01;      // Speed (m/s) at which the force below drives a body against drag.
const double force = speed * drag;  // N
constexpr double until = 0.05;      // End (s): twenty relaxation times after the last merge.

/// Scene of pairs i and i + 1 for even i, each at a distance (m) from contact and far from all others.
Scene pairs(const std::vector<double>& gaps) {
  std::vector<Vec2> positions;
  for (std::size_t pair = 0; pair < gaps.size(); ++pair) {
    const double x = 0.02 + 0.02 * static_cast<double>(pair);
    positions.push_back({x, 0.05});
    positions.push_back({x, 0.05 + 3 * radius + gaps[pair]});
  }
  Scene scene = conductor_scene(positions);
  scene.mechanics.relative_tolerance = 1e-9;
  scene.mechanics.position_tolerance = tolerance;
  return scene;
}

bool one(const LaplaceProblem& problem, int i, int j) { return problem.bodies[i].group == problem.bodies[j].group; }

/// Forces (N) that drive the members of a pair towards each other, by the index of a body.
template <class ForceOfBody>
Scripted::Forces together(ForceOfBody force_of_body) {
  return [=](const LaplaceProblem& problem) {
    std::vector<Vec2> forces;
    for (int i = 0; i < static_cast<int>(problem.bodies.size()); ++i)
      forces.push_back({0, (i % 2 ? -1 : 1) * force_of_body(problem, i)});
    return forces;
  };
}

std::unique_ptr<Simulation> run(const Scene& scene, const Scripted::Forces& forces) {
  auto simulation = std::make_unique<Simulation>(scene, scripted(forces));
  simulation->advance_to(until);
  return simulation;
}

/// Difference of the final positions from a reference in which forces change exactly at the events. The reference
/// solves the field in each step of CVODE and locates events to 1e-5 of the tolerance.
double error(Scene scene, const Scripted::Forces& forces) {
  const ConductorFrame frame = run(scene, forces)->now();
  scene.mechanics.coupling = FieldCoupling::monolithic;
  scene.mechanics.position_tolerance = 1e-5 * tolerance;
  return largest_distance(frame, run(scene, forces)->now());
}

}  // namespace

TEST_CASE("deferred group merge: corrects a force jump 90 times the assumed one") {
  // The first pair's jump of 1 % of its force permits a longer deferral than the jump of 0.9 of the others would.
  // Without a correction these would move several tolerances.
  const auto forces = together(
      [](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? (i < 2 ? 0.99 : 0.1) : 1) * force; });
  CHECK(error(pairs({2e-4, 4e-4, 4e-4 + 2 * speed * 1e-3}), forces) < 1e-3 * tolerance);
}

TEST_CASE("two contacts between the same two groups: positions stay accurate") {
  // Two wires, each connecting a member of the second pair and one of the third.
  Scene scene = pairs({2e-4, 4e-4, 4e-4 + 3 * tolerance});
  scene.groups = {{.name = "lower"}, {.name = "upper"}};
  for (int i = 2; i < 6; ++i) scene.conductors[i].group = i % 2;
  const auto forces =
      together([](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? 0.9 : 1) * force; });
  CHECK(error(scene, forces) < 1e-3 * tolerance);
}

TEST_CASE("deferred group merge: two contacts in one regrouping leave no error") {
  for (const double behind : {0.3, 0.6, 0.95}) {
    const auto forces =
        together([](const LaplaceProblem& problem, int i) { return (one(problem, i, i ^ 1) ? 0.1 : 1) * force; });
    Scene scene = pairs({4e-4, 4e-4 + behind * tolerance});
    // Otherwise the two thresholds would be closer than a tolerance.
    scene.effects.find<effects::ContactDischargeOptions>()->hysteresis = 0.05;
    CHECK(run(scene, forces)->counters().regroupings == 1);
    CHECK(error(scene, forces) < 1e-3 * tolerance);
  }
}

TEST_CASE("contact closed by a position correction: error below 0.4 tolerances") {
  // The third pair rests just above its threshold until the second pair meets. The resulting force drives it across
  // while the second merge is deferred. The time of crossing follows from its gap and its current speed. It lies within
  // the deferral t = 0.5 drag tolerance / jump. Meanwhile the difference of the jump, 0.08 of the force, moves the pair
  // by at most 0.08 / 0.1 * half a tolerance.
  for (const double beyond : {0.05, 0.1, 0.2}) {
    const auto forces = together([](const LaplaceProblem& problem, int i) {
      if (i < 4) return (one(problem, i, i ^ 1) ? 0.9 : 1) * force;
      return one(problem, 2, 3) ? (one(problem, 4, 5) ? 0.02 : 0.1) * force : 0;
    });
    CHECK(error(pairs({2e-4, 4e-4, beyond * tolerance}), forces) < 0.4 * tolerance);
  }
}

TEST_CASE("group merge and split in one solve: happen in their order in time") {
  // The third conductor separates from the fourth while the fifth approaches, each at the speed of its force, 0.1 ms
  // before or after. The first pair has permitted a longer deferral.
  for (const double lead : {-1e-4, 1e-4}) {
    Scene scene = pairs({2e-4, 1, 1});
    const double meet = 0.02, part = meet + lead;
    const double release = tolerance;  // Beyond the gap; the hysteresis is smaller.
    const Vec3 middle = {0.06, 0.05, 0}, up = {0, 1, 0};
    scene.conductors[2].position = middle + (3 * radius + release - speed * part) * up;
    scene.conductors[3].position = middle;
    scene.conductors[4].position = middle - (3 * radius + speed * meet) * up;
    scene.conductors[5].position = {0.02, 0.02, 0};
    for (const int i : {2, 4}) scene.conductors[i].velocity = speed * up;
    scene.conductors[2].charge = scene.conductors[3].charge = 3e-12;
    const auto simulation = run(scene, [](const LaplaceProblem& problem) {
      const double first_force = (one(problem, 0, 1) ? 0.9 : 1) * force;
      return std::vector<Vec2>{
          {0, first_force}, {0, -first_force}, {0, force}, {}, {0, one(problem, 3, 4) ? 0 : force}, {}};
    });
    const std::vector<double> charge = simulation->now().charge;
    const double left = lead > 0 ? 2e-12 : 3e-12;  // Charge of the third conductor at the split.
    CHECK(charge[2] == near(left));
    CHECK(charge[3] == near(0.5 * (6e-12 - left)));
    CHECK(charge[4] == near(0.5 * (6e-12 - left)));
    CHECK(simulation->counters().contacts_lost == 1);
  }
}

}  // namespace mergers_test
