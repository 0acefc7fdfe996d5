#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/geometry/vec.hpp"
#include "src/granular/pair_state.hpp"
#include "src/model/contact_force.hpp"

namespace lichtenberg::granular {

/// The relative acceleration that all others give a pair during a step, linear in time.
template <int d>
struct Outside {
  Vec<d> start, slope;

  LICHTENBERG_HOST_DEVICE Vec<d> acceleration(double t) const { return start + t * slope; }
  /// What it alone adds to velocity and place within t.
  LICHTENBERG_HOST_DEVICE Vec<d> velocity(double t) const { return t * start + (0.5 * t * t) * slope; }
  LICHTENBERG_HOST_DEVICE Vec<d> path(double t) const { return (0.5 * t * t) * start + (t * t * t / 6) * slope; }
};

/// What the contact of a pair did within a step.
template <int d>
struct PairStep {
  PairState<d> end;
  double dissipated = 0;
  double touched = -1;      ///< instant within the step at which they touched; negative: they did not
  double impact_speed = 0;  ///< along the line of centres, then
};

/// The relative motion r'' = outside(t) + force / mass along r of two grains that are in contact or come into contact
/// within a step, by the classical
/// Runge-Kutta method in sigma = sqrt(time since they touched). The force of a viscoelastic contact begins like
/// sqrt(overlap) ~ sqrt(t), so in t no fixed step gets past order 3/2; in sigma it is smooth, and four evaluations a
/// step leave an error hundreds of times smaller (src/granular/README.md).
///
/// `Law` gives ContactParts for the overlap of this pair; none at 0 and below.
template <int d, class Law>
class PairMotion {
 public:
  LICHTENBERG_HOST_DEVICE PairMotion(Law law, double reach, double mass, const Outside<d>& outside)
      : law_(law), reach_(reach), mass_(mass), outside_(outside) {}

  /// A step of length dt of a pair that touched `age` ago.
  LICHTENBERG_HOST_DEVICE PairStep<d> in_contact(const PairState<d>& start, double age, double dt) const {
    return over(start, true, age, dt);
  }
  /// The same of a pair that is apart and may touch.
  LICHTENBERG_HOST_DEVICE PairStep<d> approaching(const PairState<d>& start, double dt) const {
    return over(start, false, 0, dt);
  }
  /// Either of them: on a device all that is common is better written once.
  LICHTENBERG_HOST_DEVICE PairStep<d> over(const PairState<d>& start, bool touching, double age, double dt) const {
    PairStep<d> step{.end = start};
    double begin = 0;
    if (!touching) {
      begin = time_of_touch(start, dt);
      if (begin > dt) return {.end = flown(start, 0, dt)};
      step.end = flown(start, 0, begin);
      step.touched = begin;
      step.impact_speed = closing(step.end);
    }
    advance(step, age, begin, dt);
    return step;
  }

  /// The repulsive force; negative where the damping would have it attract, and the contact lets go.
  LICHTENBERG_HOST_DEVICE double unclamped(const PairState<d>& s) const {
    const ContactParts parts = law_(overlap(s));
    return parts.elastic + parts.damping * closing(s);
  }
  LICHTENBERG_HOST_DEVICE double force(const PairState<d>& s) const { return std::max(unclamped(s), 0.0); }

 private:
  /// From `begin` to `end` within the step, without contact.
  LICHTENBERG_HOST_DEVICE PairState<d> flown(const PairState<d>& s, double begin, double end) const {
    const double t = end - begin;
    const Vec<d> then = outside_.velocity(begin);
    return {s.apart + t * (s.velocity - then) + (outside_.path(end) - outside_.path(begin)),
            s.velocity + (outside_.velocity(end) - then)};
  }

  /// The first instant at which the pair is `reach_` apart; infinite if there is none up to dt. Straight flight gives
  /// it in closed form; Newton's steps then take account of what bends it.
  LICHTENBERG_HOST_DEVICE double time_of_touch(const PairState<d>& s, double dt) const {
    const double b = dot(s.apart, s.velocity), c = norm2(s.apart) - reach_ * reach_, v2 = norm2(s.velocity);
    if (c <= 0) return 0;
    const auto beyond = [&](double t) { return norm2(flown(s, 0, t).apart) - reach_ * reach_; };
    const double root = b * b - v2 * c;
    double t = b < 0 && root > 0 ? c / (-b + std::sqrt(root)) : INFINITY;
    if (t > dt) {
      if (beyond(dt) >= 0) return INFINITY;
      t = dt;
    }
    for (int k = 0; k < 4; ++k) {
      const PairState<d> then = flown(s, 0, t);
      const double slope = 2 * dot(then.apart, then.velocity);
      if (slope >= 0) break;  // it grazes
      t = std::max(t - (norm2(then.apart) - reach_ * reach_) / slope, 0.0);
    }
    return t;
  }

  /// From `begin` to `end` within the step. Where the force ends within, that instant is located: the formula for
  /// smooth forces would smear the kink.
  LICHTENBERG_HOST_DEVICE void advance(PairStep<d>& step, double age, double begin, double end) const {
    if (unclamped(step.end) < 0 && let_go(step, begin, end)) return;
    PairStep<d> whole = step;
    press(whole, age, begin, end);
    const double f_begin = unclamped(step.end), f_end = unclamped(whole.end);
    if (f_begin < 0 || f_end >= 0) {
      step = whole;
      return;
    }
    PairStep<d> part = step;
    const double release = time_of_release(part, age, begin, end, f_end);
    step = part;
    let_go(step, release, end);
  }

