// Charges in limiting cases in time. A conductor transports charge back and forth a thousand times; opposite charges
// collapse onto each other; one body among twenty thousand is much faster than the others.
//
//   hard_cases_coulomb         with scripted forces, seconds
//   hard_cases_coulomb long    also a thousand bounces in the cut-cell field

#include <chrono>
#include <numbers>

#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace hard_cases_coulomb_validation {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using namespace lichtenberg::validation;

namespace {

// ---- a thousand bounces

constexpr double height = 0.02, high_voltage = 100.0;  // m, V

/// One conductor between two plates, as a point charge in a homogeneous field: a plate gives it the charge -q at 0 V or
/// q at 100 V, and then repels it with the force F = `terminal` * drag.
class Plates : public laplace::LaplaceSolver {
 public:
  static constexpr double q = 1e-11, terminal = 0.05;  // C, m/s
  laplace::LaplaceSolution solve(const laplace::LaplaceProblem& problem) override {
    const laplace::Group& group = problem.groups[problem.bodies[0].group];
    const double depth = 2 * radius, held = group.potential > 0.5 * high_voltage ? q : -q;
    const double charge = group.floating ? group.charge : held / depth;
    laplace::LaplaceSolution solution;
    solution.body_charge = {charge};
    solution.body_force = {{0, -terminal * drag * charge / q}};
    solution.group_potential.resize(problem.groups.size());
    return solution;
  }
  laplace::Field field() const override { return {}; }
  void forget() override {}
};

Scene between_plates() {
  Scene scene = conductor_scene({{0.5 * height, 0.5 * height}});
  scene.domain.size = {height, height};
  scene.domain.sides[2] = {.electrode = true, .potential = 0};
  scene.domain.sides[3] = {.electrode = true, .potential = high_voltage};
  scene.effects.add<effects::WallContactOptions>();
  scene.conductors[0].charge = -Plates::q;
  return scene;
}

struct Bounces {
  double unbalanced = 0;  ///< largest value of all frames
  double miscounted = 0;  ///< frames with impossible numbers of contacts made and lost
  Counters counters;
  ConductorFrame end;
};

/// Runs until `end` and checks the state at `frames` instants. `scale`: magnitude of the charges, C.
Bounces bounce(Simulation& simulation, double end, int frames, double scale) {
  Bounces bounces;
  const double initial = total(simulation.now().charge) + simulation.now().charge_drained;
  for (int k = 1; k <= frames; ++k) {
    simulation.advance_to(end * k / frames);
    const Counters& c = simulation.counters();
    const auto open = c.contacts_made - c.contacts_lost;
    bounces.unbalanced = std::max(bounces.unbalanced, imbalance(simulation.now(), initial) / scale);
    bounces.miscounted += open != (simulation.now().group[0] == -1 ? 1 : 0);
  }
  bounces.counters = simulation.counters();
  bounces.end = simulation.now();
  return bounces;
}

/// Returns the time (s) between contacts. With the terminal speed w and the relaxation time tau, force and velocity are
/// opposed after a contact: v = -w + 2 w exp(-t / tau) toward the plate. If the gap is large, the velocity reverses
/// after w tau (1 - ln 2), with a delay of 2 tau over the distance D. Otherwise the body strikes the plate across the
/// gap g after t with w tau (2 - 2 exp(-t / tau)) - w t = g. It returns at the same speed after Hertz's 2.943275
/// overlap / v, followed by D + g at w, plus (1 - v / w) tau for the initial lack of speed.
double crossing_time(double between, double gap) {
  const double w = Plates::terminal, tau = relaxation;
  const auto displacement = [&](double t) { return 2 * w * tau * -std::expm1(-t / tau) - w * t; };
  double before = 0, after = tau * std::numbers::ln2;
  if (displacement(after) <= gap) return between / w + 2 * tau;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (before + after);
    (displacement(middle) < gap ? before : after) = middle;
  }
  const double speed = w * (2 * std::exp(-before / tau) - 1);
  const double k = 4.0 / 3.0 * effects::contact_modulus({200e9, 0.3}, {200e9, 0.3}) * std::sqrt(radius);
  const double touching = 2.943275 * std::pow(5 * mass * speed * speed / (4 * k), 0.4) / speed;
  return before + touching + (between + gap) / w + (1 - speed / w) * tau;
}

