#pragma once

// The arithmetic of one link of the cut-cell scheme: how strongly two neighbouring cells are coupled when a conductor's
// surface runs between them. Lengths in cells; a conductance is flux / potential difference of a face, per depth and
// permittivity, and is independent of the cell size in two dimensions. Every function also gives the derivative with
// respect to a displacement of the conductor, from which the forces follow (virtual work).

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// The value, or `least` if it is below. std::max takes references, which a CUDA device has none of to the constants
/// below.
LICHTENBERG_HOST_DEVICE constexpr double at_least(double value, double least) { return value < least ? least : value; }

/// A conductance and its derivative with respect to the position of the conductor at its end.
struct Conductance {
  double value = 0;
  Vec2 gradient;  ///< per cell
};

/// Cuts below this many cells are taken as this: the surface is where it is to that fraction of a cell. A flux through
/// a short link is a small difference of potentials times a large conductance and has their rounding over the cut,
/// 1e-12 here. Single precision, the preconditioner's, is lost sooner: with cuts of 1e-10 potentials are wrong in the
/// third digit if many cell centres lie on surfaces (conductors on a lattice). And rounding can put a centre on the
/// other side of the surface that it lies on.
inline constexpr double smallest_cut = 1e-4;

/// Fluid cell centre p to a circle, log-fitted: the field near a round conductor goes like ln r, so the potential
/// difference is q ln(r/R) / 2 pi and the flux through the face q dtheta / 2 pi, with dtheta the angle under which the
/// centre sees the face from `corner_a` to `corner_b`. Exact for the isolated circle; tends to 1 / (cut length) as
/// R -> infinity. `inside` is for a ring, whose fluid lies within the circle.
LICHTENBERG_HOST_DEVICE inline Conductance log_fitted_link(Vec2 p, Vec2 corner_a, Vec2 corner_b, Vec2 centre,
                                                           double radius, bool inside = false) {
  Vec2 a = corner_a - centre, b = corner_b - centre;
  const Vec2 r = p - centre;
  // The centre of a disk smaller than its cell can lie on the face, where the angle jumps from pi to -pi, or be its
  // end, from which no angle is seen: it is taken a little into the cell behind the face, which the disk has. An end
  // that near has no say in the derivative.
  constexpr double little = 1e-9;
  const bool at_a = norm2(a) < little * little, at_b = norm2(b) < little * little;
  if (dot(a, b) <= 0 && std::abs(cross(a, b)) < little) {
    const Vec2 inward = little * (corner_a + corner_b - 2.0 * p + a + b);
    a -= inward;
    b -= inward;
  }
  const double turn = cross(a, b) < 0 ? -1.0 : 1.0;
  const double theta = std::atan2(turn * cross(a, b), dot(a, b));
  const Vec2 a_gradient = at_a ? Vec2{} : perpendicular(a) / norm2(a),
             b_gradient = at_b ? Vec2{} : perpendicular(b) / norm2(b);
  const Vec2 theta_gradient = turn * (a_gradient - b_gradient);
  // log1p keeps all digits when the cell centre all but touches the surface.
  const double distance = norm(r);
  const double outside_log = std::log1p((norm2(r) - radius * radius) / ((distance + radius) * radius));
  const double sign = inside ? -1.0 : 1.0;
  const double log_ratio = std::max(sign * outside_log, smallest_cut / distance);
  const Vec2 log_gradient = (-sign / norm2(r)) * r;
  const double c = theta / log_ratio;
  return {c, (theta_gradient - c * log_gradient) / log_ratio};
}

/// Fluid cell centre to a flat surface at distance `cut` along the link (direction e, outward normal n of the
/// conductor, n.e < 0): 1 / cut.
LICHTENBERG_HOST_DEVICE inline Conductance plain_link(double cut, Vec2 e, Vec2 n) {
  return {1.0 / cut, (-1.0 / (cut * cut * dot(n, e))) * n};
}

/// Where a line in direction e from a point inside a conductor leaves it.
struct Exit {
  double length = 0;     ///< from the point to the surface
  double curvature = 0;  ///< d2 length / d offset^2
  Vec2 gradient;         ///< d length / d centre
};

/// Out of a circle, or, with a negative radius, out of what lies round a circle (a dish's rim) and into it. `offset`
/// shifts the line sideways by offset * perpendicular(e).
LICHTENBERG_HOST_DEVICE inline Exit circle_exit(Vec2 p, Vec2 e, Vec2 centre, double radius, double offset = 0) {
  const Vec2 w = p - centre;
  const double across = cross(e, w) + offset, size = std::abs(radius), sign = radius < 0 ? -1.0 : 1.0;
  // A line that misses the circle by the half width of a face grazes it: keep the root off zero.
  const double root = std::sqrt(std::max(size * size - across * across, 1e-6 * size * size));
  const Vec2 normal = (root * e + sign * across * perpendicular(e)) / size;
  return {-dot(w, e) + sign * root, -sign * size * size / (root * root * root), normal * (size / root)};
}

