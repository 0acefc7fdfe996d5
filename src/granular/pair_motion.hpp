#pragma once

// The motion of two grains in contact over one step. The CPU computes several pairs in a vector register, and devices
// compute one pair per thread, from this source.

#include <cmath>

#include "solvers/parallel/unroll.hpp"
#include "src/granular/lanes.hpp"
#include "src/granular/pair_state.hpp"
#include "src/model/contact_force.hpp"

namespace lichtenberg::granular {

/// Relative acceleration of two grains in a step by all forces except their own contact: start + t * slope, t the time
/// since the start of the step (reduced units). `Real` is a double, or a SIMD vector of several pairs.
template <int d, class Real = double>
struct ExternalAcceleration {
  typename VecOf<d, Real>::type start, slope;

  /// Returns the change of the relative velocity from time 0 to t due to this acceleration alone.
  LICHTENBERG_HOST_DEVICE auto velocity(const Real& t) const { return t * start + (0.5 * t * t) * slope; }
  /// Returns the relative displacement from time 0 to t due to this acceleration alone.
  LICHTENBERG_HOST_DEVICE auto path(const Real& t) const {
    return (0.5 * t * t) * start + (t * t * t * (1.0 / 6)) * slope;
  }
};

/// Returns the relative acceleration linear in time with the given values at the start and in the middle of a step of
/// length dt.
template <int d, class Real, class Vector>
LICHTENBERG_HOST_DEVICE ExternalAcceleration<d, Real> external_from_values(const Vector& start, const Vector& middle,
                                                                           double dt) {
  return {start, Real(2 / dt) * (middle - start)};
}

/// Returns the state of a pair after a time t of constant relative acceleration, from the state s.
template <int d, class Real, class Vector>
LICHTENBERG_HOST_DEVICE PairState<d, Real> accelerated(const PairState<d, Real>& s, const Vector& acceleration,
                                                       const Real& t) {
  const Real half_square = 0.5 * t * t;
  return {s.separation + t * s.velocity + half_square * acceleration, s.velocity + t * acceleration};
}

/// Result of the relative motion of a pair over a step, in reduced units.
template <int d, class Real = double>
struct PairStep {
  PairState<d, Real> end;  ///< state at the end of the step
  Real dissipated = 0;     ///< energy that the contact dissipated
  Real onset = -1;         ///< time of the contact's onset since the start of the step; negative: no onset
  Real impact_speed = 0;   ///< closing speed at the onset
};

/// Returns the end state and dissipated energy of `yes` in the lanes where the condition `which` holds, and of `no` in
/// the others. Onset and impact speed are always those of `no`.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE PairStep<d, Real> chosen(const MaskOf<Real>& which, const PairStep<d, Real>& yes,
                                                 const PairStep<d, Real>& no) {
  return {chosen(which, yes.end, no.end), chosen<Real>(which, yes.dissipated, no.dissipated), no.onset,
          no.impact_speed};
}

/// Impulse and shift (displacement times mass) of the second grain of a pair due to their contact in a step. The first
/// grain has the opposite impulse and shift.
template <class Vector>
struct ContactTransfer {
  Vector impulse;
  Vector shift;  ///< displacement times mass of the grain
};
/// Returns the impulse and shift (displacement times mass) due to the contact of a pair in a step of length dt. These
/// are the changes of the relative state from `start` to `end` minus those due to the initial velocity and to
/// `external`, times the reduced mass `mass`.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE ContactTransfer<typename VecOf<d, Real>::type> transfer(
    const PairState<d, Real>& start, const PairState<d, Real>& end, const ExternalAcceleration<d, Real>& external,
    const Real& mass, const Real& dt) {
  return {mass * (end.velocity - start.velocity - external.velocity(dt)),
          mass * (end.separation - start.separation - dt * start.velocity - external.path(dt))};
}

/// Integrates the relative motion r'' = external(t) + force / (reduced mass) of two grains over a step in which they
/// are or come in contact. The force acts along r, the vector between their centres. The integrator is a four-stage
/// Runge-Kutta method in sigma = sqrt(time since the onset). The force of a viscoelastic contact begins like
/// sqrt(overlap) ~ sqrt(t), so a method in t would have at most order 3/2; in sigma the force is smooth
/// (docs/measurements/granular.json).
///
/// `Real` is a double, or a SIMD vector of several pairs with the same arithmetic in each lane. `Law` is a function
/// that returns the ContactForceTerms of the pair for an overlap. Reduced units.
template <int d, class Law, class Real = double>
class PairMotion {
 public:
  using V = typename VecOf<d, Real>::type;
  using State = PairState<d, Real>;
  using Step = PairStep<d, Real>;
  using Mask = MaskOf<Real>;

