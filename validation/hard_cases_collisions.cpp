// Elastic contact in limiting cases: soft and hard, slow and fast, two spheres and twenty, isolated and with other
// bodies.
//
//   hard_cases_collisions         against Hertz's theory and an independent integrator, 2 s
//   hard_cases_collisions long    all speeds and moduli
//
// Bound of a collision. A step of the integrator has an error of at most relative_tolerance of a body's momentum plus
// relative_tolerance * R * m / largest_step for each body (stepper.hpp). In the worst case, the errors of n steps add
// up to n * relative_tolerance * (1 + R / (largest_step * speed)) of the momentum, and twice that of the energy.
// Durations and overlaps depend on the speed with powers below 1. n is counted.
//
// Momentum is a linear invariant. Each step conserves it up to the rounding of its linear solve: 1e-16 per step and
// term.

#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/mechanics/stepper.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace hard_cases_collisions_validation {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using namespace lichtenberg::validation;

namespace {

double stiffness(double young) {
  return 4.0 / 3.0 * effects::contact_modulus({young, 0.3}, {young, 0.3}) * std::sqrt(radius / 2);
}

/// Collision of two equal spheres with relative speed v. At the largest overlap all energy is elastic:
///   m_eff v^2 / 2 = 2/5 k overlap^(5/2),   m_eff = m / 2,   k = 4/3 E* sqrt(R / 2).
/// The contact lasts 2 overlap / v * integral_0^1 dx / sqrt(1 - x^(5/2)) = 4/5 B(2/5, 1/2) overlap / v, which is
/// 2.943275 overlap / v (Hertz 1882).
struct Collision {
  double young, speed;
  double overlap() const { return std::pow(5 * 0.5 * mass * speed * speed / (4 * stiffness(young)), 0.4); }
  double duration() const { return 0.8 * std::beta(0.4, 0.5) * overlap() / speed; }
};

/// Largest values of all collisions.
struct Worst {
  double steps = 0, momentum = 0;
};

constexpr double initial_gap = 0.5e-3;  // m, distance of the surfaces at the start

Scene head_on(const Collision& collision, int bystanders = 0) {
  Scene scene = scene_of({{0.03, 0.05}, {0.03 + 2 * radius + initial_gap, 0.05}});
  scene.conductors[0].velocity = {0.5 * collision.speed, 0};
  scene.conductors[1].velocity = {-0.5 * collision.speed, 0};
  for (int i = 0; i < bystanders; ++i) {
    const Vec2 seat = {2e-3 + i % 40 * 2.2 * radius, 0.055 + i / 40 * 2.2 * radius};
    scene.conductors.push_back({.position = in_space(seat), .radius = radius});
  }
  scene.effects.add(effects::HertzContactOptions{.young = collision.young, .poisson = 0.3});
  return scene;
}

/// Returns the permitted relative error of a speed per step.
double error_a_step(const Scene& scene, double speed) {
  return scene.mechanics.relative_tolerance * (1 + radius / (scene.mechanics.largest_step * speed));
}

void collide(Report& report, Worst& worst, const Collision& collision, int bystanders) {
  const Scene scene = head_on(collision, bystanders);
  Model model = effects::make_model(scene);
  const auto gap = [&] { return norm(position(model.bodies, 1) - position(model.bodies, 0)) - 2 * radius; };
  mechanics::Cvode cvode = mechanics::make_cvode(scene, model);
  const double touch = initial_gap / collision.speed, duration = collision.duration();
  cvode.advance(0, touch + 0.5 * duration);
  const double overlap = -gap();
  cvode.advance(touch + 0.5 * duration, touch + 2 * duration);
  const double rebound = (velocity(model.bodies, 1) - velocity(model.bodies, 0)).x;
  const double lasted = 2 * duration - gap() / rebound, energy = std::pow(rebound / collision.speed, 2);

  const auto steps = static_cast<double>(cvode.steps());
  worst.steps = std::max(worst.steps, steps);
  worst.momentum =
      std::max(worst.momentum, norm(velocity(model.bodies, 0) + velocity(model.bodies, 1)) / collision.speed);
  report.at_most(fmt::format("Y = {:.0e} Pa, {:g} m/s{}", collision.young, collision.speed,
                             bystanders > 0 ? ", a thousand looking on" : ""),
                 std::max({std::abs(overlap / collision.overlap() - 1), std::abs(lasted / duration - 1),
                           0.5 * std::abs(energy - 1)}),
                 steps * error_a_step(scene, 0.5 * collision.speed));
}

void collisions(Report& report, bool all) {
  report.section("Head-on, relative speed: overlap, duration and half the energy");
  Worst worst;
  for (const double young : {1e6, 1e8, 1e10, 200e9})
    for (const double speed : {1e-3, 0.1, 20.0}) {
      const Collision collision{young, speed};
      if (collision.overlap() > 0.5 * radius) continue;  // beyond small strain
      collide(report, worst, collision, 0);
      if (young == 200e9 || all) collide(report, worst, collision, 1000);
    }
  report.at_most("momentum, fraction of one body's, the worst of these", worst.momentum, 1e-12);
  // Order 5 and a tolerance of 1e-6: some 20 steps per quarter of the contact's cosine-like time dependence, and the
  // start.
  report.at_most("steps of the integrator, the most of these", worst.steps, 400);
}

/// 10 m/s each, with a field: contacts at a gap of R / 10 open and close during the flight, without forces.
void with_a_field(Report& report) {
  report.section("Steel at 10 m/s each, with a field and no drag");
  const Collision collision{200e9, 20};
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic}) {
    Scene scene = head_on(collision);
    scene.effects.add<effects::FloatingConductorsOptions>();
    scene.effects.add(effects::ContactDischargeOptions{.contact_distance = 0.1 * radius, .hysteresis = 0.05});
    scene.conductors[0].charge = 1e-12;
    scene.mechanics.coupling = coupling;
    Simulation simulation(scene, no_forces());
    simulation.advance_to(2 * initial_gap / collision.speed + collision.duration());
    const ConductorFrame frame = simulation.now();
    const Counters& counters = simulation.counters();
    const double energy = (norm2(frame.velocity[0]) + norm2(frame.velocity[1])) / 200;
    // At most 400 steps, as above, in each of the three intervals between two events.
    report.at_most(name_of(coupling) + ": energy", std::abs(energy - 1), 2 * 3 * 400 * error_a_step(scene, 10));
    report.at_most(name_of(coupling) + ": gap at the end, where it was",
                   std::abs(norm(frame.position[1] - frame.position[0]) - 2 * radius - initial_gap) / initial_gap,
                   3 * 400 * error_a_step(scene, 10));
    report.at_most(name_of(coupling) + ": contacts made, deviation from one", std::abs(counters.contacts_made - 1.0),
                   0);
    report.at_most(name_of(coupling) + ": contacts lost, deviation from one", std::abs(counters.contacts_lost - 1.0),
                   0);
    report.at_most(name_of(coupling) + ": charges, which the contact makes equal",
                   std::abs(frame.charge[0] - frame.charge[1]) / 1e-12, 1e-15);
  }
}

