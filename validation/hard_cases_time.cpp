// Limiting cases in time: contacts that coincide, graze, or occur at an output time; charges that collapse onto each
// other; a run resumed in the middle of a contact.
//
//   hard_cases_time         with scripted forces and line charges, seconds
//   hard_cases_time long    more seeds, the cut-cell field, the reference coupling throughout
//
// Positions have an error of position_tolerance (1e-3 radius here) per coupling step, so event times have this error
// over the speed. The integrator has a relative_tolerance of 1e-6 per step.

#include <array>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace hard_cases_time_validation {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using namespace lichtenberg::validation;

namespace {

const std::array<std::string, 3> schemes = {"split", "monolithic", "euler"};

/// Returns `scene` with split or monolithic coupling of CVODE, or with Euler's method.
Scene with_scheme(const std::string& scheme, Scene scene) {
  if (scheme == "euler")
    scene.mechanics.integrator = Integrator::euler;
  else
    scene.mechanics.coupling = value_of<FieldCoupling>(scheme).value();
  return scene;
}

// ---- rest

/// Without charges and motion for a thousand seconds: the state is bitwise unchanged, and steps reach their maximum.
void rest(Report& report, const std::string& scheme) {
  Scene scene = with_scheme(scheme, conductor_scene({{0.03, 0.05}, {0.03 + 3 * radius, 0.05}, {0.05, 0.05}}));
  scene.electrodes = {ball("ground", {0.05, 0.05 + 2.5 * radius}, 0)};
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add<effects::WallContactOptions>();
  scene.mechanics.largest_step = scene.mechanics.euler_field_step = 10;
  scene.mechanics.euler_step = 0.1;
  Simulation simulation(scene, std::make_unique<LineCharges>());
  const ConductorFrame before = simulation.now();
  simulation.advance_to(1000);
  const ConductorFrame after = simulation.now();
  report.at_most(scheme + ": moved, m", largest_distance(before, after), 0);
  report.at_most(scheme + ": charge, C", std::abs(total(after.charge)) + std::abs(after.charge_drained), 0);
  // One solve per step of 10 s, and the first one. CVODE begins with short steps that grow tenfold.
  report.at_most(scheme + ": field solves", static_cast<double>(after.field_solves), 120);
}

// ---- simultaneous events

/// A charged conductor in the middle, and two or four that arrive from all sides simultaneously.
void simultaneous(Report& report, const std::string& scheme, int arms) {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.conductors[0].charge = 4e-11;
  for (int k = 0; k < arms; ++k) {
    const Vec2 outward = k % 2 == 0 ? Vec2{k < 2 ? 1.0 : -1.0, 0} : Vec2{0, k < 2 ? 1.0 : -1.0};
    const Vec2 side = arms == 2 && k == 1 ? Vec2{-1, 0} : outward;
    scene.conductors.push_back({.position = scene.conductors[0].position + in_space(4 * radius * side),
                                .velocity = in_space(-0.02 * side),
                                .radius = radius});
  }
  scene.effects.remove<effects::StokesDragOptions>();
  scene.effects.add<effects::HertzContactOptions>();
  Simulation simulation(with_scheme(scheme, scene), std::make_unique<LineCharges>());
  simulation.advance_to(0.06);  // the path is one radius, 39 ms
  const ConductorFrame frame = simulation.now();
  const Counters& counters = simulation.counters();
  const std::string name = fmt::format("{}, {} at once: ", scheme, arms);
  report.at_most(name + "contacts missing", static_cast<double>(arms - counters.contacts_made), 0);
  if (scheme != "euler") report.at_most(name + "regroupings", static_cast<double>(counters.regroupings), 1);
  // Symmetric up to the rounding of a linear solve for a few charges, amplified over at most some hundred steps.
  double uneven = 0;
  for (int k = 1; k <= arms; ++k) uneven = std::max(uneven, std::abs(frame.charge[k] / frame.charge[1] - 1));
  report.at_most(name + "difference of their charges, fraction", uneven, 1e-10);
  report.at_most(name + "the middle one moved, radii", norm(frame.position[0] - scene.conductors[0].position) / radius,
                 1e-10);
  report.at_most(name + "charge lost, fraction", imbalance(frame, 4e-11) / 4e-11, 1e-15);
}

// ---- grazing

/// A charged conductor flies past a grounded ball on a straight line with a smallest gap of (1 + off) contact gaps. A
/// dip below by more than the position tolerance opens and closes one contact; a distance above by more than the
/// tolerance makes none. Between these either is right, but no event occurs twice.
void graze(Report& report, const std::string& scheme, double speed) {
  double missed = 0, invented = 0, twice = 0, solves = 0, lost = 0;
  for (const double off : {-0.5, -0.1, -1e-2, -2e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 2e-3, 1e-2})
    for (const double height : {0.011, 0.0123, 0.0137}) {
      Scene scene = conductor_scene({{0.05 + 2 * radius + (1 + off) * radius, height}});
      scene.effects.remove<effects::StokesDragOptions>();
      scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
      scene.conductors[0].velocity = {0, speed};
      scene.conductors[0].charge = 1e-11;
      Simulation simulation(with_scheme(scheme, scene), no_forces());
      simulation.advance_to(0.075 / speed);
      const Counters& c = simulation.counters();
      const bool deep = off * radius < -scene.mechanics.position_tolerance;
      const bool clear = off * radius > scene.mechanics.position_tolerance;
      missed += deep && c.contacts_made == 0;
      invented += clear && c.contacts_made > 0;
      twice += c.contacts_made > 1 || c.contacts_made != c.contacts_lost;
      solves = std::max(solves, static_cast<double>(c.field_solves) - 0.075 / speed / scene.mechanics.largest_step);
      lost = std::max(lost, imbalance(simulation.now(), 1e-11) / 1e-11);
    }
  const std::string name = fmt::format("{}, {:g} m/s: ", scheme, speed);
  report.at_most(name + "contacts missed", missed, 0);
  report.at_most(name + "contacts without cause", invented, 0);
  report.at_most(name + "made twice, or not lost", twice, 0);
  report.at_most(name + "charge lost, fraction", lost, 1e-15);
  // Besides one solve per longest step: the first, that of the contact, and those while steps double from the shortest.
  if (scheme == "split") report.at_most(name + "field solves", solves, 60);
}

// ---- an event at an output time

/// Straight flight into contact with a grounded ball at exactly t = 0.2, with frames every 0.1, 0.05, 0.2 s, or one
/// frame.
void at_an_output_time(Report& report, const std::string& scheme) {
  double events = 0, wrong = 0, differs = 0;
  std::vector<ConductorFrame> ends;
  for (const int frames : {1, 2, 4, 8, 3}) {
    const double speed = 0.0625, meet = 0.2;  // exact in binary, except for the time of contact
    Scene scene = conductor_scene({{0.05 - 3 * radius - speed * meet, 0.05}});
    scene.effects.remove<effects::StokesDragOptions>();
    scene.conductors[0].velocity = {speed, 0};
    scene.conductors[0].charge = 1e-11;
    scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
    Simulation simulation(with_scheme(scheme, scene), scripted([&](const laplace::LaplaceProblem& p) {
                            const bool charged = p.groups[p.bodies[0].group].charge != 0;  // a fixed one has none
                            return std::vector<Vec2>{{charged ? 0.0 : -1e-6, 0}, {0, 0}};
                          }));
    for (int k = 1; k <= frames; ++k) {
      const double end = 0.4 * k / frames;
      simulation.advance_to(end);
      const ConductorFrame frame = simulation.now();
      const bool held = frame.group[0] == -1;
      if (frame.time != end || imbalance(frame, 1e-11) > 1e-26) ++wrong;
      if ((simulation.counters().contacts_made > 0) != (frame.charge[0] == 0)) ++wrong;  // the contact discharges it
      if (std::abs(end - meet) > 0.03 && end < meet && held) ++wrong;
    }
    ends.push_back(simulation.now());
    events = std::max(events, static_cast<double>(simulation.counters().contacts_made));
    differs = std::max(differs, largest_distance(ends.front(), ends.back()) / scene.mechanics.position_tolerance);
  }
  report.at_most(scheme + ": contacts made", events, 1);
  report.at_most(scheme + ": frames at odds with themselves", wrong, 0);
  // The contact may occur one tolerance early; the body then moves back for 0.2 s by the same displacement.
  if (scheme != "euler") report.at_most(scheme + ": end, by number of frames, tolerances", differs, 5);
}

// ---- starts

/// Two bodies are at t = 0 exactly at the contact gap or one rounding off, at rest or in motion.
void starts(Report& report, const std::string& scheme) {
  double missing = 0, invented = 0, twice = 0;
  for (const double off : {-1e-15, 0.0, 1e-15})
    for (const double speed : {-0.01, 0.0, 0.01}) {
      Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + 3 * radius + off, 0.05}});
      scene.effects.remove<effects::StokesDragOptions>();
      scene.conductors[1].velocity = {speed, 0};
      Simulation simulation(with_scheme(scheme, scene), no_forces());
      const bool touching =
          norm(plane(scene.conductors[1].position - scene.conductors[0].position)) - 2 * radius <= radius;
      const auto made_at_once = [&] { return simulation.now().group[1] == 0; };
      if ((touching || speed < 0) && !made_at_once()) ++missing;
      if (!touching && speed >= 0 && made_at_once()) ++invented;
      simulation.advance_to(0.05);
      twice += simulation.counters().contacts_made > 1 || simulation.counters().contacts_lost > 1;
    }
  report.at_most(scheme + ", at the contact gap: contacts missing", missing, 0);
  report.at_most(scheme + ", at the contact gap: without cause", invented, 0);
  report.at_most(scheme + ", at the contact gap: made or lost twice", twice, 0);
}