  /// Sets the contact law, `reach` (sum of the radii), `inverse_mass` (1 / reduced mass), and the relative acceleration
  /// by all other forces.
  LICHTENBERG_HOST_DEVICE PairMotion(const Law& law, const Real& reach, const Real& inverse_mass,
                                     const ExternalAcceleration<d, Real>& external)
      : law_(law), reach_(reach), inverse_mass_(inverse_mass), external_(external) {}

  /// Integrates one pair over a step of length dt from the state `start`. `touching`: true if the grains are in
  /// contact, whose onset was a time `age` before the step; false if they are separate and may touch. One loop
  /// integrates all cases, because the threads of a device's warp run through all code together.
  LICHTENBERG_HOST_DEVICE Step integrate(const State& start, bool touching, const Real& age, double dt) const {
    PartialStep begun = begin(start, touching, age, dt);
    if (!begun.moves) return begun.step;
    const Load first = load(begun.step.end);
    if (first.unclamped < 0 && release_contact(begun.step, true, begun.from, dt)) return begun.step;
    return integrate_to_end(begun, first, dt);
  }

  // The parts of `integrate` for several pairs. The caller collects the few pairs whose force ends within the step.

  /// Motion of a pair over the first part of a step.
  struct PartialStep {
    Step step;   ///< motion up to the time `from`
    Real from;   ///< time since the start of the step
    Real age;    ///< time since the onset of the contact, at `from`
    Mask moves;  ///< false: the pair is separate throughout the step
  };
  /// Returns the motion up to the onset of the contact, or at the start of the step for pairs in contact. Pairs that do
  /// not touch in the step are moved to its end. Arguments as in integrate().
  LICHTENBERG_HOST_DEVICE PartialStep begin(const State& start, const Mask& touching, const Real& age,
                                            double dt) const {
    PartialStep begun{{start}, 0, age, touching};
    if (!any(!touching)) return begun;
    const Real t = onset_time(start, dt);
    const Mask meets = !touching && t <= dt;
    begun.moves = begun.moves || meets;
    begun.from = chosen<Real>(meets, t, 0);
    begun.age = chosen<Real>(meets, 0, age);
    begun.step.end = flown(start, 0, chosen<Real>(touching, 0, not_above<Real>(t, dt)));
    begun.step.onset = chosen<Real>(meets, t, -1);
    begun.step.impact_speed = chosen<Real>(meets, closing(begun.step.end), 0);
    return begun;
  }

  /// Advances the pairs in contact from the end of begin() to the end of the step. Returns true for pairs whose contact
  /// force ends within the step, and leaves them unchanged for release_within(). The formula for smooth forces does not
  /// resolve the kink of their force.
  Mask advance(PartialStep& begun, double dt) const {
    Mask rest = begun.moves;
    if (!any(rest)) return rest;
    const Load first = load(begun.step.end);
    const Mask is_attractive = rest && first.unclamped < 0;
    if (any(is_attractive)) rest = rest && !release_contact(begun.step, is_attractive, begun.from, dt);
    if (!any(rest)) return rest;
    Step whole = begun.step;
    integrate_contact(whole, first, begun.age, begun.from, dt);
    const Mask releases = rest && first.unclamped >= 0 && unclamped(whole.end) < 0;
    begun.step = chosen(rest && !releases, whole, begun.step);
    return releases;
  }

  /// Returns the motion from the end of begin() to the end of the step, for pairs whose contact force ends within it.
  Step release_within(const PartialStep& begun, double dt) const {
    return integrate_to_end(begun, load(begun.step.end), dt);
  }

  /// Returns the contact force on the second grain; zero without overlap, and where it would be attractive.
  LICHTENBERG_HOST_DEVICE V force(const State& s) const {
    const Contact contact = at(s);
    return chosen<Real>(contact.distance.value < reach_,
                        not_below<Real>(contact.unclamped, 0) * contact.distance.inverse, 0) *
           s.separation;
  }

 private:
  struct Load;

  /// Returns the state at the time `end` from the state s at the time `begin`, both since the start of the step,
  /// without contact force.
  LICHTENBERG_HOST_DEVICE State flown(const State& s, const Real& begin, const Real& end) const {
    const Real t = end - begin;
    const V then = external_.velocity(begin);
    return {s.separation + t * (s.velocity - then) + (external_.path(end) - external_.path(begin)),
            s.velocity + (external_.velocity(end) - then)};
  }

