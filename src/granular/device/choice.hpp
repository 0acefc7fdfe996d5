#pragma once

// Length of the next step. The device chooses it; the host chooses only the first of a series.

#include <algorithm>
#include <cmath>

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/pace.hpp"
#include "src/scene/contact_attraction.hpp"

namespace lichtenberg::granular::device {

/// Parameters of the step length, as on the CPU (../multirate.cpp, Gas::follow_contacts).
template <class Law>
struct StepRule {
  Law law;
  double longest = 0;  ///< mechanics.step
  double way = 0;      ///< d0, largest path of the fastest grain
  double contact_steps = 1;
  GrainsSeen grains;
  double largest_radius = 0, lightest = 1;
  ContactAttraction attraction;
  double skin = 0;  ///< d0, of the neighbour lists

  LICHTENBERG_HOST_DEVICE double longest_step(double speed, double impact, double acceleration, double held) const {
    return longest_step_within({longest, held, way, speed, acceleration},
                               [&](double gain) { return step_of_contacts(impact + gain); });
  }
  LICHTENBERG_HOST_DEVICE double step_of_contacts(double impact) const {
    return time_to_resolve(law, impact, grains) / contact_steps;
  }
  /// Returns a bound on the acceleration by a contact at this impact speed. Without losses the overlap is less than
  /// half of the straight path within the contact duration. The CPU computes a tighter bound iteratively.
  LICHTENBERG_HOST_DEVICE double max_contact_acceleration(double speed) const {
    if (!(speed > 0)) return 0;
    const double overlap = 0.5 * speed * law.shortest_contact(speed);
    const ContactParts most = law.parts(overlap, law.scale(largest_radius, largest_radius));
    return (most.elastic + most.damping * speed) / lightest;
  }
};

/// State of a series of steps without interaction with the host.
struct Progress {
  double time = 0, target = 0;
  double end = 0;           ///< t0, end of the chosen step
  double travel = 0;        ///< d0, bound on displacements in it
  double held_charge = -1;  ///< q0, largest charge for which `hold` was computed
  double hold = INFINITY;
  std::int64_t contact_steps = 0, begun = 0, transfers = 0;
  int left = 0;   ///< largest number of further steps
  int whole = 0;  ///< 1: the next step ends at `target`
  int go = 0;     ///< 1: a step has been chosen and the lists are valid for it
  int exchanged = 0;
  int steps = 0, exchanges = 0;
  int unresolved = 0;  ///< 1: contacts are too short for the number of substeps

  static Progress towards(double target, double time, int most, bool whole) {
    Progress now;
    now.time = time, now.target = target, now.left = most, now.whole = whole;
    return now;
  }
  LICHTENBERG_HOST_DEVICE bool wanted() const { return left > 0 && time < target; }
};

template <class Law>
LICHTENBERG_HOST_DEVICE void choose(const StepRule<Law>& rule, const Found& found, Progress& now,
                                    StepParameters& next) {
  now.go = 0;
  if (!now.wanted() || found.passed || found.lost) return;
  if (found.charge != now.held_charge) {
    now.held_charge = found.charge;
    now.hold = longest_hold(rule.law, rule.attraction(found.charge), 0.5 * rule.lightest);
  }
  const double speed = std::sqrt(found.speed2), acceleration = std::sqrt(found.acceleration2);
  const double impact = std::fmax(2 * speed, std::sqrt(found.impact2)), left = now.target - now.time;
  const double count = now.whole ? 1 : std::ceil(left / rule.longest_step(speed, impact, acceleration, now.hold));
  now.end = count <= 1 ? now.target : now.time + left / count;
  const double dt = now.end - now.time, gain = acceleration * dt;
  const double resolved = rule.step_of_contacts(impact + 2 * gain);
  const double steps = std::fmax(1.0, std::ceil(dt / resolved));
  constexpr double most = 1e8;
  now.unresolved = !(steps < most);
  if (now.unresolved) return;
  // Twice the largest speed is a bound on speeds after a collision.
  now.travel = 2 * (speed + gain) * dt;
  next = {now.time,
          dt,
          dt / steps,
          2 * now.travel,
          2 * rule.max_contact_acceleration(impact + 2 * gain) + acceleration,
          static_cast<int>(steps)};
  now.go = !(std::sqrt(found.moved2) + now.travel > 0.5 * rule.skin);
}

/// Counts the completed step.
LICHTENBERG_HOST_DEVICE inline void count_step(const Found& found, const StepParameters& made, bool exchanges,
                                               Progress& now) {
  now.time = now.end;
  --now.left, ++now.steps;
  now.contact_steps += made.steps, now.begun += found.begun, now.transfers += found.transfers;
  now.exchanged = exchanges && found.transfers > 0;
  now.exchanges += now.exchanged;
}

/// Returns for how many steps like the chosen one the lists remain valid at the present largest speed.
template <class Law>
int steps_ahead(const StepRule<Law>& rule, const Found& found, const Progress& now, const StepParameters& next) {
  const double room = 0.5 * rule.skin - std::sqrt(found.moved2) - now.travel,
               path = std::sqrt(found.speed2) * next.outer;
  const double most = std::min<double>(now.left, std::ceil((now.target - now.time) / next.outer));
  const double further = path > 0 ? std::floor(room / path) : most;
  return 1 + static_cast<int>(std::max(std::min(further, most - 1), 0.0));
}

/// No action after a step.
struct NoMore {
  LICHTENBERG_HOST_DEVICE void operator()() const {}
};
/// Counts the step and chooses the next one. Does nothing if no step had been chosen.
template <class Law>
struct GoOn {
  StepRule<Law> by;
  Found* found;
  StepParameters* parameters;
  Progress* now;
  const int* unstable;  ///< null: no dipoles
  bool exchanges;

  LICHTENBERG_HOST_DEVICE void operator()() const {
    Progress here = *now;
    here.exchanged = 0;
    if (here.go) go_on(here);
    *now = here;
  }
  LICHTENBERG_HOST_DEVICE void go_on(Progress& here) const {
    const Found seen = parallel::fresh(found);
    StepParameters next = *parameters;
    count_step(seen, next, exchanges, here);
    if (unstable && *unstable) here.left = 0;
    choose(by, seen, here, next);
    *parameters = next;
    if (here.go) found->begin_step();
  }
};

}  // namespace lichtenberg::granular::device
