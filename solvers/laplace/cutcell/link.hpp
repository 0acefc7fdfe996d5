#pragma once

// Conductance of one link of the cut-cell scheme: the coupling of two neighbouring cells with a conductor's surface
// between them. Lengths are in cells. A conductance is flux / potential difference of a face, per depth and
// permittivity; in two dimensions it does not depend on the cell size. Every function also returns the derivative with
// respect to a displacement of the conductor, which determines the force (virtual work).

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Returns the larger of `value` and `least`. std::max takes references, and CUDA device code has no addresses of the
/// constants below.
LICHTENBERG_HOST_DEVICE constexpr double at_least(double value, double least) { return value < least ? least : value; }

/// A conductance and its derivative with respect to the position of the conductor at the link's end.
struct Conductance {
  double value = 0;
  /// Per cell.
  Vec2 gradient;
};

/// Lower bound of a cut, the distance from a cell centre to the surface (cells). The flux through a short link is a
/// small potential difference times a large conductance, and its relative error is rounding / cut: 1e-12 at this bound.
/// The preconditioner's single precision requires the bound: with cuts of 1e-10, potentials are wrong in the third
/// digit if many cell centres lie on surfaces (conductors on a lattice). Rounding may also place a cell centre on the
/// wrong side of a surface.
inline constexpr double smallest_cut = 1e-4;

/// Log-fitted link from the fluid cell centre p to a circle. The potential near a round conductor varies as ln r: the
/// potential difference is q ln(r/R) / 2 pi, and the flux through the face is q dtheta / 2 pi. Here dtheta is the angle
/// that the face from `corner_a` to `corner_b` subtends at the circle's centre. The link is exact for an isolated
/// circle and tends to 1 / (cut length) as R -> infinity. `inside`: the fluid is within the circle, as for a ring.
LICHTENBERG_HOST_DEVICE inline Conductance log_fitted_link(Vec2 p, Vec2 corner_a, Vec2 corner_b, Vec2 centre,
                                                           double radius, bool inside = false) {
  Vec2 a = corner_a - centre, b = corner_b - centre;
  const Vec2 r = p - centre;
  // The centre of a disk smaller than its cell may lie on the face, where the angle jumps from pi to -pi. At an end of
  // the face the angle is undefined. The centre is then displaced slightly into the disk's cell behind the face, and an
  // end at the centre is left out of the derivative.
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
  // log1p has full precision for cell centres close to the surface.
  const double distance = norm(r);
  const double outside_log = std::log1p((norm2(r) - radius * radius) / ((distance + radius) * radius));
  const double sign = inside ? -1.0 : 1.0;
  const double log_ratio = std::max(sign * outside_log, smallest_cut / distance);
  const Vec2 log_gradient = (-sign / norm2(r)) * r;
  const double c = theta / log_ratio;
  return {c, (theta_gradient - c * log_gradient) / log_ratio};
}

/// Link from a fluid cell centre to a flat surface: 1 / cut. `cut`: distance along the link, in direction e; n: outward
/// normal of the conductor, n.e < 0.
LICHTENBERG_HOST_DEVICE inline Conductance plain_link(double cut, Vec2 e, Vec2 n) {
  return {1.0 / cut, (-1.0 / (cut * cut * dot(n, e))) * n};
}

/// A conductor's surface as a circle. The radius is negative if the conductor lies outside the circle (a dish's rim).
struct SurfaceCircle {
  Vec2 centre;
  double radius;
};

/// Point where a line from a point inside a conductor leaves the conductor.
struct Exit {
  /// Distance from the point to the surface.
  double length = 0;
  /// d2 length / d offset^2
  double curvature = 0;
  /// d length / d centre
  Vec2 gradient;
};