  /// Returns the time of contact onset since the start of the step, at which the distance falls to `reach_`. It is 0
  /// for a pair that overlaps, and infinite if no onset up to dt is found. Straight flight gives it in closed form.
  /// Newton's method then accounts for the acceleration.
  LICHTENBERG_HOST_DEVICE Real onset_time(const State& s, double dt) const {
    const Real b = dot(s.separation, s.velocity), c = norm2(s.separation) - reach_ * reach_, v2 = norm2(s.velocity);
    const auto excess2 = [&](const State& then) { return norm2(then.separation) - reach_ * reach_; };
    Real t = straight_onset(b, c, v2);
    const Mask late = t > dt;
    Mask none = late;
    if (any(late)) none = late && excess2(flown(s, 0, dt)) >= 0;
    t = not_above<Real>(t, dt);
    Mask iterating = !none;
    LICHTENBERG_UNROLL(1)
    for (int k = 0; k < 4; ++k) {
      if (!any(iterating)) break;
      const State then = flown(s, 0, t);
      const Real slope = 2 * dot(then.separation, then.velocity);
      iterating = iterating && slope < 0;  // a slope of 0: a grazing contact
      t = chosen<Real>(iterating, not_below<Real>(t - excess2(then) / slope, 0), t);
    }
    return chosen<Real>(c <= 0, 0, chosen<Real>(none, INFINITY, t));
  }

  /// Moves pairs whose contact force has ended at the time `begin` to the time `end` without contact force. `which`:
  /// mask of these pairs. A pair is not moved if the force would act again at `end`. Returns the mask of the moved
  /// pairs.
  LICHTENBERG_HOST_DEVICE Mask release_contact(Step& step, const Mask& which, const Real& begin,
                                               const Real& end) const {
    const State then = flown(step.end, begin, end);
    const Mask gone = which && !(unclamped(then) > 0);
    step.dissipated += chosen<Real>(gone, at(step.end).stored - at(then).stored, 0);
    step.end = chosen(gone, then, step.end);
    return gone;
  }

  /// Integrates pairs in contact to the end of the step, from the contact force and power `first` at the end of
  /// begin(). If the force ends within the step, regula falsi finds its end, and the pair continues without contact
  /// force. For several pairs at once, the caller passes only pairs whose force ends within the step.
  LICHTENBERG_HOST_DEVICE Step integrate_to_end(const PartialStep& begun, const Load& first, double dt) const {
    Step step;
    Real low = begun.from, high = dt, f_low = first.unclamped, f_high = 0, end = dt;
    constexpr int regula_falsi = 3;
    LICHTENBERG_UNROLL(1)
    for (int k = 0; k <= regula_falsi; ++k) {
      if (k > 0) {
        const Real part = f_low / (f_low - f_high);
        end = low + (high - low) * not_above<Real>(not_below<Real>(part, 0.01), 0.99);
      }
      step = begun.step;
      integrate_contact(step, first, begun.age, begun.from, end);
      const Real f = unclamped(step.end);
      if (k == 0 && !any(first.unclamped >= 0 && f < 0)) return step;
      const Mask is_repulsive = f > 0;
      low = chosen<Real>(is_repulsive, end, low);
      f_low = chosen<Real>(is_repulsive, f, f_low);
      high = chosen<Real>(is_repulsive, high, end);
      f_high = chosen<Real>(is_repulsive, f_high, f);
    }
    release_contact(step, begun.moves, end, dt);
    return step;
  }

  /// Distance, closing speed, elastic force, elastic energy and total force of the contact at one instant.
  struct Contact {
    WithInverse<Real> distance;
    Real closing, elastic, stored;
    /// Elastic plus damping force; below 0 where the damping would make it attractive, and the contact force is zero.
    Real unclamped;
  };
  LICHTENBERG_HOST_DEVICE Contact at(const State& s) const {
    const WithInverse<Real> distance = root_and_inverse(norm2(s.separation));
    const Real closing = -distance.inverse * dot(s.separation, s.velocity);
    // Rounding may put a pair whose surfaces just touch on either side of an overlap of 0.
    const ContactForceTerms<Real> terms = law_(not_below<Real>(reach_ - distance.value, 0));
    return {distance, closing, terms.elastic, terms.stored, terms.elastic + terms.damping * closing};
  }
  LICHTENBERG_HOST_DEVICE Real unclamped(const State& s) const { return at(s).unclamped; }

  /// Relative acceleration by the contact, the power that it dissipates, and its elastic plus damping force
  /// (`unclamped`, negative where the contact force is zero).
  struct Load {
    V acceleration;
    Real dissipation, unclamped;
  };
  LICHTENBERG_HOST_DEVICE Load load(const State& s) const {
    const Contact contact = at(s);
    const Real repulsion = not_below<Real>(contact.unclamped, 0);
    return {(repulsion * inverse_mass_ * contact.distance.inverse) * s.separation,
            (repulsion - contact.elastic) * contact.closing, contact.unclamped};
  }

  // Polynomials: coefficients by powers of s = sigma - sigma(begin).

