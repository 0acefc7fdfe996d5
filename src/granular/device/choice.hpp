#pragma once

// How long the next step is. The device chooses, step after step; the host only the first of some.

#include <algorithm>
#include <cmath>

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/pace.hpp"
#include "src/scene/contact_attraction.hpp"

namespace lichtenberg::granular::device {

/// What a step is chosen by, as on the CPU (../multirate.cpp, Gas::follow_contacts).
template <class Law>
struct StepRule {
  Law law;
  double longest = 0;  ///< mechanics.step
  double way = 0;      ///< of the fastest grain, at most
  double contact_steps = 1;
  GrainsSeen grains;
  double largest_radius = 0, lightest = 1;
  ContactAttraction attraction;
  double skin = 0;  ///< of lists

  LICHTENBERG_HOST_DEVICE double longest_step(double speed, double impact, double acceleration, double held) const {
    return longest_step_within({longest, held, way, speed, acceleration},
                               [&](double gain) { return step_of_contacts(impact + gain); });
  }
  LICHTENBERG_HOST_DEVICE double step_of_contacts(double impact) const {
    return time_to_resolve(law, impact, grains) / contact_steps;
  }
  /// Acceleration that a contact of two that meet at this speed does not exceed: even if nothing is lost, the overlap
  /// is less than half of the way that they would fly meanwhile.
  LICHTENBERG_HOST_DEVICE double hardest_push(double speed) const {
    if (!(speed > 0)) return 0;
    const double overlap = 0.5 * speed * law.shortest_contact(speed);
    const ContactParts most = law.parts(overlap, law.scale(largest_radius, largest_radius));
    return (most.elastic + most.damping * speed) / lightest;
  }
};

/// Steps that follow each other without a question to the host.
struct Progress {
  double time = 0, target = 0;
  double end = 0;           ///< of the step that has been chosen
  double travel = 0;        ///< of a grain in it
  double held_charge = -1;  ///< for which forces may be held so long
  double hold = INFINITY;
  std::int64_t contact_steps = 0, begun = 0, transfers = 0;
  int left = 0;   ///< steps that may still be made
  int whole = 0;  ///< 1: the next goes to `target`, however long that is
  int go = 0;     ///< 1: a step has been chosen, for which the lists hold
  int exchanged = 0;
  int steps = 0, exchanges = 0;
  int unresolved = 0;  ///< 1: contacts are so short that a step would have no end

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
  // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
  now.travel = 2 * (speed + gain) * dt;
  next = {now.time,
          dt,
          dt / steps,
          2 * now.travel,
          2 * rule.hardest_push(impact + 2 * gain) + acceleration,
          static_cast<int>(steps)};
  now.go = !(std::sqrt(found.moved2) + now.travel > 0.5 * rule.skin);
}

/// Books the step that was made.
LICHTENBERG_HOST_DEVICE inline void count_step(const Found& found, const StepParameters& made, bool exchanges,
                                               Progress& now) {
  now.time = now.end;
  --now.left, ++now.steps;
  now.contact_steps += made.steps, now.begun += found.begun, now.transfers += found.transfers;
  now.exchanged = exchanges && found.transfers > 0;
  now.exchanges += now.exchanged;
}

/// How many steps like the one that has been chosen lists hold for at least, if the fastest grain goes on as it flies.
template <class Law>
int steps_ahead(const StepRule<Law>& rule, const Found& found, const Progress& now, const StepParameters& next) {
  const double room = 0.5 * rule.skin - std::sqrt(found.moved2) - now.travel,
               path = std::sqrt(found.speed2) * next.outer;
  const double most = std::min<double>(now.left, std::ceil((now.target - now.time) / next.outer));
  const double further = path > 0 ? std::floor(room / path) : most;
  return 1 + static_cast<int>(std::max(std::min(further, most - 1), 0.0));
}

/// Nothing follows a step.
struct NoMore {
  LICHTENBERG_HOST_DEVICE void operator()() const {}
};
/// The step is booked and the next one chosen. If none had been chosen, none has been made.
template <class Law>
struct GoOn {
  StepRule<Law> by;
  Found* found;
  StepParameters* parameters;
  Progress* now;
  const int* unstable;  ///< null: there are no dipoles
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
