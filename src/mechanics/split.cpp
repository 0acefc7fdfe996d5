#include "src/mechanics/split.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "src/mechanics/step_control.hpp"
#include "src/model/body_ranges.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg::mechanics {

namespace {

/// In tolerances, what predictions may be wrong by before that is made up for. They go on for as long as half of it is
/// expected, since more is thrown away with them than a step.
constexpr double allowed_correction = 2;
double next_prediction(double dt, double error) { return next_step(dt, 2 / allowed_correction * error, 2); }

/// Power of the length of a step with which the error of an extrapolated force grows.
int order(const effects::HeldField& held) { return held.rates_known ? 3 : 2; }

/// How far each body can move within `dt` from `time` on (m): it cannot become faster than it is now or than the
/// largest force in between can drive it, against inertia in that time or against drag.
void find_longest_travel(const Model& model, std::span<const double> drag, const effects::HeldField& held, double time,
                         double dt, std::vector<double>& travel) {
  travel.resize(model.bodies.size());
  for_ranges(*model.team, model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      const Vec3 force = held.force_at(i, time), rate = held.force_rate[i];
      const double f = norm(force + std::copysign(dt, dot(force, rate)) * rate),
                   inertial = f * dt / model.bodies.mass[i];
      const double gained = drag[i] > 0 ? std::min(inertial, f / drag[i]) : inertial;
      travel[i] = dt * (norm(velocity_in_space(model.bodies, i)) + gained);
    }
  });
}

}  // namespace

Split::Split(Workplace workplace)
    : at_(workplace),
      cvode_(make_cvode(at_.scene, at_.model)),
      flight_(at_.model),
      correction_(at_.model),
      mergers_(at_.scene, at_.model, flight_),
      drag_(at_.model.drag.linear()),
      largest_step_(at_.scene.mechanics.largest_step),
      shortest_step_(1e-9 * largest_step_),
      shortest_gap_(at_.electrics->contact_events().contact_gap()) {
  book_drag(at_, cvode_);
  cvode_.between_steps = at_.between_steps;
}

void Split::begin(double time) {
  effects::FloatingConductors& field = at_.electrics->field();
  if (field.predictor()) {
    at_.electrics->solve(time, FieldGrid::predictor);
    field.correct(at_.electrics->now().field);
  }
  if (step_ == 0) return restart(time, held().force);
  at_.electrics->hold(time, Rates::kept);
}

void Split::advance(double time, double end) {
  const bool predicts = at_.electrics->field().predictor() != nullptr;
  while (time < end) {
    at_.between_steps();
    const double reached = predicts ? try_prediction(time, end) : try_step(time, end, FieldGrid::whole);
    wrap(at_.model.bodies);
    if (reached > time) at_.model.accept(reached, reached - time);
    time = reached;
  }
}

Split::Start Split::start() const { return {at_.model.bodies, at_.electrics->now(), at_.counters}; }

void Split::go_back(const Start& start) {
  at_.model.bodies = start.bodies;
  at_.electrics->go_back(start.charging);
  at_.counters.contacts_made = start.counters.contacts_made;
  at_.counters.contacts_lost = start.counters.contacts_lost;
  at_.counters.regroupings = start.counters.regroupings;
}

/// Steps with the predictor's field: to `target`, or until there have been as many as may be taken back at once and the
/// last one's field is known. Returns the time reached.
double Split::predict(double since, double target) {
  // A field solve costs some 15 predictions, 4 on a device: to check as many costs a quarter of them at most, or a
  // sixteenth. Without a limit nearly half of those that 20000 conductors took at first were thrown away, in windows of
  // more than a hundred (validation/benchmarks/README.md).
  constexpr int most = 64;
  double time = since;
  for (int done = 0; time < target; ++done) {
    if (done >= most && time > since && held().time == time) break;
    at_.between_steps();
    time = try_step(time, target, FieldGrid::predictor);
  }
  return time;
}

