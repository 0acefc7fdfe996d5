#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg::effects {

/// Form w(q) of the soft repulsion of packings. q is the distance over the sum of the radii, 0 < q <= 1.
enum class RepulsionForm {
  logarithmic,  ///< (q - 1) ln q (smish.dev)
  harmonic,     ///< (1 - q)^2 / 2 (O'Hern 2003)
  hertzian      ///< (1 - q)^(5/2) / (5/2) (O'Hern 2003)
};

/// Value and first two derivatives of the soft repulsion potential w(q) = (q - 1) ln q for 0 < q <= 1. q is the
/// distance over the sum of the radii. At q = 1, where contact ends, w and w' are 0, and w'' jumps from 2 to 0. For q
/// -> 0, w diverges like -ln q.
struct ContactLaw {
  double energy = 0, slope = 0, curvature = 0;
};

/// Smallest q for which `logarithm_near_one` has full accuracy; the largest q is 1.
constexpr double near_one = 0.8;

/// Returns the logarithm ln q = 2 artanh(s) for s = (q - 1) / (q + 1) by a power series (Abramowitz & Stegun 4.1.27).
/// For |s| <= 1/9 the first omitted term, 2 s^17 / 17, is below the rounding of s. The function has no branches, so
/// that loops vectorize.
LICHTENBERG_HOST_DEVICE inline double logarithm_of_ratio(double s) {
  const double t = s * s;
  double sum = 1.0 / 15;
  for (int n = 13; n > 0; n -= 2) sum = sum * t + 1.0 / n;
  return 2 * s * sum;
}
/// Returns ln q for near_one <= q <= 1. The difference q - 1 is exact, which keeps the relative accuracy of w near q =
/// 1.
LICHTENBERG_HOST_DEVICE inline double logarithm_near_one(double q) { return logarithm_of_ratio((q - 1) / (q + 1)); }

/// Returns w(q) = (q - 1) ln q and its first two derivatives; `logarithm` is ln q.
LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q, double logarithm) {
  const double excess = q - 1;
  return {excess * logarithm, logarithm + excess / q, (q + 1) / (q * q)};
}

/// Returns w(q) = (q - 1) ln q and its first two derivatives for 0 < q <= 1.
LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q) {
  return contact_law(q, q >= near_one ? logarithm_near_one(q) : std::log(q));
}

/// Returns w(q) of a form and its first two derivatives for 0 < q <= 1. All vanish at q = 1, except w'' of the
/// logarithmic (2) and the harmonic form (1).
LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(RepulsionForm form, double q) {
  const double overlap = 1 - q;
  if (form == RepulsionForm::harmonic) return {0.5 * overlap * overlap, -overlap, 1};
  if (form == RepulsionForm::logarithmic) return contact_law(q);
  const double root = std::sqrt(overlap);
  return {0.4 * overlap * overlap * root, -overlap * root, 1.5 * root};
}

/// Returns the power of the overlap to which the force of a form is proportional near q = 1.
inline double force_exponent(RepulsionForm form) { return form == RepulsionForm::hertzian ? 1.5 : 1; }

/// Pair force law of soft repulsion: energy U = stiffness * w(q) for q < 1. q is the distance of the centres over the
/// sum of the radii. The functions are those that pair_law.hpp requires.
struct ContactPotentialLaw {
  static constexpr bool over_distance = true, charged = false;
  double stiffness = 1;  ///< J
  RepulsionForm form = RepulsionForm::logarithmic;

  LICHTENBERG_HOST_DEVICE double reach(double radius_i, double radius_j) const { return radius_i + radius_j; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return stiffness; }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairGeometry& pair) const {
    return force(pair, contact_law(form, pair.distance / pair.reach));
  }
  LICHTENBERG_HOST_DEVICE PairForce quick(const PairGeometry& pair) const {
    const double q = pair.distance / pair.reach;
    if (form != RepulsionForm::logarithmic) return force(pair, contact_law(form, q));
    return force(pair, contact_law(q, logarithm_near_one(q)));
  }
  LICHTENBERG_HOST_DEVICE bool quick_holds(const PairGeometry& pair) const {
    return pair.distance / pair.reach >= near_one;
  }

 private:
  LICHTENBERG_HOST_DEVICE PairForce force(const PairGeometry& pair, const ContactLaw& w) const {
    return {w.energy, -stiffness * w.slope / (pair.reach * pair.distance),
            stiffness * w.curvature / (pair.reach * pair.reach)};
  }
};

}  // namespace lichtenberg::effects