// ---- lost and made at once

/// A body moves from a ball at 0 V to one at 100 V. The first contact opens where the second closes, to within `off`
/// (m). The body must give up the charge from the first, without a short circuit.
void handed_over(Report& report, const std::string& scheme) {
  double wrong = 0, lost = 0;
  for (const double off : {-1e-9, 0.0, 1e-9, 1e-6}) {
    const double between = 4 * radius + radius + 1.01 * radius + off;  // distance of the balls' centres
    Scene scene = conductor_scene({{0.05 + 2.5 * radius, 0.05}});
    scene.effects.remove<effects::StokesDragOptions>();
    scene.electrodes = {ball("from", {0.05, 0.05}, 0), ball("to", {0.05 + between, 0.05}, 100)};
    scene.conductors[0].velocity = {0.02, 0};
    scene.conductors[0].charge = 1e-11;
    Simulation simulation(with_scheme(scheme, scene), std::make_unique<LineCharges>());
    simulation.advance_to(0.02);  // 0.4 mm from the start; the transfer has occurred
    const ConductorFrame frame = simulation.now();
    // LineCharges has an error of 1e-9 per solve, of which there have been some hundreds.
    wrong += std::abs(frame.potential[0]) > 1e-4 && std::abs(frame.potential[0] - 100) > 1e-4;
    wrong += frame.group[0] != -1;
    simulation.advance_to(0.03);
    wrong += std::abs(simulation.now().potential[0] - 100) > 1e-4;
    wrong += simulation.counters().contacts_made != 2 || simulation.counters().contacts_lost != 1;
    lost = std::max(lost, imbalance(simulation.now(), 1e-11) / 1e-11);
  }
  report.at_most(scheme + ", one contact lost where the next is made: wrong", wrong, 0);
  report.at_most(scheme + ", the same: charge lost, fraction", lost, 1e-12);
}

