#include "src/mechanics/free_flight.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "src/model/body_ranges.hpp"

namespace lichtenberg::mechanics {
namespace {

/// phi_1, phi_2, phi_3 at z. Below 0.1 they are the series, sum of (-z)^j / (j + n)!, because the closed forms cancel.
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

/// Flight of all bodies from their present state. Bodies that events watch can be placed at any time of the flight; the
/// others are moved once, at its end.
class Flight {
 public:
  /// `total_force`: N, [N * dimension], set for watched bodies.
  Flight(Model& model, const effects::HeldField& held, double start, std::vector<int> watched,
         std::span<double> total_force)
      : bodies_(model.bodies),
        team_(*model.team),
        drag_(model.drag.linear()),
        held_(held),
        start_(start),
        watched_(std::move(watched)),
        total_force_(total_force) {
    const std::size_t d = bodies_.dimension;
    shown_.resize(watched_.size());
    std::iota(shown_.begin(), shown_.end(), std::size_t{0});
    position_.reserve(watched_.size() * d);
    momentum_.reserve(watched_.size() * d);
    for (const int i : watched_) {
      position_.insert(position_.end(), &bodies_.position[i * d], &bodies_.position[i * d] + d);
      momentum_.insert(momentum_.end(), &bodies_.momentum[i * d], &bodies_.momentum[i * d] + d);
    }
  }

  std::span<const int> watched() const { return watched_; }
  /// Moves the watched bodies to their positions at `time` (s).
  void show(double time) { bodies_.dimension == 3 ? show_at<3>(time - start_) : show_at<2>(time - start_); }
  /// Limits show() to watched bodies among these.
  void show_only(std::vector<int> bodies) {
    std::ranges::sort(bodies);
    shown_.clear();
    for (std::size_t w = 0; w < watched_.size(); ++w)
      if (std::ranges::binary_search(bodies, watched_[w])) shown_.push_back(w);
  }
  /// Returns force plus drag (N) on them at the last show().
  std::span<const double> total_force() const { return total_force_; }
  /// Moves all bodies except `others` (in ascending order) to their positions at `time` (s).
  void end(double time, std::span<const int> others = {}) {
    const std::size_t d = bodies_.dimension;
    for (std::size_t w = 0; w < watched_.size(); ++w) {
      std::copy_n(&position_[w * d], d, &bodies_.position[watched_[w] * d]);
      std::copy_n(&momentum_[w * d], d, &bodies_.momentum[watched_[w] * d]);
    }
    bodies_.dimension == 3 ? end_at<3>(time - start_, others) : end_at<2>(time - start_, others);
  }

 private:
  template <int d>
  void show_at(double t) {
    LastFall last;
    for (const std::size_t w : shown_) move<d, true>(watched_[w], t, &position_[w * d], &momentum_[w * d], last);
  }

