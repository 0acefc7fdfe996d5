#include "src/mechanics/free_flight.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "src/model/body_ranges.hpp"

namespace lichtenberg::mechanics {
namespace {

/// Functions phi_1, phi_2, phi_3 of FreeFall at z. Below 0.1 they are the series, sum of (-z)^j / (j + n)!, because the
/// closed forms lose digits by cancellation.
struct Phi {
  explicit Phi(double z);
  double exponential, one, two, three;
};

Phi::Phi(double z) : exponential(std::exp(-z)) {
  if (z >= 0.1) {
    one = -std::expm1(-z) / z;
    two = (1 - one) / z;
    three = (0.5 - two) / z;
    return;
  }
  // Recurrence phi_n = 1 / n! - z phi_(n+1), from an order at which the error is below rounding.
  double phi = 1.0 / 479001600, inverse_factorial = 1.0 / 39916800;  // phi_12(0) = 1/12!, 1/11!
  for (int n = 11; n >= 1; --n) {
    phi = inverse_factorial - z * phi;
    inverse_factorial *= n;
    if (n == 3) three = phi;
    if (n == 2) two = phi;
  }
  one = phi;
}

/// Free flight of all bodies from their present state. Bodies that events watch can be moved to any time of the flight;
/// the others are moved once, at its end.
class Flight {
 public:
  /// Starts the flight at time `start` (s). `total_force`: N, [N * dimension], scratch memory, set for watched bodies.
  Flight(Model& model, const effects::ExtrapolatedField& extrapolated, double start, std::vector<int> watched,
         std::span<double> total_force)
      : bodies_(model.bodies),
        team_(*model.team),
        drag_(model.drag.linear()),
        extrapolated_(extrapolated),
        start_(start),
        watched_(std::move(watched)),
        total_force_(total_force) {
    const std::size_t d = bodies_.dimension;
    active_.resize(watched_.size());
    std::iota(active_.begin(), active_.end(), std::size_t{0});
    position_.reserve(watched_.size() * d);
    momentum_.reserve(watched_.size() * d);
    for (const int i : watched_) {
      position_.insert(position_.end(), &bodies_.position[i * d], &bodies_.position[i * d] + d);
      momentum_.insert(momentum_.end(), &bodies_.momentum[i * d], &bodies_.momentum[i * d] + d);
    }
  }

  std::span<const int> watched() const { return watched_; }
  /// Moves the watched bodies to their positions at `time` (s).
  void move_watched(double time) {
    bodies_.dimension == 3 ? move_watched_by<3>(time - start_) : move_watched_by<2>(time - start_);
  }
  /// Limits move_watched() to watched bodies among these.
  void restrict_watched(std::vector<int> bodies) {
    std::ranges::sort(bodies);
    active_.clear();
    for (std::size_t w = 0; w < watched_.size(); ++w)
      if (std::ranges::binary_search(bodies, watched_[w])) active_.push_back(w);
  }
  /// Returns force plus drag (N) on the watched bodies at the last move_watched().
  std::span<const double> total_force() const { return total_force_; }
  /// Moves all bodies except `others` (in ascending order) to their positions at `time` (s).
  void finish(double time, std::span<const int> others = {}) {
    const std::size_t d = bodies_.dimension;
    for (std::size_t w = 0; w < watched_.size(); ++w) {
      std::copy_n(&position_[w * d], d, &bodies_.position[watched_[w] * d]);
      std::copy_n(&momentum_[w * d], d, &bodies_.momentum[watched_[w] * d]);
    }
    bodies_.dimension == 3 ? finish_at<3>(time - start_, others) : finish_at<2>(time - start_, others);
  }

 private:
  template <int d>
  void move_watched_by(double t) {
    FreeFallCache last;
    for (const std::size_t w : active_) move<d, true>(watched_[w], t, &position_[w * d], &momentum_[w * d], last);
  }

  template <int d>
  void finish_at(double t, std::span<const int> others) {
    for_ranges(team_, bodies_.size(), [&](int first, int end) {
      FreeFallCache last;
      auto other = std::ranges::lower_bound(others, first);
      for (int i = first; i < end; ++i)
        if (other != others.end() && *other == i)
          ++other;
        else
          move<d, false>(i, t, &bodies_.position[i * d], &bodies_.momentum[i * d], last);
    });
  }

