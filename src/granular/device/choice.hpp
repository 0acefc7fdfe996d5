#pragma once

// Length of the next step. The device chooses it; the host chooses only the first of a series.

#include <algorithm>
#include <cmath>

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/rough_law.hpp"
#include "src/granular/pace.hpp"
#include "src/scene/contact_attraction.hpp"

namespace lichtenberg::granular::device {

/// Rule for the length of outer steps and contact substeps on a device, as on the CPU (../multirate.cpp,
/// Gas::follow_contacts). Reduced units.
template <class Law>
struct StepRule {
  Law law;
  double longest = 0;        ///< mechanics.step; infinite: follows from `path`
  double path = 0;           ///< largest path of the fastest grain in an outer step (d0)
  double contact_steps = 1;  ///< mechanics.contact_substeps: substeps in the shortest contact
  GrainProperties grains;
  double largest_radius = 0, lightest = 1;  ///< largest radius (d0), smallest mass (m0)
  ContactAttraction attraction;
  double skin = 0;  ///< skin of the neighbour lists (d0)

  /// Returns the longest outer step (t0). `speed`: largest speed; `impact`: largest impact speed; `acceleration`:
  /// largest acceleration by slow forces (all forces except contacts); `stability_limit`: max_outer_step().
  LICHTENBERG_HOST_DEVICE double longest_step(double speed, double impact, double acceleration,
                                              double stability_limit) const {
    return longest_step_within({longest, stability_limit, path, speed, acceleration},
                               [&](double gain) { return step_of_contacts(impact + gain); });
  }
  /// Returns the length of contact substeps (t0) for impact speeds up to `impact` (v0).
  LICHTENBERG_HOST_DEVICE double step_of_contacts(double impact) const {
    return time_to_resolve(law, impact, grains) / contact_steps;
  }
  /// Returns an upper bound on the acceleration (reduced units) of a grain by a contact, for the impact speed `speed`
  /// (v0). Without losses the overlap is less than half of the straight path within the contact duration. The CPU
  /// computes a tighter bound iteratively.
  LICHTENBERG_HOST_DEVICE double max_contact_acceleration(double speed) const {
    if (!(speed > 0)) return 0;
    const double overlap = 0.5 * speed * law.shortest_contact(speed);
    const ContactParts most = law.parts(overlap, law.scale(largest_radius, largest_radius));
    return (most.elastic + most.damping * speed) / lightest;
  }
};

/// State of a series of outer steps that a device makes without interaction with the host. Reduced units.
struct Progress {
  double time = 0, target = 0;  ///< current time, and time at which the series ends (t0)
  double end = 0;               ///< end of the chosen step (t0)
  double travel = 0;            ///< bound on displacements in the chosen step (d0)
  double limit_charge = -1;     ///< largest charge for which `stability_limit` was computed (q0)
  double stability_limit = INFINITY;
  /// Numbers of contact substeps, contact onsets and charge transfers in the series.
  std::int64_t contact_steps = 0, begun = 0, transfers = 0;
  std::int64_t refused = 0;      ///< number of transfers that the capacity has refused
  int left = 0;                  ///< largest number of further steps
  int whole = 0;                 ///< 1: the next step ends at `target`
  int go = 0;                    ///< 1: a step has been chosen and the lists are valid for it
  int exchanged = 0;             ///< 1: charge was exchanged in the last step
  int steps = 0, exchanges = 0;  ///< numbers of steps, and of steps with charge exchange, in the series
  int unresolved = 0;            ///< 1: contacts are too short for the allowed number of substeps
  int outran = 0;                ///< 1: a rough grain has moved farther than the neighbour lists allow