  template <int d>
  void end_at(double t, std::span<const int> others) {
    for_ranges(team_, bodies_.size(), [&](int first, int end) {
      LastFall last;
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
  void move(int i, double t, const double* position, const double* momentum, LastFall& last) {
    const double mass = bodies_.mass[i], drag = drag_[i];
    const FreeFall fall = last.of(t, mass, drag);
    const Vec3 at_start = held_.force_at(i, start_), rates = held_.force_rate[i];
    for (std::size_t k = 0; k < d; ++k) {
      const double force = at_start[k], rate = rates[k];
      const double velocity = momentum[k] / mass, now = fall.speed(velocity, force, rate);
      bodies_.position[i * d + k] = position[k] + fall.move(velocity, force, rate);
      bodies_.momentum[i * d + k] = mass * now;
      if constexpr (with_force) total_force_[i * d + k] = force + rate * t - drag * now;
    }
  }

  Bodies& bodies_;
  parallel::Team& team_;
  std::span<const double> drag_;
  const effects::HeldField& held_;
  double start_;  ///< s
  std::vector<int> watched_;
  std::vector<std::size_t> shown_;           ///< indices into watched_ of the bodies that show() moves
  std::vector<double> position_, momentum_;  ///< of watched bodies, at the start
  std::span<double> total_force_;
};

/// Largest signed overshoot of pending events; negative if all are pending. Free flight has no collisions, so that
/// these are the events with predicted values.
class Lookout {
 public:
  explicit Lookout(const Events& events)
      : events_(events),
        values_(events.foreseen_values ? events.foreseen_values : events.values),
        value_(events.direction.size() - (events.foreseen_values ? 1 : 0)) {}

  double beyond() {
    if (values_) values_(value_);
    return farthest();
  }
  /// Limits the pending events to those that have not happened at the last beyond(). Returns their overshoot.
  double look() {
    to_come_.resize(value_.size());
    for (std::size_t k = 0; k < value_.size(); ++k) to_come_[k] = events_.direction[k] * value_[k] < 0;
    return farthest();
  }
  /// Returns the pending events that have happened at the last beyond().
  std::vector<int> due() const {
    std::vector<int> due;
    for (std::size_t k = 0; k < value_.size(); ++k)
      if (to_come_[k] && events_.direction[k] * value_[k] >= 0) due.push_back(static_cast<int>(k));
    return due;
  }

 private:
  double farthest() const {
    double farthest = -INFINITY;
    for (std::size_t k = 0; k < value_.size(); ++k)
      if (to_come_.empty() || to_come_[k]) farthest = std::max(farthest, events_.direction[k] * value_[k]);
    return farthest;
  }

  const Events& events_;
  const std::function<void(std::span<double>)>& values_;
  std::vector<double> value_;
  std::vector<bool> to_come_;
};

/// Returns the first time after the sign change of `beyond` in (early, late], to 1e-9 of the interval or to rounding,
/// by the Illinois variant of the secant method (Dowell & Jarratt 1971). Each point keeps half the final width from the
/// ends of the interval, so that both ends converge.
template <class Beyond>
double sign_change(double early, double beyond_early, double late, double beyond_late, Beyond beyond) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(early), std::abs(late));
  const double width = std::max(1e-9 * (late - early), rounding);
  for (int side = 0; late - early > width && beyond_late > 0;) {
    const double secant = (early * beyond_late - late * beyond_early) / (beyond_late - beyond_early);
    const double middle = std::clamp(secant, early + 0.5 * width, late - 0.5 * width);
    const double value = beyond(middle);
    if (value < 0) {
      early = middle, beyond_early = value;
      if (side == -1) beyond_late *= 0.5;
      side = -1;
    } else {
      late = middle, beyond_late = value;
      if (side == 1) beyond_early *= 0.5;
      side = 1;
    }
  }
  return late;
}

}  // namespace

FreeFall::FreeFall(double t, double mass, double drag) {
  const Phi phi(t * drag / mass);
  of_velocity = t * phi.one;
  of_force = t * t / mass * phi.two;
  of_rate = t * t * t / mass * phi.three;
  speed_of_velocity = phi.exponential;
  speed_of_force = t / mass * phi.one;
  speed_of_rate = t * t / mass * phi.two;
}

double FreeFall::move(double velocity, double force, double rate) const {
  return velocity * of_velocity + force * of_force + rate * of_rate;
}

double FreeFall::speed(double velocity, double force, double rate) const {
  return velocity * speed_of_velocity + force * speed_of_force + rate * speed_of_rate;
}

std::vector<int> FreeFlight::pushed(std::span<const double> travel) const {
  std::vector<bool> is_pushed(model_.bodies.size(), false);
  for (const auto& effect : model_.effects) effect->mark_pushed(model_.bodies, travel, is_pushed);
  if (!model_.drag.is_linear())
    for (int i = 0; i < model_.bodies.size(); ++i)
      if (!model_.drag.is_linear(i)) is_pushed[i] = true;
  std::vector<int> found;
  for (int i = 0; i < model_.bodies.size(); ++i)
    if (is_pushed[i]) found.push_back(i);
  return found;
}

namespace {

/// Returns the bodies that event functions read.
std::vector<int> seen_by(const Events& events, const Bodies& bodies) {
  if (events.foreseen_values || events.direction.empty()) return events.watched;
  std::vector<int> all(bodies.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Overshoot of pending events at a time (s).
struct Beyond {
  double time = 0, by = 0;
};

/// Returns the time (s) of the first event between two times. No event happens and reverts between them, so that only
/// events that have happened at the later time, and the bodies that these read, are evaluated.
double first_event(Flight& flight, const Events& events, Lookout& lookout, Beyond early, Beyond late) {
  const auto sign_change_of = [&](Lookout& seen, double beyond_early) {
    return sign_change(early.time, beyond_early, late.time, late.by, [&](double t) {
      flight.show(t);
      return seen.beyond();
    });
  };
  if (!events.only) return sign_change_of(lookout, early.by);
  const Events due = events.only(lookout.due());
  flight.show_only(due.watched);
  flight.show(early.time);
  Lookout close(due);
  return sign_change_of(close, close.beyond());
}

}  // namespace

double FreeFlight::advance(double start, double end, const effects::HeldField& held, const Events& events) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  Flight flight(model_, held, start, seen_by(events, model_.bodies), total_force_);
  Lookout lookout(events);
  flight.show(start);
  lookout.beyond();
  double time = start;
  while (time < end) {
    const double before = lookout.look();
    const double longest = events.longest_step ? events.longest_step(flight.total_force()) : INFINITY;
    const double next = std::min(end, time + std::max(longest, 1000 * rounding));
    flight.show(next);
    const double after = lookout.beyond();
    if (after >= 0) {
      const double event = first_event(flight, events, lookout, {time, before}, {next, after});
      flight.end(event);
      return event;
    }
    time = next;
  }
  flight.end(end);
  return end;
}

double FreeFlight::advance(double start, double end, const effects::HeldField& held, const Events& events,
                           const std::vector<int>& pushed, Cvode& cvode) {
  std::vector<int> watched;
  for (const int i : events.watched)
    if (!std::ranges::binary_search(pushed, i)) watched.push_back(i);
  Flight flight(model_, held, start, std::move(watched), total_force_);
  const auto place = [&](double t) { flight.show(t); };
  const auto forces = [&](double t) {
    flight.show(t);
    return flight.total_force();
  };
  const double reached =
      cvode.advance(start, end, events, pushed, {.watched = flight.watched(), .place = place, .forces = forces});
  flight.end(reached, pushed);
  return reached;
}

}  // namespace lichtenberg::mechanics