  /// Moves a body from its position and momentum at the start to those t (s) later.
  template <int d, bool with_force>
  void move(int i, double t, const double* position, const double* momentum, FreeFallCache& last) {
    const double mass = bodies_.mass[i], drag = drag_[i];
    const FreeFall fall = last.get(t, mass, drag);
    const Vec3 at_start = extrapolated_.force_at(i, start_), rates = extrapolated_.force_rate[i];
    for (std::size_t k = 0; k < d; ++k) {
      const double force = at_start[k], rate = rates[k];
      const double velocity = momentum[k] / mass, now = fall.final_velocity(velocity, force, rate);
      bodies_.position[i * d + k] = position[k] + fall.displacement(velocity, force, rate);
      bodies_.momentum[i * d + k] = mass * now;
      if constexpr (with_force) total_force_[i * d + k] = force + rate * t - drag * now;
    }
  }

  Bodies& bodies_;
  parallel::Team& team_;
  std::span<const double> drag_;
  const effects::ExtrapolatedField& extrapolated_;
  double start_;  ///< s
  std::vector<int> watched_;
  std::vector<std::size_t> active_;          ///< indices into watched_ of the bodies that move_watched() moves
  std::vector<double> position_, momentum_;  ///< of watched bodies, at the start
  std::span<double> total_force_;
};

/// Values of the pending events: the largest signed overshoot is negative while none has happened. Free flight has no
/// collisions, so that these are the events with predicted values.
class EventOvershoot {
 public:
  explicit EventOvershoot(const Events& events)
      : events_(events),
        values_(events.predicted_values ? events.predicted_values : events.values),
        value_(events.direction.size() - (events.predicted_values ? 1 : 0)) {}

  double evaluate() {
    if (values_) values_(value_);
    return farthest();
  }
  /// Limits the pending events to those that have not happened at the last evaluate(). Returns their overshoot.
  double update_pending() {
    pending_.resize(value_.size());
    for (std::size_t k = 0; k < value_.size(); ++k) pending_[k] = events_.direction[k] * value_[k] < 0;
    return farthest();
  }
  /// Returns the pending events that have happened at the last evaluate().
  std::vector<int> due() const {
    std::vector<int> due;
    for (std::size_t k = 0; k < value_.size(); ++k)
      if (pending_[k] && events_.direction[k] * value_[k] >= 0) due.push_back(static_cast<int>(k));
    return due;
  }

 private:
  double farthest() const {
    double farthest = -INFINITY;
    for (std::size_t k = 0; k < value_.size(); ++k)
      if (pending_.empty() || pending_[k]) farthest = std::max(farthest, events_.direction[k] * value_[k]);
    return farthest;
  }

  const Events& events_;
  const std::function<void(std::span<double>)>& values_;
  std::vector<double> value_;
  std::vector<bool> pending_;
};

/// Returns the first time after the sign change of `overshoot` in (early, late], to 1e-9 of the interval or to
/// rounding. The root finder is the Illinois variant of the secant method (Dowell & Jarratt 1971). Each point keeps
/// half the final width from the ends of the interval, so that both ends converge.
template <class Function>
double sign_change(double early, double overshoot_early, double late, double overshoot_late, Function overshoot) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(early), std::abs(late));
  const double width = std::max(1e-9 * (late - early), rounding);
  for (int side = 0; late - early > width && overshoot_late > 0;) {
    const double secant = (early * overshoot_late - late * overshoot_early) / (overshoot_late - overshoot_early);
    const double middle = std::clamp(secant, early + 0.5 * width, late - 0.5 * width);
    const double value = overshoot(middle);
    if (value < 0) {
      early = middle, overshoot_early = value;
      if (side == -1) overshoot_late *= 0.5;
      side = -1;
    } else {
      late = middle, overshoot_late = value;
      if (side == 1) overshoot_early *= 0.5;
      side = 1;
    }
  }
  return late;
}

}  // namespace