// ---- sides of the domain

/// Oblique motion without drag in a box with grounded sides: contacts with each side follow a straight line among
/// mirror images. A second case hits a corner, two sides simultaneously; the second contact may go unrecorded, because
/// it joins bodies of one group.
void sides(Report& report, const std::string& scheme) {
  const double free_width = 0.02 - 2 * radius, gap = 0.1 * radius, time = 1;
  for (const Vec2 v : {Vec2{0.3, 0.17}, Vec2{0.2, 0.2}}) {
    Scene scene = conductor_scene({{0.01, 0.01}});
    scene.domain.size = {0.02, 0.02};
    for (DomainSide& side : scene.domain.sides) side = {.electrode = true, .potential = 0};
    scene.effects.remove<effects::StokesDragOptions>();
    scene.effects.add<effects::WallContactOptions>();
    scene.effects.find<effects::ContactDischargeOptions>()->contact_distance = gap;
    scene.conductors[0].velocity = in_space(v);
    scene.conductors[0].charge = 1e-11;
    Simulation simulation(with_scheme(scheme, scene), no_forces());
    simulation.advance_to(time);
    // From the middle: the first contact after half the clearance less the gap, then one per clearance.
    const auto hits = [&](double speed) {
      return std::floor((speed * time - 0.5 * free_width + gap) / free_width) + 1;
    };
    const ConductorFrame frame = simulation.now();
    const std::string name = fmt::format("{}, box with grounded sides, {:g} : {:g}: ", scheme, v.x, v.y);
    const double made = static_cast<double>(simulation.counters().contacts_made);
    if (v.x != v.y)
      report.at_most(name + "contacts, deviation from the expected number", std::abs(made - hits(v.x) - hits(v.y)), 0);
    report.at_most(name + "charge left", std::abs(frame.charge[0]), 0);
    // At most 29 collisions with at most 400 steps of 1e-6 each (hard_cases_collisions).
    report.at_most(name + "energy", std::abs(norm2(frame.velocity[0]) / norm2(v) - 1), 2 * 29 * 400e-6);
  }
}

