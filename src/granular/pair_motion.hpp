#pragma once

#include <cmath>

#include "src/granular/lanes.hpp"
#include "src/granular/pair_state.hpp"
#include "src/model/contact_force.hpp"

namespace lichtenberg::granular {

/// The relative acceleration that all others give a pair during a step, linear in time.
template <int d, class Real = double>
struct Outside {
  typename VecOf<d, Real>::type start, slope;

  LICHTENBERG_HOST_DEVICE auto acceleration(const Real& t) const { return start + t * slope; }
  /// What it alone adds to velocity and place within t.
  LICHTENBERG_HOST_DEVICE auto velocity(const Real& t) const { return t * start + (0.5 * t * t) * slope; }
  LICHTENBERG_HOST_DEVICE auto path(const Real& t) const {
    return (0.5 * t * t) * start + (t * t * t * (1.0 / 6)) * slope;
  }
};

/// What the contact of a pair did within a step.
template <int d, class Real = double>
struct PairStep {
  PairState<d, Real> end;
  Real dissipated = 0;
  Real touched = -1;      ///< instant within the step at which they touched; negative: they did not
  Real impact_speed = 0;  ///< along the line of centres, then
};

/// What only a contact's motion changes.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE PairStep<d, Real> chosen(const Which<Real>& which, const PairStep<d, Real>& yes,
                                                 const PairStep<d, Real>& no) {
  return {chosen(which, yes.end, no.end), chosen<Real>(which, yes.dissipated, no.dissipated), no.touched,
          no.impact_speed};
}

/// The relative motion r'' = outside(t) + force / mass along r of two grains that are in contact or come into contact
/// within a step, by the classical Runge-Kutta method in sigma = sqrt(time since they touched). The force of a
/// viscoelastic contact begins like sqrt(overlap) ~ sqrt(t), so in t no fixed step gets past order 3/2; in sigma it is
/// smooth, and four evaluations a step leave an error hundreds of times smaller (src/granular/README.md).
///
/// Of one pair or, with a `Real` of several lanes, of as many at once, with the same arithmetic for each.
/// `Law` gives ContactPush for the overlap of this pair.
template <int d, class Law, class Real = double>
class PairMotion {
 public:
  using V = typename VecOf<d, Real>::type;
  using State = PairState<d, Real>;
  using Step = PairStep<d, Real>;
  using Mask = Which<Real>;

  PairMotion(const Law& law, const Real& reach, const Real& mass, const Outside<d, Real>& outside)
      : law_(law), reach_(reach), acceleration_a_force_(1.0 / mass), outside_(outside) {}

  /// A step of length dt of a pair that touched `age` ago, or that is apart and may touch.
  Step over(const State& start, const Mask& touching, const Real& age, double dt) const {
    Begun begun = begin(start, touching, age, dt);
    const Mask lets_go = go_on(begun, dt);
    if (any(lets_go)) {
      const Step released = let_go_within(begun, dt);
      begun.step = chosen(lets_go, released, begun.step);
    }
    return begun.step;
  }

  // The same in parts, so that pairs of which the force ends within the step can be put together.

  struct Begun {
    Step step;   ///< up to `from`
    Real from;   ///< within the step
    Real age;    ///< of the contact, then
    Mask moves;  ///< not: it is apart throughout the step
  };
  /// Up to the beginning of the contact.
  Begun begin(const State& start, const Mask& touching, const Real& age, double dt) const {
    Begun begun{.step = {.end = start}, .from = 0, .age = age, .moves = touching};
    if (!any(!touching)) return begun;
    const Real t = time_of_touch(start, dt);
    const Mask meets = !touching && t <= dt;
    begun.moves = begun.moves || meets;
    begun.from = chosen<Real>(meets, t, 0);
    begun.age = chosen<Real>(meets, 0, age);
    begun.step.end = flown(start, 0, chosen<Real>(touching, 0, not_above<Real>(t, dt)));
    begun.step.touched = chosen<Real>(meets, t, -1);
    begun.step.impact_speed = chosen<Real>(meets, closing(begun.step.end), 0);
    return begun;
  }