void thousand_bounces(Report& report, FieldCoupling coupling, double contact_gap, int contacts) {
  Scene scene = between_plates();
  scene.effects.find<effects::ContactDischargeOptions>()->contact_distance = contact_gap;
  scene.mechanics.coupling = coupling;
  Simulation simulation(scene, std::make_unique<Plates>());
  const double w = Plates::terminal, between = height - 2 * radius - 2 * contact_gap;
  const double first = 0.5 * between / w + relaxation, crossing = crossing_time(between, contact_gap);
  // In the middle between two contacts in time: the delay of the reversal is over, and the speed is w.
  const double end = first + (contacts - 0.5) * crossing;
  const Bounces bounces = bounce(simulation, end, 5 * contacts, Plates::q);
  const auto made = static_cast<double>(bounces.counters.contacts_made);
  const double from_the_next = contact_gap + 0.5 * crossing * w, up = contacts % 2 == 0 ? 1 : -1;
  const double expected_position = up > 0 ? height - radius - from_the_next : radius + from_the_next;
  const double off = std::abs(bounces.end.position[0].y - expected_position);
  const std::string name = fmt::format("{}, contact at {:g} R: ", name_of(coupling), contact_gap / radius);
  report.at_most(name + "imbalance, fraction of the charge", bounces.unbalanced, 1e-12);
  report.at_most(name + fmt::format("contacts beside {}", contacts), std::abs(made - contacts), 0);
  report.at_most(name + "frames with impossible counts", bounces.miscounted, 0);
  // Each contact may be a tolerance early, and positions have an error of 1e-6 R in each of some 200 steps between
  // contacts.
  report.at_most(name + "place at the end, tolerances", off / scene.mechanics.position_tolerance, 1.2 * contacts);
  // The first step after a force jump of 2 F is R / w sqrt(tolerance / R) = 0.5 ms (0.07 ms if a small gap replaces R).
  // It takes 8 (11) doublings to the longest step, 0.1 s, and 4 of these for the remaining time; then contact, opening
  // and a few retries.
  if (coupling == FieldCoupling::split)
    report.at_most(name + "field solves a contact", static_cast<double>(bounces.counters.field_solves) / made, 20);
}

/// A thousand bounces in the field of D 4: the number of contacts is not known in advance, but charge is conserved.
void thousand_bounces_in_the_field(Report& report, int contacts) {
  Scene scene = between_plates();
  scene.domain.sides[3].potential = 18e3;
  scene.conductors[0].charge = 1e-10;
  scene.conductors[0].position.y = 0.3 * height;
  scene.field().cells = 64;
  Simulation simulation(scene);
  Bounces bounces;
  double time = 0;
  int looks = 0;
  const double initial = scene.conductors[0].charge;
  for (; simulation.counters().contacts_made < contacts && looks < 20 * contacts; ++looks) {
    simulation.advance_to(time += 0.1);
    const ConductorFrame frame = simulation.now();
    const auto open = simulation.counters().contacts_made - simulation.counters().contacts_lost;
    bounces.unbalanced = std::max(bounces.unbalanced, imbalance(frame, initial));
    bounces.miscounted += open != (frame.group[0] == -1 ? 1 : 0);
  }
  const Counters& c = simulation.counters();
  const std::string name = fmt::format("cut-cell field, {} contacts in {:.3g} s: ", c.contacts_made, time);
  const double carried = std::abs(simulation.now().charge[0]);
  report.at_least(name + "number of contacts, at least that required", static_cast<double>(c.contacts_made), contacts);
  report.at_most(name + "imbalance, fraction of its charge", bounces.unbalanced / carried, 1e-12);
  report.at_most(name + "frames with impossible counts", bounces.miscounted, 0);
  // The force on the grid varies from cell to cell, 54 on the path: four solves each, and 20 as above.
  const double cells = (height - 4 * radius) / (height / scene.field().cells);
  report.at_most(name + "field solves a contact",
                 static_cast<double>(c.field_solves) / static_cast<double>(c.contacts_made), 4 * cells + 20);
}

// ---- collapse

/// Two bodies that attract each other with the force A / gap.
std::unique_ptr<laplace::LaplaceSolver> attraction(double strength) {
  return scripted([=](const laplace::LaplaceProblem& problem) {
    const double gap = (centre(problem, 1) - centre(problem, 0)).x - 2 * radius;
    const bool one = problem.bodies[0].group == problem.bodies[1].group;
    const double force = one ? 0 : strength / gap;
    return std::vector<Vec2>{{force, 0}, {-force, 0}};
  });
}

struct Fall {
  std::string name;
  bool in_oil;
  double largest_step;  ///< s
};

/// Returns two bodies 4 R apart that merge into one group at `last_gap`.
Scene falling(const Fall& fall, FieldCoupling coupling, double last_gap) {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + 6 * radius, 0.05}});
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = last_gap, .hysteresis = 0.05});
  scene.mechanics.coupling = coupling;
  scene.mechanics.largest_step = fall.largest_step;
  if (fall.in_oil)
    scene.material.density *= 1e-6;  // relaxation in a nanosecond
  else
    scene.effects.remove<effects::StokesDragOptions>();
  return scene;
}

