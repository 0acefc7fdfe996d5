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

/// Largest error of predictions, in tolerances, that is corrected, and the error at which their length aims. A larger
/// error is rejected, which discards all predictions since the last solve. Rejections of errors above two tolerances
/// cost more than they gained in accuracy (docs/measurements/benchmarks-field.json).
constexpr double allowed_correction = 4, aimed_correction = 0.75;
double next_prediction(double dt, double error) { return next_step(dt, error / aimed_correction, 2); }

/// Returns the order of the displacement error of an extrapolated force: the power of the step's length.
int order(const effects::ExtrapolatedField& extrapolated) { return extrapolated.rates_known ? 3 : 2; }

/// Finds an upper bound of the distance (m) that each body can move within `dt` (s) from `time` on. Its speed is at
/// most the present one plus that which the largest force of the interval can add, against inertia or against drag.
void find_longest_travel(const Model& model, std::span<const double> drag,
                         const effects::ExtrapolatedField& extrapolated, double time, double dt,
                         std::vector<double>& travel) {
  travel.resize(model.bodies.size());
  for_ranges(*model.team, model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      const Vec3 force = extrapolated.force_at(i, time), rate = extrapolated.force_rate[i];
      const double f = norm(force + std::copysign(dt, dot(force, rate)) * rate),
                   inertial = f * dt / model.bodies.mass[i];
      const double gained = drag[i] > 0 ? std::min(inertial, f / drag[i]) : inertial;
      travel[i] = dt * (norm(velocity_in_space(model.bodies, i)) + gained);
    }
  });
}

}  // namespace

Split::Split(StepperContext context)
    : context_(context),
      cvode_(make_cvode(context_.scene, context_.model)),
      flight_(context_.model),
      correction_(context_.model),
      mergers_(context_.scene, context_.model, flight_),
      drag_(context_.model.drag.linear()),
      largest_step_(context_.scene.mechanics.largest_step),
      shortest_step_(1e-9 * largest_step_),
      shortest_gap_(context_.electrics->contact_events().contact_gap()) {
  record_drag(context_, cvode_);
  cvode_.between_steps = context_.between_steps;
}

void Split::begin(double time) {
  effects::FloatingConductors& field = context_.electrics->field();
  if (field.predictor()) {
    context_.electrics->solve(time, FieldGrid::predictor);
    field.correct(context_.electrics->now().field);
  }
  if (step_ == 0) return restart(time, extrapolated().force);
  context_.electrics->set_extrapolation(time, Rates::kept);
}

void Split::advance(double time, double end) {
  const bool predicts = context_.electrics->field().predictor() != nullptr;
  while (time < end) {
    context_.between_steps();
    const double reached = predicts ? try_prediction(time, end) : try_step(time, end, FieldGrid::whole);
    if (reached > time) context_.commit(reached, reached - time);
    time = reached;
  }
}

Split::Start Split::start() const { return {context_.model.bodies, context_.electrics->now(), context_.counters}; }

void Split::rollback(const Start& start) {
  context_.model.bodies = start.bodies;
  context_.electrics->rollback(start.electrical_state);
  context_.counters.contacts_made = start.counters.contacts_made;
  context_.counters.contacts_lost = start.counters.contacts_lost;
  context_.counters.regroupings = start.counters.regroupings;
}

/// Takes steps with the predictor's field to `target`, or up to a limit of steps at whose end the field is known.
/// Returns the time reached.
double Split::predict(double since, double target) {
  // A field solve costs 9 to 15 predictions (docs/measurements/benchmarks-field.json), and about 3 on a device
  // (docs/measurements/device-field.json). A check after 64 predictions thus adds at most 25 % of their cost, or 5 % on
  // a device. Longer intervals are rejected too often (docs/measurements/benchmarks-field.json).
  constexpr int most = 64;
  double time = since;
  for (int done = 0; time < target; ++done) {
    if (done >= most && time > since && extrapolated().time == time) break;
    context_.between_steps();
    time = try_step(time, target, FieldGrid::predictor);
  }
  return time;
}