/// Exit of the line from p in direction e, shifted sideways by offset * perpendicular(e).
LICHTENBERG_HOST_DEVICE inline Exit circle_exit(Vec2 p, Vec2 e, const SurfaceCircle& surface, double offset = 0) {
  const double radius = surface.radius;
  const Vec2 w = p - surface.centre;
  const double across = cross(e, w) + offset, size = std::abs(radius), sign = radius < 0 ? -1.0 : 1.0;
  // A line past the circle gets the exit of a line that barely meets it.
  const double root = std::sqrt(std::max(size * size - across * across, 1e-6 * size * size));
  const Vec2 normal = (root * e + sign * across * perpendicular(e)) / size;
  return {-dot(w, e) + sign * root, -sign * size * size / (root * root * root), normal * (size / root)};
}

/// Returns true if the shifted line meets the circle.
LICHTENBERG_HOST_DEVICE inline bool meets(Vec2 p, Vec2 e, const SurfaceCircle& surface, double offset) {
  return std::abs(cross(e, p - surface.centre) + offset) < std::abs(surface.radius);
}

/// Lower bound of a gap between conductors (cells), less than an atom for cells of 0.1 mm. Conductors of different
/// potential that touch thus have a large, finite conductance.
inline constexpr double smallest_gap = 1e-6;

/// A conductance between two conductors and its derivatives with respect to their positions.
struct PairConductance {
  double value = 0;
  Vec2 gradient_a, gradient_b;
};

/// Conductance of the gap between two circles across a face of unit width: the integral of ds / gap(s) over the offset
/// s in [-1/2, 1/2] from the link. The link runs from p (inside a) over `length` in direction e to a point inside b.
/// One radius may be negative. The result is 1 / gap for a wide gap. A narrow gap is a parabola, and the substitution
/// s = s0 + w tan u makes the integrand nearly constant, so that eight Gauss points suffice for any gap.
LICHTENBERG_HOST_DEVICE inline PairConductance gap_conductance(Vec2 p, Vec2 e, double length,
                                                               const SurfaceCircle& circle_a,
                                                               const SurfaceCircle& circle_b) {
  constexpr double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const Vec2 q = p + length * e;
  const double radius_a = circle_a.radius, radius_b = circle_b.radius;
  // s0: the offset of the narrowest part, where both circles have the same slope. The line at offset s is at a distance
  // of s + cross(e, p - centre) from a centre. A gap far below a cell is a sharp peak of the integrand, so that s0 must
  // be exact.
  const double off_a = cross(e, p - circle_a.centre), off_b = cross(e, q - circle_b.centre);
  const double s0 = -(off_a * radius_b + off_b * radius_a) / (radius_a + radius_b);
  // perpendicular(-e) = -perpendicular(e): an offset s is -s for b.
  const Exit a = circle_exit(p, e, circle_a, s0);
  const Exit b = circle_exit(q, -e, circle_b, -s0);
  const double least = at_least(length - a.length - b.length, smallest_gap);
  const double w = std::sqrt(2.0 * least / (-a.curvature - b.curvature));
  const double from = std::atan((-0.5 - s0) / w), to = std::atan((0.5 - s0) / w);
  PairConductance result;
  for (int k = 0; k < 8; ++k) {
    const double u = 0.5 * (from + to) + (k < 4 ? 0.5 : -0.5) * (to - from) * node[k % 4];
    const double s = s0 + w * std::tan(u);
    const double ds = 0.5 * (to - from) * weight[k % 4] * w / (std::cos(u) * std::cos(u));
    if (!meets(p, e, circle_a, s) || !meets(q, -e, circle_b, -s)) {
      result.value += ds / length;  // open fluid
      continue;
    }
    const Exit at_a = circle_exit(p, e, circle_a, s);
    const Exit at_b = circle_exit(q, -e, circle_b, -s);
    const double g = at_least(length - at_a.length - at_b.length, smallest_gap);
    result.value += ds / g;
    result.gradient_a += (ds / (g * g)) * at_a.gradient;
    result.gradient_b += (ds / (g * g)) * at_b.gradient;
  }
  return result;
}

/// Conductance of two circles in the open plane, for circles in one cell: 2 pi / arccosh u with
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