/// Time from a gap s_0 to contact at s.
///   In oil, without inertia:  d(gap)/dt = -2 A / (drag gap),   t = drag (s_0^2 - s^2) / 4 A.
///   Without oil:  m/4 v^2 = A ln(s_0 / s),   t = s_0 sqrt(pi m / 4 A) erf(sqrt(ln(s_0 / s))).
/// Each of n steps displaces both bodies by at most d. In oil, a displacement at s' grows by s'/s until s: the change
/// of s ds is at most 2 n s_0 d, which corresponds to the time n s_0 d drag / A. Without oil, an error of 2 d of the
/// gap at rest changes the time by the fraction 2 d / s_0, later errors by less. In split coupling d is the position
/// tolerance. In monolithic coupling n is at most the number of solves, and d is 1e-6 R plus the effect of 1e-6 of the
/// momentum. Without oil another 1e-6 R is added (stepper.hpp), which displaces by 1e-6 of the path.
void collapse(Report& report, const Fall& fall, FieldCoupling coupling, double last_gap) {
  const double first_gap = 4 * radius, strength = 1e-8;
  const Scene scene = falling(fall, coupling, last_gap);
  const double time = fall.in_oil ? drag * (first_gap * first_gap - last_gap * last_gap) / (4 * strength)
                                  : first_gap * std::sqrt(std::numbers::pi * mass / (4 * strength)) *
                                        std::erf(std::sqrt(std::log(first_gap / last_gap)));
  // Finds the instant of contact to 1e-9 by bisection.
  double before = 0.9 * time, after = 1.1 * time, n = 0;
  while (after - before > 1e-9 * time) {
    const double middle = 0.5 * (before + after);
    Simulation simulation(scene, attraction(strength));
    simulation.advance_to(middle);
    const Counters& counters = simulation.counters();
    (counters.contacts_made > 0 ? after : before) = middle;
    n = std::max(n, static_cast<double>(coupling == FieldCoupling::split ? counters.steps : counters.field_solves));
  }
  const double d = coupling == FieldCoupling::split
                       ? scene.mechanics.position_tolerance
                       : scene.mechanics.relative_tolerance * (2 * radius + 0.5 * first_gap);
  report.at_most(
      fmt::format("{}, {}, to {:g} R: time of {:.3g} s", fall.name, name_of(coupling), last_gap / radius, time),
      std::abs(before - time), fall.in_oil ? n * first_gap * d * drag / strength : n * 2 * d / first_gap * time);
}

/// Two bodies approach each other against repulsion, from 40 R: m u^2 = A ln(s_0 / s), so they reverse at s = 1.05
/// contact gaps. Far away the force varies little, and extrapolation predicts a contact.
void turn_back(Report& report, FieldCoupling coupling, double largest_step) {
  Scene scene = falling({"", false, largest_step}, coupling, radius);
  scene.conductors[0].position.x = 0.02;
  scene.conductors[1].position.x = 0.02 + 42 * radius;
  const double strength = 1e-7, speed = std::sqrt(strength * std::log(40 / 1.05) / mass);
  scene.conductors[0].velocity.x = speed;
  scene.conductors[1].velocity.x = -speed;
  Simulation simulation(scene, attraction(-strength));
  simulation.advance_to(0.2);
  const ConductorFrame frame = simulation.now();
  const double gap = norm(frame.position[1] - frame.position[0]) - 2 * radius;
  const double energy = 0.5 * mass * (norm2(frame.velocity[0]) + norm2(frame.velocity[1])) - strength * std::log(gap);
  const double at_first = mass * speed * speed - strength * std::log(40 * radius);
  const std::string name = fmt::format("{}, steps up to {:g} s: ", name_of(coupling), largest_step);
  report.at_most(name + "contacts", static_cast<double>(simulation.counters().contacts_made), 0);
  // A displacement d of both bodies changes the energy by 2 d A / gap, at most 2 d A / R, per step.
  const double d = coupling == FieldCoupling::split ? scene.mechanics.position_tolerance : 4e-6 * radius;
  const double n =
      static_cast<double>(coupling == FieldCoupling::split ? simulation.counters().steps : frame.field_solves);
  report.at_most(name + "energy, fraction", std::abs(energy - at_first) / (mass * speed * speed),
                 n * 2 * d * strength / radius / (mass * speed * speed));
  report.at_least(name + "gap, or no reversal, R", gap / radius, 10);
}

// ---- one that is faster than all others