/// Moves on by as many predicted steps as are likely to be right, then solves the field. Returns the time reached:
/// `time` itself if they were not, and everything is as it was but for how long mergers may wait.
double Split::try_prediction(double time, double end) {
  if (prediction_ == 0) prediction_ = std::min(4 * step_, largest_step_);
  const double step = step_;
  const Start start = this->start();
  const double allowed = step_end(time, prediction_, end), target = predict(time, allowed);
  Trial trial = at_.electrics->solve(target);
  const std::vector<Vec3> predicted = at_.electrics->now().field.force;
  const double wrong_by = error(time, trial, predicted);
  const double proposed = next_prediction(target - time, wrong_by);
  if (wrong_by > allowed_correction && target - time > 2 * shortest_step_) {
    ++at_.counters.rejected_corrections;
    go_back(start);
    step_ = step;
    prediction_ = proposed;
    return time;
  }
  ++at_.counters.corrections;
  const bool cut_short = target == allowed && target - time < prediction_;  // by the end
  prediction_ = std::clamp(cut_short ? std::max(prediction_, proposed) : proposed, shortest_step_, largest_step_);
  at_.electrics->accept(std::move(trial));
  at_.electrics->field().correct(at_.electrics->now().field);
  at_.electrics->hold(target, Rates::kept);
  if (wrong_by > allowed_correction) return target;
  // Bodies that can touch by it are left where they are.
  const double most = allowed_correction * at_.scene.mechanics.position_tolerance;
  correction_.apply(target - time, predicted, held().force,
                    flight_.pushed(std::vector<double>(predicted.size(), most)));
  return target;
}

/// End (s) of a step that may last for `step`. A rest shorter than two steps is halved: a sliver at the end would
/// cost as much as a whole step. The rounding of times must not make one, either.
double Split::step_end(double time, double step, double end) const {
  const double room = end - time, allowed = std::max(step, shortest_step_);
  return allowed > 0.999 * room ? end : time + std::min(allowed, 0.5 * room);
}

/// Shortens a step (s) as laws of charge sharing that depend on the gap ask for.
double Split::step_within_gaps(double time, double step) const {
  if (!at_.electrics->resistors().has_laws_of_state()) return step;
  std::vector<double> force(at_.model.bodies.position.size());
  at_.model.forces(time, force);
  return std::min(step, at_.electrics->resistors().longest_step(force));
}

/// Moves on by a step from the last solve, or to the first event. Returns the time reached: `time` itself if the step
/// was rejected.
double Split::try_step(double time, double end, FieldGrid grid) {
  const double target = step_end(time, step_within_gaps(time, std::min(held().time + step_, end) - time), end);
  // What a rejected step has changed: where the bodies are and, in a scene with a circuit, what drag took. The rest of
  // what is electric waits for the trial, or for an event, which stands.
  before_.position = at_.model.bodies.position;
  before_.momentum = at_.model.bodies.momentum;
  const std::optional<EnergyBook> energy = at_.electrics->now().energy;
  const Moved moved = move(time, target);
  const double reached = moved.reached;
  if (reached < target && pass_event(moved, grid)) return reached;
  Trial trial = at_.electrics->solve(reached, grid);
  find_held_forces(reached, assumed_);
  const double wrong_by = std::max(error(held().time, trial, assumed_), at_.electrics->resistors().charge_error(trial));
  if (wrong_by > 1 && target - time > 2 * shortest_step_) {
    std::swap(at_.model.bodies.position, before_.position);
    std::swap(at_.model.bodies.momentum, before_.momentum);
    if (energy) *at_.electrics->energy() = *energy;
    reject(time, reached, wrong_by, grid);
    return time;
  }
  const double since = reached - held().time;
  accept(std::move(trial), wrong_by);
  if (wrong_by <= 1 && moved.pushed && since > shortest_step_)
    correction_.apply(since, assumed_, held().force, *moved.pushed);
  // What is wrong even after the shortest step has not moved there but jumped.
  if (wrong_by > 1) step_ = 0;
  const Regrouping regrouping = at_.electrics->reconnect(reached, moved.due_since, grid);
  if (!regrouping.merged && wrong_by <= 1) return reached;
  old_force_ = held().force;
  restart(reached, wrong_by > 1 ? assumed_ : old_force_);
  if (regrouping.merged) make_up_merger(moved, regrouping.mergers);
  return reached;
}

