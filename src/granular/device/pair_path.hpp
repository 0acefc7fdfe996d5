#pragma once

// A pair within a step of contacts, as PairMotion (../pair_motion.hpp) has it: the same equations, whose comments stand
// there, in the form that a device wants. What is divided by is known once, roots come from reciprocal ones, and what
// integrates stands at one place of a loop: threads of a warp go through all of its code together, and wait for what of
// it is not in the cache of instructions.

#include "solvers/parallel/unroll.hpp"
#include "src/granular/pair_motion.hpp"

namespace lichtenberg::granular::device {

LICHTENBERG_HOST_DEVICE inline double over_root(double x) {
#ifdef __CUDA_ARCH__
  return rsqrt(x);
#else
  return 1 / std::sqrt(x);
#endif
}
/// Of x >= 0.
LICHTENBERG_HOST_DEVICE inline double root(double x) { return x > 0 ? x * over_root(x) : 0; }

/// A contact's push at one instant.
struct Push {
  double unclamped = 0, elastic = 0, stored = 0;
  double closing = 0, over_distance = 0;

  LICHTENBERG_HOST_DEVICE double force() const { return unclamped > 0 ? unclamped : 0; }
};

/// `law` gives the ContactPush of an overlap.
template <class Law>
LICHTENBERG_HOST_DEVICE Push push_of(const Law& law, double reach, const PairState<3>& s) {
  const double distance2 = norm2(s.apart), over = over_root(distance2), overlap = reach - distance2 * over;
  const ContactPush<double> parts = law(overlap > 0 ? overlap : 0);
  const double closing = -dot(s.apart, s.velocity) * over;
  return {parts.elastic + parts.damping * closing, parts.elastic, parts.stored, closing, over};
}

template <class Law>
class PairPath {
 public:
  LICHTENBERG_HOST_DEVICE PairPath(Law law, double reach, double over_mass, const Outside<3>& outside)
      : law_(law), reach_(reach), over_mass_(over_mass), outside_(outside) {}

  /// PairMotion::over, but that nothing is said of a pair that does not touch: `touched` is negative then.
  LICHTENBERG_HOST_DEVICE PairStep<3> over(const PairState<3>& start, bool touching, double age, double dt) const {
    PairStep<3> step{.end = start};
    double begin = 0;
    if (!touching) {
      begin = time_of_touch(start, dt);
      if (begin > dt) return step;
      step.end = flown(start, 0, begin);
      step.touched = begin;
      step.impact_speed = push(step.end).closing;
    }
    const double f_begin = push(step.end).unclamped;
    if (f_begin < 0 && let_go(step, begin, dt)) return step;
    double low = begin, high = dt, f_low = f_begin, f_high = 0, at = dt;
    constexpr int regula_falsi = 3;
    PairStep<3> pressed;
    LICHTENBERG_UNROLL(1)
    for (int k = 0; k <= regula_falsi; ++k) {
      if (k > 0) {
        const double share = f_low / (f_low - f_high);
        at = low + (high - low) * (share < 0.01 ? 0.01 : share > 0.99 ? 0.99 : share);
      }
      pressed = press(step, age, begin, at);
      const double f = push(pressed.end).unclamped;
      if (k == 0 && (f_begin < 0 || f >= 0)) return pressed;
      if (k > 0 && f > 0)
        low = at, f_low = f;
      else
        high = at, f_high = f;
    }
    let_go(pressed, at, dt);
    return pressed;
  }

 private:
  LICHTENBERG_HOST_DEVICE Push push(const PairState<3>& s) const { return push_of(law_, reach_, s); }

  LICHTENBERG_HOST_DEVICE PairState<3> flown(const PairState<3>& s, double begin, double end) const {
    const double t = end - begin;
    const Vec3 first = outside_.acceleration(begin);
    return {s.apart + t * s.velocity + (0.5 * t * t) * first + (t * t * t / 6) * outside_.slope,
            s.velocity + t * first + (0.5 * t * t) * outside_.slope};
  }