/// Takes as many predicted steps as are likely to be accurate enough, then solves the field. Returns the time reached.
/// If the steps are rejected, that is `time`, and the state is restored except for the deferral of group merges.
double Split::try_prediction(double time, double end) {
  if (prediction_ == 0) prediction_ = std::min(4 * step_, largest_step_);
  const double step = step_;
  const Start start = this->start();
  const double allowed = step_end(time, prediction_, end), target = predict(time, allowed);
  Trial trial = context_.electrics->solve(target);
  const std::vector<Vec3> predicted = context_.electrics->now().field.force;
  const double error_in_tolerances = error(time, trial, predicted);
  const double proposed = next_prediction(target - time, error_in_tolerances);
  if (error_in_tolerances > allowed_correction && target - time > 2 * shortest_step_) {
    ++context_.counters.rejected_corrections;
    rollback(start);
    step_ = step;
    prediction_ = proposed;
    return time;
  }
  ++context_.counters.corrections;
  const bool cut_short = target == allowed && target - time < prediction_;  // by the end of the interval
  prediction_ = std::clamp(cut_short ? std::max(prediction_, proposed) : proposed, shortest_step_, largest_step_);
  context_.electrics->accept(std::move(trial));
  context_.electrics->field().correct(context_.electrics->now().field);
  context_.electrics->set_extrapolation(target, Rates::kept);
  if (error_in_tolerances > allowed_correction) return target;
  // Bodies that may touch by the correction keep their positions.
  const double most = allowed_correction * context_.scene.mechanics.position_tolerance;
  correction_.apply(target - time, predicted, extrapolated().force,
                    flight_.interacting(std::vector<double>(predicted.size(), most)));
  return target;
}

/// Returns the end (s) of a step of at most `step`. A remaining interval shorter than two steps is halved, because a
/// very short last step costs as much as a full one. A remaining interval that exceeds `step` by rounding is one step.
double Split::step_end(double time, double step, double end) const {
  const double remaining = end - time, allowed = std::max(step, shortest_step_);
  return allowed > 0.999 * remaining ? end : time + std::min(allowed, 0.5 * remaining);
}

/// Shortens a step (s) to the limit of contacts whose conductance depends on the gap.
double Split::step_within_gaps(double time, double step) const {
  if (!context_.electrics->resistors().has_state_dependent_laws()) return step;
  std::vector<double> force(context_.model.bodies.position.size());
  context_.model.forces(time, force);
  return std::min(step, context_.electrics->resistors().longest_step(force));
}

/// Takes a step from the last solve, or to the first event. Returns the time reached: `time` itself if the step was
/// rejected.
double Split::try_step(double time, double end, FieldGrid grid) {
  const double target = step_end(time, step_within_gaps(time, std::min(extrapolated().time + step_, end) - time), end);
  // A rejected step has changed the bodies and, in a scene with a circuit, the heat of drag. The other electrical state
  // changes only if the trial is accepted, or at an event, which is not taken back.
  before_.position = context_.model.bodies.position;
  before_.momentum = context_.model.bodies.momentum;
  const std::optional<EnergyBudget> energy = context_.electrics->now().energy;
  const Moved moved = move(time, target);
  const double reached = moved.reached;
  if (reached < target && pass_event(moved, grid)) return reached;
  Trial trial = context_.electrics->solve(reached, grid);
  find_extrapolated_forces(reached, assumed_);
  const double error_in_tolerances =
      std::max(error(extrapolated().time, trial, assumed_), context_.electrics->resistors().charge_error(trial));
  if (error_in_tolerances > 1 && target - time > 2 * shortest_step_) {
    std::swap(context_.model.bodies.position, before_.position);
    std::swap(context_.model.bodies.momentum, before_.momentum);
    if (energy) *context_.electrics->energy() = *energy;
    reject(time, reached, error_in_tolerances, grid);
    return time;
  }
  const double since = reached - extrapolated().time;
  accept(std::move(trial), error_in_tolerances);
  if (error_in_tolerances <= 1 && moved.interacting && since > shortest_step_)
    correction_.apply(since, assumed_, extrapolated().force, *moved.interacting);
  // An error after the shortest step indicates a jump of the force.
  if (error_in_tolerances > 1) step_ = 0;
  const Regrouping regrouping = context_.electrics->reconnect(reached, moved.due_since, grid);
  if (!regrouping.merged && error_in_tolerances <= 1) return reached;
  old_force_ = extrapolated().force;
  restart(reached, error_in_tolerances > 1 ? assumed_ : old_force_);
  if (regrouping.merged) correct_after_mergers(moved, regrouping.mergers);
  return reached;
}

