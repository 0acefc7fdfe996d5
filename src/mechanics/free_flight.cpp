#include "src/mechanics/free_flight.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

namespace lichtenberg::mechanics {
namespace {

/// phi_1, phi_2, phi_3 at z; below 0.1 their series, sum of (-z)^j / (j + n)!, since the closed forms cancel.
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
  // From phi_n = 1 / n! - z phi_(n+1), begun where the rest is below rounding.
  double phi = 1.0 / 479001600, inverse_factorial = 1.0 / 39916800;  // phi_12(0) = 1/12!, 1/11!
  for (int n = 11; n >= 1; --n) {
    phi = inverse_factorial - z * phi;
    inverse_factorial *= n;
    if (n == 3) three = phi;
    if (n == 2) two = phi;
  }
  one = phi;
}

/// A flight of all bodies from where they are now.
class Flight {
 public:
  Flight(Model& model, std::span<const double> drag, std::span<const Vec3> force, std::span<const Vec3> rate)
      : bodies_(model.bodies),
        start_(model.bodies.position),
        momentum_(model.bodies.momentum),
        drag_(drag),
        force_(force),
        rate_(rate),
        total_(start_.size()) {
    all_.resize(bodies_.size());
    std::iota(all_.begin(), all_.end(), 0);
  }

  /// Puts the bodies where they are after t (s), with the force and drag on them.
  void go_to(double t) { go_to(t, all_); }
  /// Some of them; the others stay.
  void go_to(double t, std::span<const int> which) {
    double mass = 0, drag = -1;
    std::optional<FreeFall> fall;
    for (const int i : which) {
      if (!fall || bodies_.mass[i] != mass || drag_[i] != drag)
        fall.emplace(t, mass = bodies_.mass[i], drag = drag_[i]);
      for (int k = 0; k < bodies_.dimension; ++k) {
        const std::size_t c = i * bodies_.dimension + k;
        const double force = force_[i][k], rate = rate_[i][k];
        const double velocity = momentum_[c] / mass, now = fall->speed(velocity, force, rate);
        bodies_.position[c] = start_[c] + fall->move(velocity, force, rate);
        bodies_.momentum[c] = mass * now;
        total_[c] = force + rate * t - drag * now;
      }
    }
  }
  /// Force and drag (N) where the bodies are that have gone there last.
  std::span<const double> total_force() const { return total_; }

 private:
  Bodies& bodies_;
  std::vector<double> start_, momentum_;
  std::span<const double> drag_;
  std::span<const Vec3> force_, rate_;
  std::vector<double> total_;
  std::vector<int> all_;
};

/// How far the bodies as they are are beyond the event that was still to come at the last look and is now farthest
/// gone; negative if all are still to come. Nothing throws bodies in flight: events that can be foreseen are all.
class Lookout {
 public:
  explicit Lookout(const Events& events)
      : events_(events),
        values_(events.foreseen_values ? events.foreseen_values : events.values),
        value_(events.direction.size() - (events.foreseen_values ? 1 : 0)) {}

  double beyond() {
    if (values_) values_(value_);
    double farthest = -INFINITY;
    for (std::size_t k = 0; k < value_.size(); ++k)
      if (to_come_.empty() || to_come_[k]) farthest = std::max(farthest, events_.direction[k] * value_[k]);
    return farthest;
  }
  /// From now on only those count that are still to come for the values of the last beyond().
  void look() {
    to_come_.resize(value_.size());
    for (std::size_t k = 0; k < value_.size(); ++k) to_come_[k] = events_.direction[k] * value_[k] < 0;
  }

 private:
  const Events& events_;
  const std::function<void(std::span<double>)>& values_;
  std::vector<double> value_;
  std::vector<bool> to_come_;
};

/// The first time after the sign change of `beyond` in (early, late], to 1e-9 of that interval or to rounding: the
/// secant through values of both signs (Dowell & Jarratt 1971, "Illinois"), which never goes so close to an end of the
/// interval that the other end would stay where it is.
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
  for (const auto& effect : model_.effects)
    if (!effect->is_held_or_drag()) effect->mark_pushed(model_.bodies, travel, is_pushed);
  std::vector<int> found;
  for (int i = 0; i < model_.bodies.size(); ++i)
    if (is_pushed[i]) found.push_back(i);
  return found;
}

double FreeFlight::advance(double start, double end, std::span<const Vec3> force, std::span<const Vec3> rate,
                           const Events& events) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  Flight flight(model_, drag_, force, rate);
  Lookout lookout(events);
  const auto go_to = [&](double t) {
    if (events.foreseen_values)
      flight.go_to(t - start, events.watched);
    else
      flight.go_to(t - start);
  };
  go_to(start);
  double time = start, before = lookout.beyond();
  while (time < end) {
    lookout.look();
    before = lookout.beyond();
    const double longest = events.longest_step ? events.longest_step(flight.total_force()) : INFINITY;
    const double next = std::min(end, time + std::max(longest, 1000 * rounding));
    const auto beyond = [&](double t) {
      go_to(t);
      return lookout.beyond();
    };
    const double after = beyond(next);
    if (after >= 0) {
      const double event = sign_change(time, before, next, after, beyond);
      flight.go_to(event - start);
      return event;
    }
    time = next;
  }
  flight.go_to(end - start);
  return end;
}

double FreeFlight::advance(double start, double end, std::span<const Vec3> force, std::span<const Vec3> rate,
                           const Events& events, const std::vector<int>& pushed, Cvode& cvode) {
  Flight flight(model_, drag_, force, rate);
  std::vector<bool> flies(model_.bodies.size(), true);
  for (const int i : pushed) flies[i] = false;
  std::vector<int> flying, watched;
  for (int i = 0; i < model_.bodies.size(); ++i)
    if (flies[i]) flying.push_back(i);
  for (const int i : events.watched)
    if (flies[i]) watched.push_back(i);
  const auto place = [&](double t) { flight.go_to(t - start, watched); };
  const auto forces = [&](double t) {
    place(t);
    return flight.total_force();
  };
  const double reached =
      cvode.advance(start, end, events, pushed, {.watched = watched, .place = place, .forces = forces});
  flight.go_to(reached - start, flying);
  return reached;
}

}  // namespace lichtenberg::mechanics