/// Returns the time (s) of a search for possible contacts.
double search_time(const effects::ContactDischarge& discharge, const Scene& scene, std::vector<double> travel) {
  const Bodies bodies = make_bodies(scene);
  const effects::ElectricalGroups groups = effects::electrical_groups(scene, {});
  double least = INFINITY;
  for (int k = 0; k < 5; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const auto found = discharge.watch(bodies, {}, groups, travel);
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (found.empty()) return INFINITY;  // some neighbours are within range
  }
  return least;
}

/// Twenty thousand bodies that may move by R / 100 per step, without and with one that may cross the whole domain.
void fast_body(Report& report) {
  Scene scene = conductor_scene({});
  scene.domain.size = {0.5, 0.5};
  for (int i = 0; i < 20000; ++i)
    scene.conductors.push_back(
        {.position = {0.01 + i % 150 * 3.015 * radius, 0.01 + i / 150 * 3.015 * radius}, .radius = radius});
  const effects::ContactDischarge discharge(scene);
  std::vector<double> travel(20000, 0.01 * radius);
  const double without = search_time(discharge, scene, travel);
  travel[0] = 0.5;
  // The fast body adds one search over all bodies: the same work again, and sorting a list of 20000. A quadratic search
  // would take 10000 times as long; the bound between them allows for a busy machine.
  report.at_most("search with one fast body, times that without", search_time(discharge, scene, travel) / without, 10);
}

/// A fast sphere strikes a resting one of its group, which then flies past a third. This contact cannot be predicted.
/// The three share the third's charge evenly while they touch.
void struck(Report& report, FieldCoupling coupling) {
  const double gap = 0.02 * radius, dip = 0.5 * gap;
  Scene scene = scene_of({{0.02, 0.05}, {0.03, 0.05}, {0.04, 0.05 + 2 * radius + dip}});
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = gap, .hysteresis = 0.05});
  scene.mechanics.coupling = coupling;
  scene.groups = {{.name = "wire", .charge = 0.0}};
  scene.conductors[0].group = scene.conductors[1].group = 0;
  scene.conductors[0].velocity = {1, 0};
  scene.conductors[2].charge = 3e-12;
  Simulation simulation(scene, no_forces());
  simulation.advance_to(0.03);
  report.at_most(name_of(coupling) + ": charge left on a sphere flown past, deviation from a third",
                 std::abs(simulation.now().charge[2] / 3e-12 - 1.0 / 3), 1e-15);
}

/// A body at rest 6 R from a grounded ball, in a trap that reverses it at 3.5 R; a contact would occur at 3 R. The
/// initial force, constant over the first long step, would lead to that contact.
void trap(Report& report, FieldCoupling coupling) {
  Scene scene = conductor_scene({{0.05 - 6 * radius, 0.05}});
  scene.effects.remove<effects::StokesDragOptions>();
  scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
  scene.mechanics.coupling = coupling;
  scene.mechanics.largest_step = 10;
  Simulation simulation(
      scene, scripted([](const laplace::LaplaceProblem& problem) {
        return std::vector<Vec2>{{-1e-3 * (centre(problem, 0).x - (0.05 - 4.75 * radius)), 0}, {0, 0}};
      }));
  simulation.advance_to(10);
  report.at_most(name_of(coupling) + ", in a trap, 13 swings: contacts",
                 static_cast<double>(simulation.counters().contacts_made), 0);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Charges at their limits in time");
  report.section("A conductor that bounces between two plates");
  thousand_bounces(report, FieldCoupling::split, radius, 1000);
  thousand_bounces(report, FieldCoupling::split, 0.02 * radius, 1000);
  thousand_bounces(report, FieldCoupling::monolithic, radius, all ? 1000 : 100);
  thousand_bounces_in_the_field(report, all ? 1000 : 50);
  report.section("Opposite charges fall on each other, force A / gap");
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic})
    for (const double last_gap : {radius, 0.1 * radius, 0.01 * radius})
      for (const Fall& fall : {Fall{"in oil", true, 0.1}, Fall{"no drag", false, 0.1}, Fall{"long steps", false, 100}})
        collapse(report, fall, coupling, last_gap);
  report.section("Reversal before contact: like charges with velocities towards each other");
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic})
    for (const double largest_step : {0.1, 100.0}) turn_back(report, coupling, largest_step);
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic}) trap(report, coupling);
  report.section("Fast bodies");
  for (const FieldCoupling coupling : {FieldCoupling::split, FieldCoupling::monolithic}) struck(report, coupling);
  fast_body(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("hard_cases_coulomb", validate);

}  // namespace hard_cases_coulomb_validation