  /// And on to the end of the step. True where the force ends within, and nothing has changed: the formula for smooth
  /// forces would smear the kink.
  Mask go_on(Begun& begun, double dt) const {
    Mask rest = begun.moves;
    if (!any(rest)) return rest;
    const Load first = load(begun.step.end);
    const Mask pulls = rest && first.unclamped < 0;
    if (any(pulls)) rest = rest && !let_go(begun.step, pulls, begun.from, dt);
    if (!any(rest)) return rest;
    Step whole = begun.step;
    press(whole, first, begun.age, begun.from, dt);
    const Mask lets_go = rest && first.unclamped >= 0 && unclamped(whole.end) < 0;
    begun.step = chosen(rest && !lets_go, whole, begun.step);
    return lets_go;
  }

  /// To the end of the step with a force that ends within: advances to the instant at which it does, by regula falsi,
  /// and follows the pair that pushes no more.
  Step let_go_within(const Begun& begun, double dt) const {
    const Load first = load(begun.step.end);
    const auto pressed = [&](const Real& end) {
      Step step = begun.step;
      press(step, first, begun.age, begun.from, end);
      return step;
    };
    Step step = pressed(dt);
    Real low = begun.from, high = dt, f_low = first.unclamped, f_high = unclamped(step.end), middle = dt;
    for (int k = 0; k < 3; ++k) {
      const Real part = f_low / (f_low - f_high);
      middle = low + (high - low) * not_above<Real>(not_below<Real>(part, 0.01), 0.99);
      step = pressed(middle);
      const Real f = unclamped(step.end);
      const Mask pushes = f > 0;
      low = chosen<Real>(pushes, middle, low);
      f_low = chosen<Real>(pushes, f, f_low);
      high = chosen<Real>(pushes, high, middle);
      f_high = chosen<Real>(pushes, f_high, f);
    }
    let_go(step, begun.moves, middle, dt);
    return step;
  }

  /// On the second of a pair; zero on those that do not touch.
  V force(const State& s) const {
    using std::sqrt;
    const Real distance = sqrt(norm2(s.apart)), over = 1.0 / distance, speed = -over * dot(s.apart, s.velocity);
    const ContactPush<Real> push = law_(overlap(distance));
    const Real force = not_below<Real>(push.elastic + push.damping * speed, 0);
    return chosen<Real>(distance < reach_, force * over, 0) * s.apart;
  }

 private:
  /// From `begin` to `end` within the step, without contact.
  State flown(const State& s, const Real& begin, const Real& end) const {
    const Real t = end - begin;
    const V then = outside_.velocity(begin);
    return {s.apart + t * (s.velocity - then) + (outside_.path(end) - outside_.path(begin)),
            s.velocity + (outside_.velocity(end) - then)};
  }

  /// The first instant at which the pair is `reach_` apart; infinite if there is none up to dt. Straight flight gives
  /// it in closed form; Newton's steps then take account of what bends it.
  Real time_of_touch(const State& s, double dt) const {
    using std::sqrt;
    const Real b = dot(s.apart, s.velocity), c = norm2(s.apart) - reach_ * reach_, v2 = norm2(s.velocity);
    const auto beyond = [&](const State& then) { return norm2(then.apart) - reach_ * reach_; };
    const Real root = b * b - v2 * c;
    const Mask meets = b < 0 && root > 0;
    Real t = chosen<Real>(meets, c / (sqrt(not_below<Real>(root, 0)) - b), INFINITY);
    const Mask late = t > dt;
    Mask none = late;
    if (any(late)) none = late && beyond(flown(s, 0, dt)) >= 0;
    t = not_above<Real>(t, dt);
    Mask bends = !none;
    for (int k = 0; k < 4 && any(bends); ++k) {
      const State then = flown(s, 0, t);
      const Real slope = 2 * dot(then.apart, then.velocity);
      bends = bends && slope < 0;  // or it grazes
      t = chosen<Real>(bends, not_below<Real>(t - beyond(then) / slope, 0), t);
    }
    return chosen<Real>(c <= 0, 0, chosen<Real>(none, INFINITY, t));
  }

  /// Of pairs that push no more: follows those up to `end` that would not push again.
  Mask let_go(Step& step, const Mask& which, const Real& begin, const Real& end) const {
    const State then = flown(step.end, begin, end);
    const Mask gone = which && !(unclamped(then) > 0);
    step.dissipated += chosen<Real>(gone, stored(step.end) - stored(then), 0);
    step.end = chosen(gone, then, step.end);
    return gone;
  }