/// Mergers at the end of a move have changed the force from old_force_ to what is held.
void Split::make_up_merger(const Moved& moved, std::span<const Merger> mergers) {
  const Jump jump{old_force_, held().force};
  mergers_.learn(jump);
  if (moved.pushed) mergers_.make_up(moved.reached, mergers, jump, *moved.pushed);
}

/// Moves the bodies under the extrapolated force to `target` or to the first contact made or lost on the way; or, if it
/// is made, as long beyond as it may wait for others.
Split::Moved Split::move(double time, double target) {
  const ContactEvents& contacts = at_.electrics->contact_events();
  Moved moved;
  while (time < target) {
    at_.between_steps();
    find_longest_travel(at_.model, drag_, held(), time, target - time, travel_);
    reach_ = travel_;
    contacts.widen(reach_);
    moved.pushed = moved_by_cvode(travel_, reach_);
    const Lookahead ahead = contacts.look_ahead(at_.electrics->now(), reach_, moved.pushed);
    ContactEvents::Due due = contacts.due(ahead);
    // What has been made up for may have carried a contact across its threshold, which is no event any more. Without
    // that it would have been found within a step.
    const bool crossed = due.made || due.lost;
    moved.due_since = crossed ? time - std::min(mergers_.patience(), step_) : time;
    if (!crossed) {
      moved.due_since = time = advance(time, target, contacts.events(ahead), moved.pushed);
      due = contacts.due(ahead);
    }
    moved.reached = due.made && !due.lost ? wait(time, target, ahead, moved) : time;
    if (due.lost || due.made) return moved;
    // Otherwise a collision has thrown a body farther than was looked for: look again.
  }
  moved.reached = moved.due_since = time;
  return moved;
}

/// A merger that is due at `time` waits for others that come soon, to share its solve with them: until what it changes
/// would have moved something by half a tolerance, and not into the second half of a step, where it would need one more
/// solve. A parting that is a tolerance late ends the wait: members would part with other charges, and nothing would
/// make up for that. In a scene with a circuit energy is booked event by event, and nothing waits.
double Split::wait(double time, double target, const Lookahead& ahead, const Moved& moved) {
  if (at_.electrics->resistors().any() || at_.electrics->energy()) return time;
  const double half = held().time + 0.499 * step_;
  const double limit = std::min({target, moved.due_since + mergers_.patience(), time < half ? half : target});
  return limit > time ? advance(time, limit, at_.electrics->contact_events().events(ahead, true), moved.pushed) : time;
}

/// Only bodies that may touch something need CVODE; in a scene with a circuit, whose drag it books, all do, and with
/// nonlinear drag, for which free flight has no closed form. Those that
/// a collision throws farther than foreseen end the integration where ContactEvents::events says: as far as that all
/// count that they might meet. Without contact_discharge there are no events, and all count. No value: all; none in it:
/// nobody.
std::optional<std::vector<int>> Split::moved_by_cvode(std::span<const double> travel,
                                                      std::span<const double> reach) const {
  const Stopwatch watch(at_.counters.mechanics_seconds);
  if (at_.electrics->energy() || !at_.model.drag.is_linear()) return {};
  std::vector<int> pushed = flight_.pushed(reach);
  if (pushed.empty() || flight_.pushed(travel).empty()) return std::vector<int>();
  if (!at_.electrics->has_contacts()) return {};
  return pushed;
}

double Split::advance(double time, double target, const Events& events, const std::optional<std::vector<int>>& pushed) {
  const Stopwatch watch(at_.counters.mechanics_seconds);
  if (!pushed) return cvode_.advance(time, target, events);
  if (pushed->empty()) return flight_.advance(time, target, held(), events);
  return flight_.advance(time, target, held(), events, *pushed, cvode_);
}