  /// Returns the coefficients, by powers of s, of the line with the values at_0 at s = 0 and at_h at s = h.
  template <class Value>
  LICHTENBERG_HOST_DEVICE static std::array<Value, 2> line(const Value& at_0, const Value& at_h,
                                                           const Real& inverse_h) {
    return {at_0, inverse_h * (at_h - at_0)};
  }
  /// Returns the coefficients, by powers of s, of the parabola with the values at_0 at s = 0, `middle` at h / 2 and
  /// at_h at h.
  template <class Value>
  LICHTENBERG_HOST_DEVICE static std::array<Value, 3> parabola(const Value& at_0, const Value& middle,
                                                               const Value& at_h, const Real& inverse_h) {
    const Real four = 4, three = 3, two = 2;
    return {at_0, inverse_h * (four * middle - three * at_0 - at_h),
            (two * inverse_h * inverse_h) * (at_0 - two * middle + at_h)};
  }

  /// Returns the integral over time, from 0 to s, of the polynomial in s with the coefficients c. Here s is the
  /// increase of sigma = sqrt(time since the onset) from the value `from`, so dt = 2 (from + s) ds.
  template <class Value, std::size_t n>
  LICHTENBERG_HOST_DEVICE static Value integral(const std::array<Value, n>& c, const Real& from, const Real& s) {
    Value sum = (s * (2.0 * from + s)) * c[0];
    if constexpr (n > 1) sum += (s * s * (from + (2.0 / 3) * s)) * c[1];
    if constexpr (n > 2) sum += (s * s * s * ((2.0 / 3) * from + 0.5 * s)) * c[2];
    return sum;
  }
  /// Returns the integral over time, from 0 to s, of integral() with the same coefficients and `from`.
  template <class Value, std::size_t n>
  LICHTENBERG_HOST_DEVICE static Value double_integral(const std::array<Value, n>& c, const Real& from, const Real& s) {
    const Real s2 = s * s, f2 = from * from, fs = from * s;
    Value sum = (s2 * (2.0 * f2 + 2.0 * fs + 0.5 * s2)) * c[0];
    if constexpr (n > 1) sum += (s2 * s * ((2.0 / 3) * f2 + (5.0 / 6) * fs + (4.0 / 15) * s2)) * c[1];
    if constexpr (n > 2) sum += (s2 * s2 * ((1.0 / 3) * f2 + (7.0 / 15) * fs + (1.0 / 6) * s2)) * c[2];
    return sum;
  }

  /// Returns the state after an increase of sigma = sqrt(time since the contact onset) by s, from the state `start` at
  /// the time `begin`. `acceleration`: relative acceleration by the contact, as a polynomial in s; `from`: sigma at the
  /// start.
  template <std::size_t n>
  LICHTENBERG_HOST_DEVICE State after(const State& start, const Real& begin, const std::array<V, n>& acceleration,
                                      const Real& from, const Real& s) const {
    State then = flown(start, begin, begin + s * (2.0 * from + s));
    then.velocity += integral(acceleration, from, s);
    then.separation += double_integral(acceleration, from, s);
    return then;
  }

  /// Integrates the motion in contact by one step in sigma = sqrt(time since the onset). `begin`, `end`: times since
  /// the start of the step. `step`: state and dissipated energy, updated; `first`: contact force and power at `begin`;
  /// `age`: time since the onset at `begin`.
  ///
  /// Four evaluations are made as in the classical Runge-Kutta method, but positions follow from the accelerations by
  /// integrals of polynomials in sigma. Just after the onset, where the overlap is of second order in sigma, each stage
  /// then has a small relative error.
  LICHTENBERG_HOST_DEVICE void integrate_contact(Step& step, const Load& first, const Real& age, const Real& begin,
                                                 const Real& end) const {
    const Mask longer = end > begin;
    if (!any(longer)) return;
    const Real from = root_of(age), whole = root_of(age + (end - begin)) - from, half = 0.5 * whole;
    const Real inverse_whole = 1.0 / whole, inverse_half = 2.0 * inverse_whole;
    const State start = step.end;
    const V a = first.acceleration;
    const Load guess = load(after(start, begin, std::array<V, 1>{a}, from, half));
    const Load middle = load(after(start, begin, line(a, guess.acceleration, inverse_half), from, half));
    const Load last = load(after(start, begin, line(a, middle.acceleration, inverse_half), from, whole));
    const auto power = parabola(first.dissipation, middle.dissipation, last.dissipation, inverse_whole);
    const auto path = parabola(a, middle.acceleration, last.acceleration, inverse_whole);
    step.end = chosen(longer, after(start, begin, path, from, whole), start);
    step.dissipated += chosen<Real>(longer, integral(power, from, whole), 0);
  }

  Law law_;
  Real reach_, inverse_mass_;  ///< inverse_mass: 1 / reduced mass
  ExternalAcceleration<d, Real> external_;
};

}  // namespace lichtenberg::granular