/// Integrates the same chain by velocity Verlet with a fixed step, in one coordinate.
std::vector<double> verlet(std::vector<double> x, std::vector<double> v, double young, double end, double dt) {
  const double k = stiffness(young);
  const auto acceleration = [&] {
    std::vector<double> a(x.size());
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const double push = k / mass * std::pow(std::max(0.0, 2 * radius - (x[i + 1] - x[i])), 1.5);
      a[i] -= push, a[i + 1] += push;
    }
    return a;
  };
  std::vector<double> a = acceleration();
  for (int n = static_cast<int>(std::ceil(end / dt)); n > 0; --n) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += dt * (v[i] + 0.5 * dt * a[i]);
    const std::vector<double> next = acceleration();
    for (std::size_t i = 0; i < x.size(); ++i) v[i] += 0.5 * dt * (a[i] + next[i]);
    a = next;
  }
  return v;
}

/// Twenty touching spheres in a row are struck by the first. The impact propagates as a solitary wave and ejects the
/// last.
void struck_chain(Report& report, double young, double speed) {
  const Collision collision{young, speed};
  std::vector<Vec2> positions;
  std::vector<double> x, v(20);
  for (int i = 0; i < 20; ++i) {
    x.push_back(0.01 + 2 * radius * i - (i == 0 ? initial_gap : 0));
    positions.push_back({x.back(), 0.05});
  }
  v[0] = speed;
  Scene scene = scene_of(positions);
  scene.conductors[0].velocity = {speed, 0};
  scene.effects.add(effects::HertzContactOptions{.young = young, .poisson = 0.3});
  const double end =
      initial_gap / speed + 40 * collision.duration();  // the wave passes a sphere in half a contact's duration
  Model model = effects::make_model(scene);
  mechanics::Cvode cvode = mechanics::make_cvode(scene, model);
  cvode.advance(0, end);
  // Second order: the error is 1e-4 at 0.01 of the contact's duration, and 1e-7 at this step.
  const std::vector<double> reference = verlet(x, v, young, end, collision.duration() / 4000);
  double momentum = 0, energy = 0, worst = 0;
  for (int i = 0; i < 20; ++i) {
    const double u = velocity(model.bodies, i).x / speed;
    momentum += u, energy += u * u;
    worst = std::max(worst, std::abs(u - reference[i] / speed));
  }
  const double bound = static_cast<double>(cvode.steps()) * error_a_step(scene, speed);
  const std::string name = fmt::format("Y = {:.0e} Pa, struck at {:g} m/s: ", young, speed);
  report.at_most(name + "momentum", std::abs(momentum - 1), 1e-12);
  report.at_most(name + "energy", std::abs(energy - 1), 2 * bound);
  report.at_most(name + "speeds", worst, bound);
  report.at_least(name + "the last one's, or nothing ran through", velocity(model.bodies, 19).x / speed, 0.9);
}