/// Contacts made or lost before the step's end. A merger needs a solve with the new groups. Groups that part need none,
/// because they part with the charges and potentials that they have, which leaves the field as it is. But what led to
/// the event, and the charges there, must be known. Half a step has an eighth of a step's error, a quarter while the
/// force's rate is unknown: so far the extrapolation will do, but not for what resistors carry: their conductance
/// magnifies its error. Returns false if the old groups' field is needed, to judge the step by it.
bool Split::pass_event(const Moved& moved, FieldGrid grid) {
  const double time = moved.reached;
  if (at_.electrics->resistors().any() || time - held().time >= 0.5 * step_) return false;
  std::vector<double> charge(at_.model.bodies.size());
  for_ranges(*at_.model.team, at_.model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) charge[i] = held().charge_at(i, time);
  });
  at_.electrics->share(time, charge);
  const Regrouping regrouping = at_.electrics->reconnect(time, moved.due_since, grid);
  if (!regrouping.merged) return true;
  ++at_.counters.steps;
  find_held_forces(time, old_force_);
  restart(time, old_force_);
  make_up_merger(moved, regrouping.mergers);
  return true;
}

void Split::find_held_forces(double time, std::vector<Vec3>& force) const {
  force.resize(at_.model.bodies.size());
  for_ranges(*at_.model.team, at_.model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) force[i] = held().force_at(i, time);
  });
}

/// The worst body's displacement, in tolerances, if the force assumed at the end was off by what is known now, and
/// that grew from nothing at the start. Of bodies alike in a row it is that of the largest defect.
double Split::error(double since, const Trial& trial, const std::vector<Vec3>& assumed) const {
  const std::vector<double>& mass = at_.model.bodies.mass;
  const Drag& drag = at_.model.drag;
  const auto resistance = [&](int body) {
    return drag.is_linear(body) ? drag_[body] : drag.resistance(body, norm(velocity_in_space(at_.model.bodies, body)));
  };
  const auto moved_by = [&](double defect2, int body) {
    return displacement(std::sqrt(defect2), trial.time - since, mass[body], resistance(body));
  };
  const auto worst_of = [&](int first, int end) {
    double worst = 0, defect2 = 0;
    int like = first;
    for (int i = first; i < end; ++i) {
      if (mass[i] != mass[like] || drag_[i] != drag_[like] || !drag.is_linear(i)) {
        worst = std::max(worst, moved_by(std::exchange(defect2, 0), like));
        like = i;
      }
      defect2 = std::max(defect2, norm2(trial.field.force[i] - assumed[i]));
    }
    return std::max(worst, moved_by(defect2, like));
  };
  return largest_of_ranges(*at_.model.team, at_.model.bodies.size(), 0, worst_of) /
         at_.scene.mechanics.position_tolerance;
}

/// The trial's field becomes the base of the extrapolation.
void Split::accept(Trial trial, double error) {
  ++at_.counters.steps;
  const effects::HeldField& before = held();
  const double time = trial.time, dt = time - before.time, proposed = next_step(dt, error, order(before));
  const bool cut_short = dt < step_;  // by an event or the end: no reason to make the next one shorter
  step_ = std::clamp(cut_short ? std::max(step_, proposed) : proposed, shortest_step_, largest_step_);
  at_.electrics->accept(std::move(trial));
  at_.electrics->hold(time, dt > shortest_step_ ? Rates::since_then : Rates::kept);
}

/// The bodies are back at `time`; the step that failed went on to `reached`.
void Split::reject(double time, double reached, double error, FieldGrid grid) {
  ++at_.counters.rejected_steps;
  const double dt = reached - held().time;
  step_ = std::max(std::min(next_step(dt, error, order(held())), 0.5 * dt), shortest_step_);
  if (held().time == time) return;
  // Groups have parted since the last solve, and there is no way back behind that.
  find_held_forces(time, old_force_);
  at_.electrics->accept(at_.electrics->solve(time, grid));
  restart(time, old_force_);
}

/// Groups have merged, and forces have jumped: what is known of their rates no longer holds. A body that a force jump
/// drives at jump/drag through a field that varies over a certain length sees its force change at the rate below. That
/// length is a radius, or the contact gap if that is less: conductors at different potentials are never closer.
void Split::restart(double time, const std::vector<Vec3>& force_before) {
  const double step = least_of_ranges(*at_.model.team, at_.model.bodies.size(), largest_step_,
                                      [&](int first, int end) { return step_after(force_before, first, end); });
  constexpr double growth = 1.1;  // or it would stay what the hardest jump has left, while all steps end in events
  step_ = std::max(step_ == 0 ? step : std::min(step, growth * step_), shortest_step_);
  if (EnergyBook* energy = at_.electrics->energy()) energy->forget_rates();
  at_.electrics->hold(time, Rates::forgotten);
}