  /// Follows a pair that pushes no more. False, and nothing changes, if it would push again.
  LICHTENBERG_HOST_DEVICE bool let_go(PairStep<d>& step, double begin, double end) const {
    const PairState<d> then = flown(step.end, begin, end);
    if (unclamped(then) > 0) return false;
    step.dissipated += stored(step.end) - stored(then);
    step.end = then;
    return true;
  }

  /// Advances a pair that pushes at `begin` but not at `end` up to where it lets go, by regula falsi.
  LICHTENBERG_HOST_DEVICE double time_of_release(PairStep<d>& step, double age, double begin, double end,
                                                 double f_end) const {
    const PairStep<d> start = step;
    double low = begin, high = end, f_low = unclamped(start.end), f_high = f_end, middle = end;
    for (int k = 0; k < 3; ++k) {
      middle = low + (high - low) * std::clamp(f_low / (f_low - f_high), 0.01, 0.99);
      step = start;
      press(step, age, begin, middle);
      const double f = unclamped(step.end);
      (f > 0 ? low : high) = middle;
      (f > 0 ? f_low : f_high) = f;
    }
    return middle;
  }

  /// Not below 0: where surfaces part or meet, rounding may put them on either side.
  LICHTENBERG_HOST_DEVICE double overlap(const PairState<d>& s) const { return std::max(reach_ - norm(s.apart), 0.0); }
  LICHTENBERG_HOST_DEVICE double stored(const PairState<d>& s) const { return law_(overlap(s)).stored; }

  /// The contact's acceleration of the pair, and the power that it takes.
  struct Load {
    Vec<d> acceleration;
    double dissipation = 0;
  };
  LICHTENBERG_HOST_DEVICE Load load(const PairState<d>& s) const {
    const double distance = norm(s.apart), speed = closing(s);
    const ContactParts parts = law_(overlap(s));
    const double repulsion = std::max(parts.elastic + parts.damping * speed, 0.0);
    return {(repulsion / (mass_ * distance)) * s.apart, (repulsion - parts.elastic) * speed};
  }

  /// Coefficients by powers of s = sigma - sigma(begin).
  struct Polynomial {
    std::array<Vec<d>, 3> acceleration;
    std::array<double, 3> dissipation;
  };
  LICHTENBERG_HOST_DEVICE static Polynomial line(const Load& at_0, const Load& at_h, double h) {
    return {{at_0.acceleration, (at_h.acceleration - at_0.acceleration) / h, {}},
            {at_0.dissipation, (at_h.dissipation - at_0.dissipation) / h, 0}};
  }
  LICHTENBERG_HOST_DEVICE static Polynomial parabola(const Load& at_0, const Load& middle, const Load& at_h, double h) {
    const auto slope = [&](auto a, auto m, auto b) { return (4.0 * m - 3.0 * a - b) / h; };
    const auto bend = [&](auto a, auto m, auto b) { return 2.0 * (a - 2.0 * m + b) / (h * h); };
    const auto [a, pa] = at_0;
    const auto [m, pm] = middle;
    const auto [b, pb] = at_h;
    return {{a, slope(a, m, b), bend(a, m, b)}, {pa, slope(pa, pm, pb), bend(pa, pm, pb)}};
  }

  /// The integral over time of a polynomial from 0 to s, dt = 2 (from + s) ds, and that integral's.
  template <class Value>
  LICHTENBERG_HOST_DEVICE static Value once(const std::array<Value, 3>& c, double from, double s) {
    return (s * (2 * from + s)) * c[0] + (s * s * (from + 2.0 / 3 * s)) * c[1] +
           (s * s * s * (2.0 / 3 * from + 0.5 * s)) * c[2];
  }
  template <class Value>
  LICHTENBERG_HOST_DEVICE static Value twice(const std::array<Value, 3>& c, double from, double s) {
    const double s2 = s * s, f2 = from * from, fs = from * s;
    return (s2 * (2 * f2 + 2 * fs + 0.5 * s2)) * c[0] +
           (s2 * s * (2.0 / 3 * f2 + 5.0 / 6 * fs + 4.0 / 15 * s2)) * c[1] +
           (s2 * s2 * (1.0 / 3 * f2 + 7.0 / 15 * fs + 1.0 / 6 * s2)) * c[2];
  }

  /// One step in sigma from `begin` to `end`: four evaluations, as in the classical Runge-Kutta method, but the path
  /// follows from the accelerations by integrating polynomials in sigma, so that just after touch, where the overlap is
  /// of second order in sigma, it has a small relative error in each stage.
  LICHTENBERG_HOST_DEVICE void press(PairStep<d>& step, double age, double begin, double end) const {
    if (end <= begin) return;
    const double from = std::sqrt(age), whole = std::sqrt(age + (end - begin)) - from, half = 0.5 * whole;
    const PairState<d> start = step.end;
    const auto state = [&](const Polynomial& p, double s) {
      PairState<d> then = flown(start, begin, begin + s * (2 * from + s));
      then.velocity += once(p.acceleration, from, s);
      then.apart += twice(p.acceleration, from, s);
      return then;
    };
    const Load first = load(start);
    const Load guess = load(state(line(first, first, half), half));
    const Load middle = load(state(line(first, guess, half), half));
    const Load last = load(state(line(first, middle, half), whole));
    const Polynomial load_fit = parabola(first, middle, last, whole);
    step.end = state(load_fit, whole);
    step.dissipated += once(load_fit.dissipation, from, whole);
  }

  Law law_;
  double reach_, mass_;
  Outside<d> outside_;
};

}  // namespace lichtenberg::granular
