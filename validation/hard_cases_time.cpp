// Time at its limits: contacts that coincide, graze, fall on an output time, come a thousand times; charges that run
// into each other; a run cut in two in the middle of a contact.
//
//   hard_cases_time         on scripted forces and line charges, seconds
//   hard_cases_time long    more seeds, the cut-cell field, the reference coupling throughout
//
// A position is good to position_tolerance (a thousandth of a radius here) a coupling step, so an event is good to that
// over the speed; relative_tolerance is 1e-6 a step of the integrator.

#include <array>
#include <chrono>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"

using namespace lichtenberg;
using namespace lichtenberg::spheres;
using namespace lichtenberg::validation;

namespace {

const std::array<std::string, 3> ways = {"split", "monolithic", "euler"};

/// `scene` by split or monolithic coupling of CVODE, or by Euler's steps.
Scene by(const std::string& way, Scene scene) {
  if (way == "euler")
    scene.mechanics.integrator = "euler";
  else
    scene.mechanics.coupling = way;
  return scene;
}

// ---- rest

/// Nothing is charged and nothing moves, for a thousand seconds: not a bit may change, and steps are the longest.
void rest(Report& report, const std::string& way) {
  Scene scene = by(way, conductor_scene({{0.03, 0.05}, {0.03 + 3 * radius, 0.05}, {0.05, 0.05}}));
  scene.electrodes = {ball("ground", {0.05, 0.05 + 2.5 * radius}, 0)};
  scene.effects.hertz_contact.emplace();
  scene.effects.wall_contact.emplace();
  scene.mechanics.largest_step = scene.mechanics.euler_field_step = 10;
  scene.mechanics.euler_step = 0.1;
  Simulation simulation(scene, std::make_unique<LineCharges>());
  const Frame before = simulation.frame();
  simulation.advance_to(1000);
  const Frame after = simulation.frame();
  report.at_most(way + ": moved, m", largest_distance(before, after), 0);
  report.at_most(way + ": charge, C", std::abs(total(after.charge)) + std::abs(after.charge_drained), 0);
  // One a step of 10 s, and the first; CVODE begins with short steps, tenfold longer each time.
  report.at_most(way + ": field solves", static_cast<double>(after.field_solves), 120);
}

// ---- simultaneous events

/// A charged conductor in the middle, and two or four that come from all sides at once.
void simultaneous(Report& report, const std::string& way, int arms) {
  Scene scene = conductor_scene({{0.05, 0.05}});
  scene.conductors[0].charge = 4e-11;
  for (int k = 0; k < arms; ++k) {
    const Vec2 outward = k % 2 == 0 ? Vec2{k < 2 ? 1.0 : -1.0, 0} : Vec2{0, k < 2 ? 1.0 : -1.0};
    const Vec2 side = arms == 2 && k == 1 ? Vec2{-1, 0} : outward;
    scene.conductors.push_back(
        {.position = scene.conductors[0].position + 4 * radius * side, .velocity = -0.02 * side, .radius = radius});
  }
  scene.effects.stokes_drag.reset();
  scene.effects.hertz_contact.emplace();
  Simulation simulation(by(way, scene), std::make_unique<LineCharges>());
  simulation.advance_to(0.06);  // the way is one radius, 39 ms
  const Frame frame = simulation.frame();
  const Counters& counters = simulation.counters();
  const std::string name = fmt::format("{}, {} at once: ", way, arms);
  report.at_most(name + "contacts missing", static_cast<double>(arms - counters.contacts_made), 0);
  if (way != "euler") report.at_most(name + "regroupings", static_cast<double>(counters.regroupings), 1);
  // Symmetric but for the rounding of a linear solve of their few charges, grown by at most some hundred steps.
  double uneven = 0;
  for (int k = 1; k <= arms; ++k) uneven = std::max(uneven, std::abs(frame.charge[k] / frame.charge[1] - 1));
  report.at_most(name + "difference of their charges, fraction", uneven, 1e-10);
  report.at_most(name + "the middle one moved, radii", norm(frame.position[0] - scene.conductors[0].position) / radius,
                 1e-10);
  report.at_most(name + "charge lost, fraction", imbalance(frame, 4e-11) / 4e-11, 1e-15);
}

// ---- grazing

/// A charged conductor flies past a grounded ball on a straight line whose least gap is (1 + off) contact gaps. What
/// dips deeper than the position tolerance makes contact and loses it, what stays farther off than that does not, and
/// in between either is right; but nothing happens twice.
void graze(Report& report, const std::string& way, double speed) {
  double missed = 0, invented = 0, twice = 0, solves = 0, lost = 0;
  for (const double off : {-0.5, -0.1, -1e-2, -2e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 2e-3, 1e-2})
    for (const double height : {0.011, 0.0123, 0.0137}) {
      Scene scene = conductor_scene({{0.05 + 2 * radius + (1 + off) * radius, height}});
      scene.effects.stokes_drag.reset();
      scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
      scene.conductors[0].velocity = {0, speed};
      scene.conductors[0].charge = 1e-11;
      Simulation simulation(by(way, scene), no_forces());
      simulation.advance_to(0.075 / speed);
      const Counters& c = simulation.counters();
      const bool deep = off * radius < -scene.mechanics.position_tolerance;
      const bool clear = off * radius > scene.mechanics.position_tolerance;
      missed += deep && c.contacts_made == 0;
      invented += clear && c.contacts_made > 0;
      twice += c.contacts_made > 1 || c.contacts_made != c.contacts_lost;
      solves = std::max(solves, static_cast<double>(c.field_solves) - 0.075 / speed / scene.mechanics.largest_step);
      lost = std::max(lost, imbalance(simulation.frame(), 1e-11) / 1e-11);
    }
  const std::string name = fmt::format("{}, {:g} m/s: ", way, speed);
  report.at_most(name + "contacts missed", missed, 0);
  report.at_most(name + "contacts without cause", invented, 0);
  report.at_most(name + "made twice, or not lost", twice, 0);
  report.at_most(name + "charge lost, fraction", lost, 1e-15);
  // Beside one a longest step: the first, the contact's, and while steps grow again from the shortest, twofold each.
  if (way == "split") report.at_most(name + "field solves", solves, 60);
}

// ---- an event at an output time

/// Straight flight into contact with a grounded ball at exactly t = 0.2, looked at every 0.1, 0.05, 0.2 s, or once.
void at_an_output_time(Report& report, const std::string& way) {
  double events = 0, wrong = 0, differs = 0;
  std::vector<Frame> ends;
  for (const int frames : {1, 2, 4, 8, 3}) {
    const double speed = 0.0625, meet = 0.2;  // exact in binary, but for the meeting
    Scene scene = conductor_scene({{0.05 - 3 * radius - speed * meet, 0.05}});
    scene.effects.stokes_drag.reset();
    scene.conductors[0].velocity = {speed, 0};
    scene.conductors[0].charge = 1e-11;
    scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
    Simulation simulation(by(way, scene), scripted([&](const laplace::LaplaceProblem& p) {
                            const bool charged = p.groups[p.bodies[0].group].charge != 0;  // what is held has none
                            return std::vector<Vec2>{{charged ? 0.0 : -1e-6, 0}, {0, 0}};
                          }));
    for (int k = 1; k <= frames; ++k) {
      const double end = 0.4 * k / frames;
      simulation.advance_to(end);
      const Frame frame = simulation.frame();
      const bool held = frame.group[0] == -1;
      if (frame.time != end || imbalance(frame, 1e-11) > 1e-26) ++wrong;
      if ((simulation.counters().contacts_made > 0) != (frame.charge[0] == 0)) ++wrong;  // it gave its charge there
      if (std::abs(end - meet) > 0.03 && end < meet && held) ++wrong;
    }
    ends.push_back(simulation.frame());
    events = std::max(events, static_cast<double>(simulation.counters().contacts_made));
    differs = std::max(differs, largest_distance(ends.front(), ends.back()) / scene.mechanics.position_tolerance);
  }
  report.at_most(way + ": contacts made", events, 1);
  report.at_most(way + ": frames at odds with themselves", wrong, 0);
  // The contact may be taken one tolerance early; then the body is driven back for 0.2 s: the way back is the same.
  if (way != "euler") report.at_most(way + ": end, by number of frames, tolerances", differs, 5);
}

}  // namespace

int main(int argc, char** argv) {
  const bool all = asked_for_long(argc, argv);
  (void)all;
  Report report("Time at its limits");
  report.section("Rest for a thousand seconds");
  for (const std::string& way : ways) rest(report, way);
  report.section("Simultaneous contacts");
  for (const std::string& way : ways)
    for (const int arms : {2, 4}) simultaneous(report, way, arms);
  report.section("Grazing contacts: least gaps of 0.5 to 1.01 contact gaps");
  for (const std::string& way : {ways[0], ways[1]})
    for (const double speed : {0.01, 1.0, 10.0}) graze(report, way, speed);
  report.section("A contact at exactly an output time");
  for (const std::string& way : ways) at_an_output_time(report, way);
  return report.exit_status();
}