FreeFall::FreeFall(double t, double mass, double drag) {
  const Phi phi(t * drag / mass);
  displacement_per_velocity = t * phi.one;
  displacement_per_force = t * t / mass * phi.two;
  displacement_per_force_rate = t * t * t / mass * phi.three;
  velocity_per_velocity = phi.exponential;
  velocity_per_force = t / mass * phi.one;
  velocity_per_force_rate = t * t / mass * phi.two;
}

double FreeFall::displacement(double velocity, double force, double rate) const {
  return velocity * displacement_per_velocity + force * displacement_per_force + rate * displacement_per_force_rate;
}

double FreeFall::final_velocity(double velocity, double force, double rate) const {
  return velocity * velocity_per_velocity + force * velocity_per_force + rate * velocity_per_force_rate;
}

std::vector<int> FreeFlight::interacting(std::span<const double> travel) const {
  std::vector<bool> is_interacting(model_.bodies.size(), false);
  for (const auto& effect : model_.effects) effect->mark_interacting(model_.bodies, travel, is_interacting);
  if (!model_.drag.is_linear())
    for (int i = 0; i < model_.bodies.size(); ++i)
      if (!model_.drag.is_linear(i)) is_interacting[i] = true;
  std::vector<int> found;
  for (int i = 0; i < model_.bodies.size(); ++i)
    if (is_interacting[i]) found.push_back(i);
  return found;
}

namespace {

/// Returns the bodies that event functions read.
std::vector<int> bodies_read_by(const Events& events, const Bodies& bodies) {
  if (events.predicted_values || events.direction.empty()) return events.watched;
  std::vector<int> all(bodies.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Overshoot of pending events at a time (s).
struct OvershootSample {
  double time = 0, overshoot = 0;
};

/// Returns the time (s) of the first event between two times. No event happens and reverts between them. Therefore only
/// events that have happened at the later time, and the bodies that these events read, are evaluated.
double first_event(Flight& flight, const Events& events, EventOvershoot& overshoot, OvershootSample early,
                   OvershootSample late) {
  const auto sign_change_of = [&](EventOvershoot& event, double overshoot_early) {
    return sign_change(early.time, overshoot_early, late.time, late.overshoot, [&](double t) {
      flight.move_watched(t);
      return event.evaluate();
    });
  };
  if (!events.subset) return sign_change_of(overshoot, early.overshoot);
  const Events due = events.subset(overshoot.due());
  flight.restrict_watched(due.watched);
  flight.move_watched(early.time);
  EventOvershoot close(due);
  return sign_change_of(close, close.evaluate());
}

}  // namespace

double FreeFlight::advance(double start, double end, const effects::ExtrapolatedField& extrapolated,
                           const Events& events) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  Flight flight(model_, extrapolated, start, bodies_read_by(events, model_.bodies), total_force_);
  EventOvershoot overshoot(events);
  flight.move_watched(start);
  overshoot.evaluate();
  double time = start;
  while (time < end) {
    const double before = overshoot.update_pending();
    const double longest = events.longest_step ? events.longest_step(flight.total_force()) : INFINITY;
    const double next = std::min(end, time + std::max(longest, 1000 * rounding));
    flight.move_watched(next);
    const double after = overshoot.evaluate();
    if (after >= 0) {
      const double event = first_event(flight, events, overshoot, {time, before}, {next, after});
      flight.finish(event);
      return event;
    }
    time = next;
  }
  flight.finish(end);
  return end;
}

double FreeFlight::advance(double start, double end, const effects::ExtrapolatedField& extrapolated,
                           const Events& events, const std::vector<int>& interacting, Cvode& cvode) {
  std::vector<int> watched;
  for (const int i : events.watched)
    if (!std::ranges::binary_search(interacting, i)) watched.push_back(i);
  Flight flight(model_, extrapolated, start, std::move(watched), total_force_);
  const auto set_state = [&](double t) { flight.move_watched(t); };
  const auto forces = [&](double t) {
    flight.move_watched(t);
    return flight.total_force();
  };
  const double reached = cvode.advance(start, end, events, interacting,
                                       {.watched = flight.watched(), .set_state = set_state, .forces = forces});
  flight.finish(reached, interacting);
  return reached;
}

}  // namespace lichtenberg::mechanics
