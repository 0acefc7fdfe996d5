// Head-on collisions of two grains of opposite charge, with and without capture. The program compares every integrator
// with CVODE in free space (theory/two_grains.hpp). The scene two-grains.toml is equivalent while the grains are closer
// than half its box, because nearest images attract as charges in free space.
//
// Bounds. cvode: 1e-13 per step in positions and momenta over thousands of steps, relative to a speed of order 1: 1e-9.
// Others, at dt = .005: the error of restitution at v = 1 to 5 is bounded (docs/measurements/granular.json). It is at
// most .0011 to .0020 (verlet), .0011 to .0018 (gear), .0018 to .0047 (gear-printed). A release speed has this error
// times the impact speed. multirate: contacts 1e-4; second-order impulses (h a / v)^2 / 12 of a speed v = 1 with
// accelerations a = .5 and h = .005: 1e-6.

#include <map>

#include "src/effects/read_scene.hpp"
#include "tests/grains.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"
#include "validation/theory/two_grains.hpp"

namespace two_grains_validation {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using namespace lichtenberg::validation;

namespace {

const theory::TwoGrains free_pair{.elastic = 278.6, .dissipative = 27.7, .coulomb = -0.25};
constexpr double start = 1.5;  // d0, between centres

struct Bound {
  Integrator integrator;
  double speed;  // error of the release speed, relative to the impact speed
};
constexpr Bound bounds[] = {{Integrator::cvode, 1e-9},
                            {Integrator::multirate, 1e-4},
                            {Integrator::verlet, 0.0025},
                            {Integrator::gear, 0.0025},
                            {Integrator::gear_printed, 0.006}};

Scene scene_with(Integrator integrator, double speed) {
  Scene scene = read_scene(source_folder() + "/scenes/two-grains.toml");
  scene.mechanics.integrator = integrator;
  scene.conductors[0].velocity.x = 0.5 * speed, scene.conductors[1].velocity.x = -0.5 * speed;
  return scene;
}

/// Returns the impact speed at onset of grains with this initial speed.
double impact(double speed) {
  return std::sqrt(speed * speed + 2 / free_pair.effective_mass * free_pair.coulomb * (1 / start - 1));
}

double relative_speed(const granular::Gas& gas) {
  return norm(velocity<3>(gas.bodies(), 1) - velocity<3>(gas.bodies(), 0));
}
double distance(const granular::Gas& gas) { return norm(position<3>(gas.bodies(), 1) - position<3>(gas.bodies(), 0)); }

/// Returns the release speed at contact opening, extrapolated from the pair's position after its first contact.
double release_speed(const granular::Gas& gas) {
  const double v = relative_speed(gas);
  return std::sqrt(v * v + 2 / free_pair.effective_mass * free_pair.coulomb * (1 / distance(gas) - 1));
}

void one_contact(Report& report, const Bound& bound, double speed) {
  const theory::PairContact exact = theory::contact(free_pair, impact(speed));
  Run run(scene_with(bound.integrator, speed));
  while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 1);
  report.at_most(fmt::format("{}, {:g}: speed of release", name_of(bound.integrator), speed),
                 std::abs(release_speed(run.gas) - exact.release) / impact(speed), bound.speed);
  const double energy = 0.5 * free_pair.effective_mass * impact(speed) * impact(speed);
  report.at_most(fmt::format("{}, {:g}: dissipated by it", name_of(bound.integrator), speed),
                 std::abs(run.gas.energy().dissipated - exact.dissipated) / energy, 2 * bound.speed);
}

/// Tests a permanently bound pair: it dissipates all energy above that of rest.
void captured(Report& report, const Bound& bound, double speed) {
  Run run(scene_with(bound.integrator, speed));
  const double before = run.gas.energy().total();
  run.to(60);
  const granular::GasEnergy end = run.gas.energy();
  const double exact = before - theory::static_energy(free_pair);
  report.at_most(fmt::format("{}, {:g}: dissipated in all", name_of(bound.integrator), speed),
                 std::abs(end.dissipated - exact) / exact, std::max(2 * bound.speed, 1e-9));
  report.at_most(fmt::format("{}, {:g}: overlap at rest", name_of(bound.integrator), speed),
                 std::abs((1 - distance(run.gas)) / theory::static_overlap(free_pair) - 1),
                 std::max(bound.speed, 1e-6));
}

void escaped(Report& report, const Bound& bound, double speed) {
  Run run(scene_with(bound.integrator, speed));
  run.to(5);
  report.at_least(fmt::format("{}, {:g}: comes apart, distance at t = 5", name_of(bound.integrator), speed),
                  distance(run.gas), 2);
}

}  // namespace

int validate(int, char**) {
  Report report("Two charged grains: capture and escape");
  const double limit = theory::capture_speed(free_pair);
  fmt::print("K q^2 = .25: a pair is captured that touches at less than {:.10f}\n", limit);
  for (const Bound& bound : bounds) {
    report.section(fmt::format("{}", name_of(bound.integrator)));
    for (const double speed : {1.5, 5.0}) one_contact(report, bound, speed);
    captured(report, bound, 1.5);
    escaped(report, bound, 5);
  }
  report.section("the speed that decides, 1e-3 below and above");
  for (const double off : {-1e-3, 1e-3}) {
    const double touch = limit * (1 + off);
    const double speed = std::sqrt(touch * touch - impact(0) * impact(0));
    for (const Integrator integrator : {Integrator::cvode, Integrator::multirate}) {
      Run run(scene_with(integrator, speed));
      while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 1);
      const double energy =
          0.5 * free_pair.effective_mass * std::pow(relative_speed(run.gas), 2) + free_pair.coulomb / distance(run.gas);
      report.at_least(fmt::format("{}, {:+g}: energy has the sign", name_of(integrator), off), energy * off, 0);
    }
  }
  return report.exit_status();
}

const lichtenberg::validation::Program program("two_grains", validate);

}  // namespace two_grains_validation