  /// The repulsive force; below 0 where the damping would have it attract, and the contact lets go.
  Real unclamped(const State& s) const { return load(s).unclamped; }
  /// Not below 0: where surfaces part or meet, rounding may put them on either side.
  Real overlap(const Real& distance) const { return not_below<Real>(reach_ - distance, 0); }
  Real stored(const State& s) const {
    using std::sqrt;
    return law_(overlap(sqrt(norm2(s.apart)))).stored;
  }

  /// The contact's acceleration of the pair, the power that it takes, and its force before it is clamped.
  struct Load {
    V acceleration;
    Real dissipation, unclamped;
  };
  Load load(const State& s) const {
    using std::sqrt;
    const Real distance = sqrt(norm2(s.apart)), over = 1.0 / distance, speed = -over * dot(s.apart, s.velocity);
    const ContactPush<Real> push = law_(overlap(distance));
    const Real force = push.elastic + push.damping * speed, repulsion = not_below<Real>(force, 0);
    return {(repulsion * acceleration_a_force_ * over) * s.apart, (repulsion - push.elastic) * speed, force};
  }

  // Polynomials: coefficients by powers of s = sigma - sigma(begin).
  template <class Value>
  static std::array<Value, 2> line(const Value& at_0, const Value& at_h, const Real& over_h) {
    return {at_0, over_h * (at_h - at_0)};
  }
  template <class Value>
  static std::array<Value, 3> parabola(const Value& at_0, const Value& middle, const Value& at_h, const Real& over_h) {
    const Real four = 4, three = 3, two = 2;
    return {at_0, over_h * (four * middle - three * at_0 - at_h),
            (two * over_h * over_h) * (at_0 - two * middle + at_h)};
  }

  /// The integral over time of a polynomial from 0 to s, dt = 2 (from + s) ds, and that integral's.
  template <class Value, std::size_t n>
  static Value once(const std::array<Value, n>& c, const Real& from, const Real& s) {
    Value sum = (s * (2.0 * from + s)) * c[0];
    if constexpr (n > 1) sum += (s * s * (from + (2.0 / 3) * s)) * c[1];
    if constexpr (n > 2) sum += (s * s * s * ((2.0 / 3) * from + 0.5 * s)) * c[2];
    return sum;
  }
  template <class Value, std::size_t n>
  static Value twice(const std::array<Value, n>& c, const Real& from, const Real& s) {
    const Real s2 = s * s, f2 = from * from, fs = from * s;
    Value sum = (s2 * (2.0 * f2 + 2.0 * fs + 0.5 * s2)) * c[0];
    if constexpr (n > 1) sum += (s2 * s * ((2.0 / 3) * f2 + (5.0 / 6) * fs + (4.0 / 15) * s2)) * c[1];
    if constexpr (n > 2) sum += (s2 * s2 * ((1.0 / 3) * f2 + (7.0 / 15) * fs + (1.0 / 6) * s2)) * c[2];
    return sum;
  }

  /// One step in sigma from `begin` to `end`, with the load at `begin`: four evaluations, as in the classical
  /// Runge-Kutta method, but the path follows from the accelerations by integrating polynomials in sigma, so that just
  /// after touch, where the overlap is of second order in sigma, it has a small relative error in each stage.
  void press(Step& step, const Load& first, const Real& age, const Real& begin, const Real& end) const {
    using std::sqrt;
    const Mask longer = end > begin;
    if (!any(longer)) return;
    const Real from = sqrt(age), whole = sqrt(age + (end - begin)) - from, half = 0.5 * whole;
    const Real over_whole = 1.0 / whole, over_half = 2.0 * over_whole;
    const State start = step.end;
    const auto state = [&](const auto& acceleration, const Real& s) {
      State then = flown(start, begin, begin + s * (2.0 * from + s));
      then.velocity += once(acceleration, from, s);
      then.apart += twice(acceleration, from, s);
      return then;
    };
    const V a = first.acceleration;
    const Load guess = load(state(std::array{a}, half));
    const Load middle = load(state(line(a, guess.acceleration, over_half), half));
    const Load last = load(state(line(a, middle.acceleration, over_half), whole));
    const auto power = parabola(first.dissipation, middle.dissipation, last.dissipation, over_whole);
    step.end = chosen(longer, state(parabola(a, middle.acceleration, last.acceleration, over_whole), whole), start);
    step.dissipated += chosen<Real>(longer, once(power, from, whole), 0);
  }

  Law law_;
  Real reach_, acceleration_a_force_;
  Outside<d, Real> outside_;
};

}  // namespace lichtenberg::granular