/// Corrects positions for group merges at the end of a move, which have changed the force from old_force_ to the
/// present one.
void Split::correct_after_mergers(const Moved& moved, std::span<const Merger> mergers) {
  const ForceJump jump{old_force_, extrapolated().force};
  mergers_.update_merge_deferral(jump);
  if (moved.interacting) mergers_.correct_positions(moved.reached, mergers, jump, *moved.interacting);
}

/// Moves the bodies under the extrapolated force to `target` or to the first contact that closes or opens. If a contact
/// closes, the motion continues for as long as the group merge may be deferred.
Split::Moved Split::move(double time, double target) {
  const ContactEvents& contacts = context_.electrics->contact_events();
  Moved moved;
  while (time < target) {
    context_.between_steps();
    find_longest_travel(context_.model, drag_, extrapolated(), time, target - time, travel_);
    reach_ = travel_;
    contacts.widen(reach_);
    moved.interacting = moved_by_cvode(travel_, reach_);
    const ContactPrediction prediction =
        contacts.predict_contacts(context_.electrics->now(), reach_, moved.interacting);
    ContactEvents::Due due = contacts.due(prediction);
    // A correction may have moved a contact across its threshold, which triggers no event. The contact was then due
    // within the last step.
    const bool crossed = due.made || due.lost;
    moved.due_since = crossed ? time - std::min(mergers_.merge_deferral(), step_) : time;
    if (!crossed) {
      moved.due_since = time = advance(time, target, contacts.events(prediction), moved.interacting);
      due = contacts.due(prediction);
    }
    moved.reached = due.made && !due.lost ? wait(time, target, prediction, moved) : time;
    if (due.lost || due.made) return moved;
    // Otherwise a collision has moved a body beyond its reach: predict contacts again.
  }
  moved.reached = moved.due_since = time;
  return moved;
}

/// Lets a group merge that is due at `time` wait for others, so that they share a field solve. The wait ends when the
/// jump of the force would have displaced a body by half a tolerance. It ends before the second half of the step, where
/// it would need another solve. It also ends when a lost contact is a tolerance beyond its threshold: its members would
/// keep wrong charges, which no correction repairs. In a scene with a circuit energy is recorded event by event, and
/// group merges do not wait.
double Split::wait(double time, double target, const ContactPrediction& prediction, const Moved& moved) {
  if (context_.electrics->resistors().any() || context_.electrics->energy()) return time;
  const double half = extrapolated().time + 0.499 * step_;
  const double limit = std::min({target, moved.due_since + mergers_.merge_deferral(), time < half ? half : target});
  return limit > time
             ? advance(time, limit, context_.electrics->contact_events().events(prediction, true), moved.interacting)
             : time;
}

/// Returns the bodies that CVODE must move, which are those that may touch another body or a wall. No value: all
/// bodies; an empty list: none. CVODE moves all bodies in a scene with a circuit, where it sums the heat of drag. It
/// also does so with nonlinear drag, which has no closed form of free flight. A body that a collision moves beyond its
/// reach ends the integration by the last of ContactEvents::events; the list covers contacts up to that reach. Without
/// contact_discharge there are no such events, and CVODE moves all bodies.
std::optional<std::vector<int>> Split::moved_by_cvode(std::span<const double> travel,
                                                      std::span<const double> reach) const {
  const Stopwatch watch(context_.counters.mechanics_seconds);
  if (context_.electrics->energy() || !context_.model.drag.is_linear()) return {};
  std::vector<int> interacting = flight_.interacting(reach);
  if (interacting.empty() || flight_.interacting(travel).empty()) return std::vector<int>();
  if (!context_.electrics->has_contacts()) return {};
  return interacting;
}

double Split::advance(double time, double target, const Events& events,
                      const std::optional<std::vector<int>>& interacting) {
  const Stopwatch watch(context_.counters.mechanics_seconds);
  if (!interacting) return cvode_.advance(time, target, events);
  if (interacting->empty()) return flight_.advance(time, target, extrapolated(), events);
  return flight_.advance(time, target, extrapolated(), events, *interacting, cvode_);
}