  LICHTENBERG_HOST_DEVICE double time_of_touch(const PairState<3>& s, double dt) const {
    const double b = dot(s.apart, s.velocity), c = norm2(s.apart) - reach_ * reach_, v2 = norm2(s.velocity);
    if (c <= 0) return 0;
    const double inside = b * b - v2 * c;
    double t = b < 0 && inside > 0 ? c / (-b + root(inside)) : INFINITY;
    if (t > dt) {
      if (norm2(flown(s, 0, dt).apart) >= reach_ * reach_) return INFINITY;
      t = dt;
    }
    LICHTENBERG_UNROLL(1)
    for (int k = 0; k < 4; ++k) {
      const PairState<3> then = flown(s, 0, t);
      const double slope = 2 * dot(then.apart, then.velocity);
      if (slope >= 0) break;  // it grazes
      const double next = t - (norm2(then.apart) - reach_ * reach_) / slope;
      t = next > 0 ? next : 0;
    }
    return t;
  }

  LICHTENBERG_HOST_DEVICE bool let_go(PairStep<3>& step, double begin, double end) const {
    const PairState<3> then = flown(step.end, begin, end);
    const Push last = push(then);
    if (last.unclamped > 0) return false;
    step.dissipated += push(step.end).stored - last.stored;
    step.end = then;
    return true;
  }

  struct Load {
    Vec3 acceleration;
    double dissipation = 0;

    friend LICHTENBERG_HOST_DEVICE Load operator*(double s, const Load& a) {
      return {s * a.acceleration, s * a.dissipation};
    }
    friend LICHTENBERG_HOST_DEVICE Load operator+(const Load& a, const Load& b) {
      return {a.acceleration + b.acceleration, a.dissipation + b.dissipation};
    }
    friend LICHTENBERG_HOST_DEVICE Load operator-(const Load& a, const Load& b) {
      return {a.acceleration - b.acceleration, a.dissipation - b.dissipation};
    }
  };
  LICHTENBERG_HOST_DEVICE Load load(const PairState<3>& s) const {
    const Push now = push(s);
    const double force = now.force();
    return {(force * now.over_distance * over_mass_) * s.apart, (force - now.elastic) * now.closing};
  }

  LICHTENBERG_HOST_DEVICE PairStep<3> press(const PairStep<3>& step, double age, double begin, double end) const {
    if (end <= begin) return step;
    const double from = root(age), whole = root(age + (end - begin)) - from, half = 0.5 * whole, over = 1 / whole;
    // Of a load of so many terms.
    const auto state = [&]<int terms>(const Load(&of)[terms], double s) {
      const double s2 = s * s, f2 = from * from, fs = from * s;
      const double once_0 = s * (2 * from + s), once_1 = s2 * (from + 2.0 / 3 * s),
                   once_2 = s2 * s * (2.0 / 3 * from + 0.5 * s);
      const double twice_0 = s2 * (2 * f2 + 2 * fs + 0.5 * s2),
                   twice_1 = s2 * s * (2.0 / 3 * f2 + 5.0 / 6 * fs + 4.0 / 15 * s2),
                   twice_2 = s2 * s2 * (1.0 / 3 * f2 + 7.0 / 15 * fs + 1.0 / 6 * s2);
      PairStep<3> then = step;
      then.end = flown(step.end, begin, begin + once_0);
      const double once[] = {once_0, once_1, once_2}, twice[] = {twice_0, twice_1, twice_2};
      LICHTENBERG_UNROLL(3)
      for (int k = 0; k < terms; ++k) {
        then.end.velocity += once[k] * of[k].acceleration;
        then.end.apart += twice[k] * of[k].acceleration;
        then.dissipated += once[k] * of[k].dissipation;
      }
      return then;
    };
    const Load first = load(step.end);
    const Load guess = load(state({first}, half).end);
    const Load middle = load(state({first, (2 * over) * (guess - first)}, half).end);
    const Load last = load(state({first, (2 * over) * (middle - first)}, whole).end);
    return state({first, over * (4.0 * middle - 3.0 * first - last), (2 * over * over) * (first - 2.0 * middle + last)},
                 whole);
  }

  Law law_;
  double reach_, over_mass_;
  Outside<3> outside_;
};

}  // namespace lichtenberg::granular::device