/// A chain in oil under a load from both ends until it rests: every contact carries the whole force F = k
/// overlap^(3/2).
void pressed_chain(Report& report, double young, double force, FieldCoupling coupling) {
  std::vector<Vec2> positions;
  for (int i = 0; i < 20; ++i) positions.push_back({0.01 + 2 * radius * i, 0.05});
  Scene scene = scene_of(positions);
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = 0.1 * radius, .hysteresis = 0.05});
  scene.effects.add<effects::StokesDragOptions>();
  scene.effects.add(effects::HertzContactOptions{.young = young, .poisson = 0.3});
  scene.mechanics.coupling = coupling;
  Simulation simulation(scene, scripted([&](const laplace::LaplaceProblem& problem) {
                          std::vector<Vec2> forces(problem.bodies.size());
                          forces.front().x = force, forces.back().x = -force;
                          return forces;
                        }));
  simulation.advance_to(2);
  const ConductorFrame frame = simulation.now();
  const double overlap = std::pow(force / stiffness(young), 2.0 / 3);
  double worst = 0;
  for (int i = 0; i + 1 < 20; ++i)
    worst = std::max(worst, std::abs(2 * radius - norm(frame.position[i + 1] - frame.position[i]) - overlap));
  // At rest errors decay instead of adding up: only that of the last step remains, of two bodies.
  report.at_most(fmt::format("Y = {:.0e} Pa, pressed by {:g} N, {}: overlap", young, force, name_of(coupling)),
                 worst / overlap, 2 * scene.mechanics.relative_tolerance * radius / overlap);
}

/// Two overlapping spheres are released from rest: the elastic energy becomes kinetic energy.
void released_overlap(Report& report) {
  Scene scene = scene_of({{0.05, 0.05}, {0.05 + 1.9 * radius, 0.05}});
  scene.effects.add(effects::HertzContactOptions{.young = 1e8, .poisson = 0.3});
  Model model = effects::make_model(scene);
  mechanics::Cvode cvode = mechanics::make_cvode(scene, model);
  cvode.advance(0, 0.01);
  const double energy = 0.4 * stiffness(1e8) * std::pow(0.1 * radius, 2.5), speed = std::sqrt(energy / mass);
  const double moved = norm2(velocity(model.bodies, 0)) + norm2(velocity(model.bodies, 1));
  report.at_most("an overlap of R / 10 let go: energy", std::abs(moved / (2 * speed * speed) - 1),
                 2 * static_cast<double>(cvode.steps()) * error_a_step(scene, speed));
}

/// Contacts so soft and fast that the centres would pass each other (or the wall): every integrator reports an error.
void too_soft(Report& report, Integrator integrator, bool wall) {
  Scene scene = head_on({1e6, 40});
  scene.effects.add(effects::WallContactOptions{.young = 1e6, .poisson = 0.3});
  scene.mechanics.integrator = integrator;
  if (wall) scene.conductors.pop_back();
  double said = 0;
  try {
    Simulation(scene).advance_to(0.01);
  } catch (const Failure& failure) {
    said = std::string(failure.what()).find("too soft") != std::string::npos;
  }
  report.at_least(
      fmt::format("Y = 1e6 Pa, 20 m/s, {} by {}: said", wall ? "into a wall" : "head-on", name_of(integrator)), said,
      1);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Elastic contacts at their limits: errors as fractions");
  collisions(report, all);
  with_a_field(report);
  report.section("Twenty in contact");
  for (const double young : {1e6, 200e9}) struck_chain(report, young, 0.1);
  if (all) struck_chain(report, 200e9, 10);
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic}) {
    pressed_chain(report, 1e6, 1e-4, coupling);
    pressed_chain(report, 200e9, 0.1, coupling);
  }
  report.section("An overlap at the start, and overlaps too deep");
  released_overlap(report);
  for (const Integrator integrator : {Integrator::cvode, Integrator::euler})
    for (const bool wall : {false, true}) too_soft(report, integrator, wall);
  return report.exit_status();
}

const lichtenberg::validation::Program program("hard_cases_collisions", validate);

}  // namespace hard_cases_collisions_validation