/// Handles contacts that are made or lost before the end of a step. A merge of groups needs a solve with the new
/// groups. A split needs none, because the groups keep their charges and potentials, and the field does not change. The
/// motion up to the event and the charges there rely on the extrapolation. In the first half of a step its error is at
/// most 1/8 of the error of the step (1/4 while the force's rate is unknown). Later, and with resistors, whose
/// conductance magnifies the error, the function returns false: the field of the old groups is needed to check the
/// step.
bool Split::pass_event(const Moved& moved, FieldGrid grid) {
  const double time = moved.reached;
  if (context_.electrics->resistors().any() || context_.electrics->has_circuits()) return false;
  if (time - extrapolated().time >= 0.5 * step_) return false;
  std::vector<double> charge(context_.model.bodies.size());
  for_ranges(*context_.model.team, context_.model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) charge[i] = extrapolated().charge_at(i, time);
  });
  context_.electrics->accept_extrapolated(time, charge);
  const Regrouping regrouping = context_.electrics->reconnect(time, moved.due_since, grid);
  if (!regrouping.merged) return true;
  ++context_.counters.steps;
  find_extrapolated_forces(time, old_force_);
  restart(time, old_force_);
  correct_after_mergers(moved, regrouping.mergers);
  return true;
}

void Split::find_extrapolated_forces(double time, std::vector<Vec3>& force) const {
  force.resize(context_.model.bodies.size());
  for_ranges(*context_.model.team, context_.model.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) force[i] = extrapolated().force_at(i, time);
  });
}

/// Returns the largest displacement of a body, in tolerances, by the defect of the force. The defect grows linearly
/// from 0 at the start of the step. Among successive identical bodies only the one with the largest defect counts.
double Split::error(double since, const Trial& trial, const std::vector<Vec3>& assumed) const {
  const std::vector<double>& mass = context_.model.bodies.mass;
  const Drag& drag = context_.model.drag;
  const auto resistance = [&](int body) {
    return drag.is_linear(body) ? drag_[body]
                                : drag.resistance(body, norm(velocity_in_space(context_.model.bodies, body)));
  };
  const auto moved_by = [&](double defect2, int body) {
    return displacement(std::sqrt(defect2), trial.time - since, mass[body], resistance(body));
  };
  const auto worst_of = [&](int first, int end) {
    double worst = 0, defect2 = 0;
    int representative = first;
    for (int i = first; i < end; ++i) {
      if (mass[i] != mass[representative] || drag_[i] != drag_[representative] || !drag.is_linear(i)) {
        worst = std::max(worst, moved_by(std::exchange(defect2, 0), representative));
        representative = i;
      }
      defect2 = std::max(defect2, norm2(trial.field.force[i] - assumed[i]));
    }
    return std::max(worst, moved_by(defect2, representative));
  };
  return largest_of_ranges(*context_.model.team, context_.model.bodies.size(), 0, worst_of) /
         context_.scene.mechanics.position_tolerance;
}

/// Accepts a trial. Its field becomes the base of the extrapolation.
void Split::accept(Trial trial, double error) {
  ++context_.counters.steps;
  const effects::ExtrapolatedField& before = extrapolated();
  const double time = trial.time, dt = time - before.time, proposed = next_step(dt, error, order(before));
  const bool cut_short = dt < step_;  // by an event or the end, which does not limit the next step
  step_ = std::clamp(cut_short ? std::max(step_, proposed) : proposed, shortest_step_, largest_step_);
  context_.electrics->accept(std::move(trial));
  context_.electrics->set_extrapolation(time, dt > shortest_step_ ? Rates::difference_quotient : Rates::kept);
}

/// Shortens the next step after a rejected one from `time` to `reached`; the bodies are at `time` again.
void Split::reject(double time, double reached, double error, FieldGrid grid) {
  ++context_.counters.rejected_steps;
  const double dt = reached - extrapolated().time;
  step_ = std::max(std::min(next_step(dt, error, order(extrapolated())), 0.5 * dt), shortest_step_);
  if (extrapolated().time == time) return;
  // Groups have split since the last solve, and a split is not taken back.
  find_extrapolated_forces(time, old_force_);
  context_.electrics->accept(context_.electrics->solve(time, grid));
  restart(time, old_force_);
}