/// Whether the line shifted sideways by `offset` meets the circle at all.
LICHTENBERG_HOST_DEVICE inline bool circle_met(Vec2 p, Vec2 e, Vec2 centre, double radius, double offset) {
  return std::abs(cross(e, p - centre) + offset) < std::abs(radius);
}

/// Gaps below this many cells are taken as this (a cell being some 0.1 mm, it is less than an atom): conductors of
/// different potential that touch are left with a large, finite conductance.
inline constexpr double smallest_gap = 1e-6;

/// A conductance between two conductors and its derivative with respect to the position of either.
struct PairConductance {
  double value = 0;
  Vec2 gradient_a, gradient_b;
};

/// The channel between two circles across a face of unit width: integral of ds / gap(s) over the offset s in
/// [-1/2, 1/2] from the link's line, which runs from p (inside a) a distance `length` in direction e to q (inside b).
/// One radius may be negative, for a rim round the other circle.
/// For a wide gap it is 1 / gap. The substitution s = s0 + w tan u makes the integrand all but constant for a narrow
/// channel, whose gap is a parabola, so that eight Gauss points do for any gap.
LICHTENBERG_HOST_DEVICE inline PairConductance channel(Vec2 p, Vec2 e, double length, Vec2 centre_a, double radius_a,
                                                       Vec2 centre_b, double radius_b) {
  constexpr double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const Vec2 q = p + length * e;
  // The narrowest place, where the slopes of both surfaces agree: at offset s the line is s + cross(e, p - centre) off
  // a centre, and the two circles' angles there are equal. A gap far below a cell is a sharp peak: it must be met
  // exactly.
  const double off_a = cross(e, p - centre_a), off_b = cross(e, q - centre_b);
  const double s0 = -(off_a * radius_b + off_b * radius_a) / (radius_a + radius_b);
  // perpendicular(-e) = -perpendicular(e): an offset s of the line is -s as seen from b.
  const Exit a = circle_exit(p, e, centre_a, radius_a, s0);
  const Exit b = circle_exit(q, -e, centre_b, radius_b, -s0);
  const double least = at_least(length - a.length - b.length, smallest_gap);
  const double w = std::sqrt(2.0 * least / (-a.curvature - b.curvature));
  const double from = std::atan((-0.5 - s0) / w), to = std::atan((0.5 - s0) / w);
  PairConductance result;
  for (int k = 0; k < 8; ++k) {
    const double u = 0.5 * (from + to) + (k < 4 ? 0.5 : -0.5) * (to - from) * node[k % 4];
    const double s = s0 + w * std::tan(u);
    const double ds = 0.5 * (to - from) * weight[k % 4] * w / (std::cos(u) * std::cos(u));
    if (!circle_met(p, e, centre_a, radius_a, s) || !circle_met(q, -e, centre_b, radius_b, -s)) {
      result.value += ds / length;  // beside the channel: open fluid
      continue;
    }
    const Exit at_a = circle_exit(p, e, centre_a, radius_a, s);
    const Exit at_b = circle_exit(q, -e, centre_b, radius_b, -s);
    const double g = at_least(length - at_a.length - at_b.length, smallest_gap);
    result.value += ds / g;
    result.gradient_a += (ds / (g * g)) * at_a.gradient;
    result.gradient_b += (ds / (g * g)) * at_b.gradient;
  }
  return result;
}

/// Two circles too small for the grid to tell apart: their conductance in the open plane, 2 pi / arccosh u with
/// u = (d^2 - r_a^2 - r_b^2) / (2 r_a r_b) (D 6.37 for unequal radii).
LICHTENBERG_HOST_DEVICE inline PairConductance circle_pair(Vec2 centre_a, double radius_a, Vec2 centre_b,
                                                           double radius_b) {
  const Vec2 d = centre_a - centre_b;
  const double touching = 1 + smallest_gap * (radius_a + radius_b) / (radius_a * radius_b);
  const double u =
      std::max((norm2(d) - radius_a * radius_a - radius_b * radius_b) / (2 * radius_a * radius_b), touching);
  const double c = 2 * std::numbers::pi / std::acosh(u);
  const Vec2 gradient = (-c * c / (2 * std::numbers::pi * std::sqrt(u * u - 1) * radius_a * radius_b)) * d;
  return {c, gradient, -gradient};
}

}  // namespace lichtenberg::laplace