/// Two sides at different potentials in a corner: a short circuit with an error message.
void short_circuit(Report& report, const std::string& scheme) {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.domain.sides[0] = {.electrode = true, .potential = 0};
  scene.domain.sides[2] = {.electrode = true, .potential = 10};
  scene.effects.remove<effects::StokesDragOptions>();
  scene.conductors[0].velocity = {-0.1, -0.1};
  Simulation simulation(with_scheme(scheme, scene), no_forces());
  double said = 0;
  try {
    simulation.advance_to(1);
  } catch (const Failure& failure) {
    said = std::string(failure.what()).find("short circuit") != std::string::npos;
  }
  report.at_least(scheme + ", into a corner of two potentials: short circuit said", said, 1);
}

// ---- cut in two

/// Two charged bodies collide in a field: a checkpoint in the middle of their overlap. Then a dense system, at many
/// instants.
void resumed(Report& report, const std::string& scheme, const Scene& scene, double cut, double end, const char* what) {
  const auto differ = [&](const Scene& s) {
    Simulation whole(s, std::make_unique<LineCharges>()), second(s, std::make_unique<LineCharges>());
    whole.advance_to(cut);
    const Checkpoint middle = whole.checkpoint();
    second.restore(middle);
    whole.advance_to(end);
    second.advance_to(end);
    const Checkpoint a = whole.checkpoint(), b = second.checkpoint();
    return a.reals != b.reals || a.integers != b.integers;
  };
  report.at_most(fmt::format("{}, resumed {}: not bit for bit", scheme, what),
                 differ(with_scheme(scheme, scene)) ? 1 : 0, 0);
}