/// Estimates the next step after a jump of the forces, as by a group merge, which makes their rates invalid. A body
/// that the jump drives at the speed jump/drag moves through a field that varies over a length. Its force then changes
/// at the rate of step_after(). The length is a radius, or the contact gap if that is less, because conductors at
/// different potentials are never closer.
void Split::restart(double time, const std::vector<Vec3>& force_before) {
  const double step = least_of_ranges(*context_.model.team, context_.model.bodies.size(), largest_step_,
                                      [&](int first, int end) { return step_after(force_before, first, end); });
  constexpr double growth = 1.1;  // lets the step recover from the largest jump if all steps end in events
  step_ = std::max(step_ == 0 ? step : std::min(step, growth * step_), shortest_step_);
  if (EnergyBudget* energy = context_.electrics->energy()) energy->reset_rates();
  context_.electrics->set_extrapolation(time, Rates::forgotten);
}

/// Returns the longest step (s) that bodies `first` to `end` (excluded) allow after a jump of their forces.
double Split::step_after(const std::vector<Vec3>& force_before, int first, int end) const {
  const std::vector<Vec3>& force = context_.electrics->now().field.force;
  const Bodies& bodies = context_.model.bodies;
  const double tolerance = context_.scene.mechanics.position_tolerance;
  double step = largest_step_, fastest_rate = 0;
  int fastest = first;
  for (int i = first; i < end; ++i) {
    const double length = std::min(bodies.radius[i], shortest_gap_);
    const Vec3 jumped = force[i] - force_before[i], velocity = velocity_in_space(bodies, i);
    const bool identical = bodies.mass[i] == bodies.mass[fastest] && drag_[i] == drag_[fastest];
    if (identical && drag_[i] > 0) {
      // (a + b)^2 <= 2 (a^2 + b^2) rules out most bodies without a square root.
      const double speed2 = std::max(norm2(velocity), norm2(force[i]) / (drag_[i] * drag_[i]));
      const double rate2 = norm2(extrapolated().force_rate[i]) + norm2(jumped) * speed2 / (length * length);
      if (2.1 * rate2 < fastest_rate * fastest_rate) continue;
    }
    const double jump = norm(jumped);
    const double speed = std::max(norm(velocity), drag_[i] > 0 ? norm(force[i]) / drag_[i] : 0);
    const double rate = norm(extrapolated().force_rate[i]) + jump * speed / length;
    // Among identical bodies that with the largest rate of the force is displaced first.
    if (!identical || rate > (1 - 1e-9) * fastest_rate) {
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
  checkpoint.reals["merger_patience"] = {mergers_.merge_deferral()};
  checkpoint.reals["charge_rate"] = extrapolated().charge_rate;
  std::vector<double>& rate = checkpoint.reals["force_rate"];
  for (const Vec3 r : extrapolated().force_rate)
    for (int k = 0; k < context_.model.bodies.dimension; ++k) rate.push_back(r[k]);
  checkpoint.integers["rates_known"] = {extrapolated().rates_known};
}

void Split::restore(const Checkpoint& checkpoint) {
  step_ = reals(checkpoint, "coupling_step", 2)[0];
  prediction_ = reals(checkpoint, "coupling_step", 2)[1];
  if (checkpoint.reals.contains("merger_patience"))
    mergers_.set_merge_deferral(reals(checkpoint, "merger_patience", 1)[0]);
  effects::ExtrapolatedField restored = extrapolated();
  restored.charge_rate = reals(checkpoint, "charge_rate", restored.charge_rate.size());
  const std::vector<double>& rate = reals(checkpoint, "force_rate", context_.model.bodies.position.size());
  for (std::size_t i = 0; i < restored.force_rate.size(); ++i)
    restored.force_rate[i] = vector_at(rate, context_.model.bodies.dimension, static_cast<int>(i));
  restored.rates_known = integers(checkpoint, "rates_known").at(0) != 0;
  context_.electrics->set_extrapolation(std::move(restored));
}

/// Returns the monolithic integrator for a scene without a field.
std::unique_ptr<Stepper> make_split(const StepperContext& context) {
  if (!context.electrics) return make_monolithic(context);
  return std::make_unique<Split>(context);
}

}  // namespace lichtenberg::mechanics