  /// Returns the state before a series of at most `most` steps from `time` to `target` (t0). `whole`: true for a single
  /// step to `target`.
  static Progress towards(double target, double time, int most, bool whole) {
    Progress now;
    now.time = time, now.target = target, now.left = most, now.whole = whole;
    return now;
  }
  /// Returns true if the series continues: `target` is not reached, and a further step is allowed.
  LICHTENBERG_HOST_DEVICE bool wanted() const { return left > 0 && time < target; }
};

/// Chooses the length of the next outer step and its contact substeps from the results of the last step. Sets now.go to
/// 1 if the neighbour lists are valid for the step, and otherwise to 0. No step is chosen at the end of the series, or
/// if the last step failed, as after a displacement beyond the lists. If contacts are too short for the step, none is
/// chosen either, and now.unresolved is 1.
template <class Law>
LICHTENBERG_HOST_DEVICE void choose(const StepRule<Law>& rule, const StepResults& results, Progress& now,
                                    StepParameters& next) {
  now.go = 0;
  if constexpr (is_rough<Law>) now.outran = results.moved2 > 0.25 * rule.skin * rule.skin;
  if (!now.wanted() || results.passed || results.escaped || now.outran || results.lost || results.overfull ||
      results.crossed)
    return;
  if (results.charge != now.limit_charge) {
    now.limit_charge = results.charge;
    now.stability_limit = max_outer_step(rule.law, rule.attraction(results.charge), 0.5 * rule.lightest);
  }
  const double speed = std::sqrt(results.speed2), acceleration = std::sqrt(results.acceleration2);
  const double impact = std::fmax(2 * speed, std::sqrt(results.impact2)), left = now.target - now.time;
  const double count =
      now.whole ? 1 : std::ceil(left / rule.longest_step(speed, impact, acceleration, now.stability_limit));
  now.end = count <= 1 ? now.target : now.time + left / count;
  const double dt = now.end - now.time, gain = acceleration * dt;
  const double resolved = rule.step_of_contacts(impact + 2 * gain);
  const double steps = std::fmax(1.0, std::ceil(dt / resolved));
  constexpr double most = 1e8;
  now.unresolved = !(steps < most);
  if (now.unresolved) return;
  // Twice the largest speed is a bound on speeds after a collision.
  now.travel = 2 * (speed + gain) * dt;
  if constexpr (is_rough<Law>)  // the sum of those by stored and adhesive energy, for slow grains
    now.travel += 2 * (std::sqrt(results.impact2) + rule.law.adhesive_speed) * dt;
  next = {now.time,
          dt,
          dt / steps,
          2 * now.travel,
          2 * rule.max_contact_acceleration(impact + 2 * gain) + acceleration,
          static_cast<int>(steps)};
  now.go = !(results.outgrown || std::sqrt(results.moved2) + now.travel > 0.5 * rule.skin);
}

/// Adds the completed outer step to the counters of a series, and sets the time to its end. `made`: parameters of the
/// step; `exchanges`: true if forces must be computed again after charge exchange.
LICHTENBERG_HOST_DEVICE inline void count_step(const StepResults& results, const StepParameters& made, bool exchanges,
                                               Progress& now) {
  now.time = now.end;
  --now.left, ++now.steps;
  now.contact_steps += made.steps, now.begun += results.begun, now.transfers += results.transfers;
  now.refused += results.refused;
  now.exchanged = exchanges && results.transfers > results.unchanged;
  now.exchanges += now.exchanged;
}

/// Estimates for how many outer steps of the chosen length the neighbour lists remain valid, at the current largest
/// speed. The result is at least 1, and otherwise at most the number of steps to the end of the series.
template <class Law>
int steps_ahead(const StepRule<Law>& rule, const StepResults& results, const Progress& now,
                const StepParameters& next) {
  const double allowed_path = 0.5 * rule.skin - std::sqrt(results.moved2) - now.travel,
               path = std::sqrt(results.speed2) * next.outer;
  const double most = std::min<double>(now.left, std::ceil((now.target - now.time) / next.outer));
  const double further = path > 0 ? std::floor(allowed_path / path) : most;
  return 1 + static_cast<int>(std::max(std::min(further, most - 1), 0.0));
}

/// Action after an outer step that does nothing.
struct NoAction {
  LICHTENBERG_HOST_DEVICE void operator()() const {}
};
/// Action after an outer step on a device: counts the step and chooses the next one. If no step had been chosen, it
/// only sets Progress::exchanged to 0.
template <class Law>
struct ChooseNext {
  StepRule<Law> by;
  StepResults* results;
  StepParameters* parameters;
  Progress* now;
  const int* unstable;  ///< not 0: the mutual polarization of dipoles diverges, and no step follows; null: no dipoles
  bool exchanges;

  LICHTENBERG_HOST_DEVICE void operator()() const {
    Progress here = *now;
    here.exchanged = 0;
    if (here.go) choose_next(here);
    *now = here;
  }
  LICHTENBERG_HOST_DEVICE void choose_next(Progress& here) const {
    const StepResults latest = parallel::fresh(results);
    StepParameters next = *parameters;
    count_step(latest, next, exchanges, here);
    if (unstable && *unstable) here.left = 0;
    choose(by, latest, here, next);
    *parameters = next;
    if (here.go) results->begin_step();
  }
};

}  // namespace lichtenberg::granular::device