Scene colliding() {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + 2 * radius + 1e-4, 0.05}});
  scene.effects.remove<effects::StokesDragOptions>();
  scene.effects.find<effects::ContactDischargeOptions>()->contact_distance = 0.05 * radius;
  scene.effects.add(effects::HertzContactOptions{.young = 1e6, .poisson = 0.3});  // the contact lasts 1 ms
  scene.conductors[0].velocity = {0.1, 0};
  scene.conductors[0].charge = 1e-12;
  return scene;
}

// ---- seeds

/// Random dense systems around a grounded ball: repeated runs are identical, contact counts are consistent, charge is
/// conserved.
void random_scenes(Report& report, const std::string& scheme, int seeds, double end) {
  double differ = 0, miscounted = 0, unbalanced = 0, events = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Scene scene = with_scheme(scheme, random_spheres(static_cast<unsigned>(seed)));
    std::array<Checkpoint, 2> ends;
    for (Checkpoint& checkpoint : ends) {
      Simulation simulation(scene, std::make_unique<LineCharges>());
      simulation.advance_to(end);
      const ConductorFrame frame = simulation.now();
      const Counters& c = simulation.counters();
      const auto open = simulation.contacts().size();
      miscounted += c.contacts_made - c.contacts_lost != static_cast<std::int64_t>(open);
      const double initial = 12 * 2e-12;
      unbalanced = std::max(unbalanced, imbalance(frame, initial) / (frame.charge_fed + initial));
      events += static_cast<double>(c.contacts_made + c.contacts_lost);
      checkpoint = simulation.checkpoint();
    }
    differ += ends[0].reals != ends[1].reals || ends[0].integers != ends[1].integers;
  }
  const std::string name = fmt::format("{}, {} crowds: ", scheme, seeds);
  report.at_most(name + "twice the same scene, not the same bits", differ, 0);
  report.at_most(name + "contacts that do not add up", miscounted, 0);
  report.at_most(name + "imbalance, fraction of all charge", unbalanced, 1e-12);
  report.at_least(name + "contacts made and lost (or nothing was tested)", events, 2.0 * seeds);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Time at its limits");
  report.section("Rest for a thousand seconds");
  for (const std::string& scheme : schemes) rest(report, scheme);
  report.section("Simultaneous contacts");
  for (const std::string& scheme : schemes)
    for (const int arms : {2, 4}) simultaneous(report, scheme, arms);
  report.section("Grazing contacts: least gaps of 0.5 to 1.01 contact gaps");
  for (const std::string& scheme : {schemes[0], schemes[1]})
    for (const double speed : {0.01, 1.0, 10.0}) graze(report, scheme, speed);
  report.section("A contact at exactly an output time");
  for (const std::string& scheme : schemes) at_an_output_time(report, scheme);
  report.section("Starts, hand-overs, sides");
  for (const std::string& scheme : schemes) starts(report, scheme);
  for (const std::string& scheme : {schemes[0], schemes[1]}) handed_over(report, scheme);
  for (const std::string& scheme : {schemes[0], schemes[1]}) sides(report, scheme);
  for (const std::string& scheme : schemes) short_circuit(report, scheme);
  report.section("Runs cut in two, and run twice");
  for (const std::string& scheme : schemes) {
    // The gap of 0.1 mm is crossed in 1 ms; the overlap is largest half a millisecond later.
    resumed(report, scheme, colliding(), 1.5e-3, 5e-3, "in a collision");
    resumed(report, scheme, colliding(), 0.7e-3, 5e-3, "in electrical contact");
    resumed(report, scheme, random_spheres(), 0.05, 0.1, "in a dense system");
  }
  random_scenes(report, "split", all ? 100 : 10, 1);
  random_scenes(report, "euler", all ? 20 : 2, 0.3);
  random_scenes(report, "monolithic", all ? 20 : 2, 0.1);
  return report.exit_status();
}

const lichtenberg::validation::Program program("hard_cases_time", validate);

}  // namespace hard_cases_time_validation