/// The step (s) that the bodies from `first` on up to before `end` allow after their forces have jumped.
double Split::step_after(const std::vector<Vec3>& force_before, int first, int end) const {
  const std::vector<Vec3>& force = at_.electrics->now().field.force;
  const Bodies& bodies = at_.model.bodies;
  const double tolerance = at_.scene.mechanics.position_tolerance;
  double step = largest_step_, fastest_rate = 0;
  int fastest = first;
  for (int i = first; i < end; ++i) {
    const double length = std::min(bodies.radius[i], shortest_gap_);
    const Vec3 jumped = force[i] - force_before[i], velocity = velocity_in_space(bodies, i);
    const bool alike = bodies.mass[i] == bodies.mass[fastest] && drag_[i] == drag_[fastest];
    if (alike && drag_[i] > 0) {
      // (a + b)^2 <= 2 (a^2 + b^2) tells without a root of most that they are not the fastest.
      const double speed2 = std::max(norm2(velocity), norm2(force[i]) / (drag_[i] * drag_[i]));
      const double rate2 = norm2(held().force_rate[i]) + norm2(jumped) * speed2 / (length * length);
      if (2.1 * rate2 < fastest_rate * fastest_rate) continue;
    }
    const double jump = norm(jumped);
    const double speed = std::max(norm(velocity), drag_[i] > 0 ? norm(force[i]) / drag_[i] : 0);
    const double rate = norm(held().force_rate[i]) + jump * speed / length;
    // Of bodies alike the one whose force changes fastest is the first to be displaced.
    if (!alike || rate > (1 - 1e-9) * fastest_rate) {
      step = std::min(step, time_to_displace(tolerance, rate, bodies.mass[i], drag_[i]));
      fastest = i, fastest_rate = rate;
    }
    if (drag_[i] == 0)
      step = std::min(step, time_to_displace_from_rest(tolerance, jump * norm(force[i]) / length, bodies.mass[i]));
  }
  return step;
}

void Split::save(Checkpoint& checkpoint) const {
  checkpoint.reals["coupling_step"] = {step_, prediction_};
  checkpoint.reals["merger_patience"] = {mergers_.patience()};
  checkpoint.reals["charge_rate"] = held().charge_rate;
  std::vector<double>& rate = checkpoint.reals["force_rate"];
  for (const Vec3 r : held().force_rate)
    for (int k = 0; k < at_.model.bodies.dimension; ++k) rate.push_back(r[k]);
  checkpoint.integers["rates_known"] = {held().rates_known};
}

void Split::restore(const Checkpoint& checkpoint) {
  step_ = reals(checkpoint, "coupling_step", 2)[0];
  prediction_ = reals(checkpoint, "coupling_step", 2)[1];
  if (checkpoint.reals.contains("merger_patience")) mergers_.set_patience(reals(checkpoint, "merger_patience", 1)[0]);
  effects::HeldField restored = held();
  restored.charge_rate = reals(checkpoint, "charge_rate", restored.charge_rate.size());
  const std::vector<double>& rate = reals(checkpoint, "force_rate", at_.model.bodies.position.size());
  for (std::size_t i = 0; i < restored.force_rate.size(); ++i)
    restored.force_rate[i] = vector_at(rate, at_.model.bodies.dimension, static_cast<int>(i));
  restored.rates_known = integers(checkpoint, "rates_known").at(0) != 0;
  at_.electrics->hold(std::move(restored));
}

/// Without a field there is nothing to split off.
std::unique_ptr<Stepper> make_split(const Workplace& workplace) {
  if (!workplace.electrics) return make_monolithic(workplace);
  return std::make_unique<Split>(workplace);
}

}  // namespace lichtenberg::mechanics
