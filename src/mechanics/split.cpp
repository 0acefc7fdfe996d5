#include "src/mechanics/split.hpp"

#include <algorithm>
#include <cmath>

#include "src/mechanics/checkpoint.hpp"
#include "src/mechanics/step_control.hpp"

namespace lichtenberg::mechanics {

Split::Split(Workplace workplace)
    : at_(workplace),
      cvode_(make_cvode(at_.scene, at_.model)),
      drag_(drag_coefficients(at_.model)),
      largest_step_(at_.scene.mechanics.largest_step),
      shortest_step_(1e-6 * largest_step_),
      force_(at_.model.bodies.size()),
      rate_(at_.model.bodies.size()) {}

void Split::begin(double) {
  if (step_ == 0) return restart(force_);
  force_ = at_.electrics->last().force;
}

void Split::advance(double time, double end) {
  while (time < end) time = try_step(time, end);
}

/// Returns the time reached: `time` itself if the step was rejected.
double Split::try_step(double time, double end) {
  // A rest shorter than two steps is halved: a sliver at the end would cost as much as a whole step. The rounding of
  // times must not make one, either.
  const double room = end - time;
  const double target = step_ > 0.999 * room ? end : time + std::min(step_, 0.5 * room);
  Bodies& bodies = at_.model.bodies;
  const std::vector<double> position = bodies.position, momentum = bodies.momentum;

  const double reached = move(time, target);
  const double dt = reached - time;
  // A merger ended the step before the error control would have: no need to see its error, and the field of the old
  // groups is of no more use. One solve, with the new ones, will do.
  if (reached < target && !at_.electrics->about_to_part() && at_.electrics->reconnect(reached)) {
    ++at_.counters.steps;
    restart(held_forces(reached));
    return reached;
  }
  at_.electrics->solve(reached);
  const double wrong_by = error(reached, dt);
  if (wrong_by > 1 && dt > shortest_step_) {
    bodies.position = position;
    bodies.momentum = momentum;
    reject(dt, wrong_by);
    return time;
  }
  accept(dt, wrong_by, dt < step_);
  at_.electrics->settle(reached);
  if (at_.electrics->reconnect(reached)) restart(force_);
  return reached;
}

/// Moves the bodies under the extrapolated force to `target` or to the first contact made or lost on the way.
double Split::move(double time, double target) {
  at_.electrics->field().hold(time, force_, rate_);
  const double dt = target - time;
  std::vector<Vec2> largest_force = force_;
  for (std::size_t i = 0; i < force_.size(); ++i)
    largest_force[i] += std::copysign(dt, dot(force_[i], rate_[i])) * rate_[i];
  const Events events = at_.electrics->events(longest_travel(at_.model, drag_, largest_force, dt));
  const Stopwatch watch(at_.counters.mechanics_seconds);
  return cvode_.advance(time, target, events);
}

std::vector<Vec2> Split::held_forces(double time) const {
  std::vector<Vec2> held;
  for (int i = 0; i < at_.model.bodies.size(); ++i) held.push_back(at_.electrics->field().held_force(i, time));
  return held;
}

/// The worst body's displacement by the extrapolation's defect, in tolerances.
double Split::error(double time, double dt) const {
  double worst = 0;
  for (int i = 0; i < at_.model.bodies.size(); ++i) {
    const Vec2 defect = at_.electrics->last().force[i] - at_.electrics->field().held_force(i, time);
    worst = std::max(worst, displacement(norm(defect), dt, at_.model.bodies.mass[i], drag_[i]));
  }
  return worst / at_.scene.mechanics.position_tolerance;
}

void Split::accept(double dt, double error, bool cut_short) {
  ++at_.counters.steps;
  const double proposed = next_step(dt, error, rate_known_ ? 3 : 2);
  step_ = std::clamp(cut_short ? std::max(step_, proposed) : proposed, shortest_step_, largest_step_);
  const std::vector<Vec2>& force = at_.electrics->last().force;
  if (dt > shortest_step_) {
    for (std::size_t i = 0; i < force.size(); ++i) rate_[i] = (force[i] - force_[i]) / dt;
    rate_known_ = true;
  }
  force_ = force;
}

void Split::reject(double dt, double error) {
  ++at_.counters.rejected_steps;
  step_ = std::max(std::min(next_step(dt, error, rate_known_ ? 3 : 2), 0.5 * dt), shortest_step_);
}

/// The groups have changed, and forces have jumped: what is known of their rates no longer holds. A body that a force
/// jump drives at jump/drag through a field that varies over one radius sees its force change at the rate below.
void Split::restart(const std::vector<Vec2>& force_before) {
  const std::vector<Vec2>& force = at_.electrics->last().force;
  const Bodies& bodies = at_.model.bodies;
  double step = largest_step_;
  for (int i = 0; i < bodies.size(); ++i) {
    const double jump = norm(force[i] - force_before[i]);
    const double speed = std::max(norm(velocity(bodies, i)), drag_[i] > 0 ? norm(force[i]) / drag_[i] : 0);
    const double rate = norm(rate_[i]) + jump * speed / bodies.radius[i];
    step = std::min(step, time_to_displace(at_.scene.mechanics.position_tolerance, rate, bodies.mass[i], drag_[i]));
  }
  step_ = std::max(step_ == 0 ? step : std::min(step, step_), shortest_step_);
  force_ = force;
  std::ranges::fill(rate_, Vec2{});
  rate_known_ = false;
}

void Split::save(Checkpoint& checkpoint) const {
  checkpoint.reals["coupling_step"] = {step_};
  std::vector<double>& rate = checkpoint.reals["force_rate"];
  for (const Vec2 r : rate_) rate.insert(rate.end(), {r.x, r.y});
  checkpoint.integers["force_rate_known"] = {rate_known_};
}

void Split::restore(const Checkpoint& checkpoint) {
  step_ = reals(checkpoint, "coupling_step", 1).front();
  const std::vector<double>& rate = reals(checkpoint, "force_rate", 2 * rate_.size());
  for (std::size_t i = 0; i < rate_.size(); ++i) rate_[i] = {rate[2 * i], rate[2 * i + 1]};
  rate_known_ = integers(checkpoint, "force_rate_known").at(0) != 0;
}

}  // namespace lichtenberg::mechanics
