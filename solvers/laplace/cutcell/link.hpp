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

/// Returns the larger of `value` and `least`. CUDA device code cannot use std::max with constants such as smallest_cut:
/// std::max takes references, and the constants have no addresses there.
LICHTENBERG_HOST_DEVICE constexpr double at_least(double value, double least) { return value < least ? least : value; }

/// Conductance of a link (flux / potential difference, per depth and permittivity) and its derivative. The derivative
/// is with respect to the position of the conductor at the link's end.
struct Conductance {
  double value = 0;
  /// Derivative with respect to the conductor's position (per cell width).
  Vec2 gradient;
};

/// Lower bound of the cut length, the distance from a fluid cell centre to a conductor's surface (cells). The flux
/// through a short link is a small potential difference times a large conductance. Its relative error is the rounding
/// error divided by the cut length: 1e-12 at this bound. The preconditioner's single precision requires the bound. With
/// cuts of 1e-10, potentials are wrong in the third digit if many cell centres lie on surfaces (conductors on a
/// lattice). Rounding may also place a cell centre on the wrong side of a surface.
inline constexpr double smallest_cut = 1e-4;

/// Computes the conductance of the link from a fluid cell centre p to a circular conductor, for a logarithmic profile
/// of the potential. The cell's face towards the conductor runs from `corner_a` to `corner_b`; all lengths are in
/// cells. The result is dtheta / ln(r/R): dtheta is the angle that the face subtends at the circle's centre, r the
/// distance of p from the centre, and R the radius. The logarithm has a lower bound (smallest_cut).
/// The reason is that the potential near a round conductor of charge q varies as q ln(r/R) / 2 pi. The flux through the
/// face is q dtheta / 2 pi. The link is exact for an isolated circle and tends to 1 / (cut length) as R -> infinity.
/// `inside`: the fluid is within the circle, as in a ring; the logarithm is then ln(R/r). The returned derivative is
/// with respect to the circle's position.
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

/// Computes the conductance 1 / cut of the link from a fluid cell centre to a flat surface. `cut`: distance to the
/// surface along the link (cells). e: unit vector of the link's direction; n: outward normal of the conductor, n.e < 0.
/// The returned derivative is with respect to the surface's position.
LICHTENBERG_HOST_DEVICE inline Conductance plain_link(double cut, Vec2 e, Vec2 n) {
  return {1.0 / cut, (-1.0 / (cut * cut * dot(n, e))) * n};
}

/// Circle that represents a conductor's surface (lengths in cells). The radius is negative if the conductor lies
/// outside the circle (a ring around the fluid).
struct SurfaceCircle {
  Vec2 centre;
  double radius;
};

/// Point where a line from a point inside a conductor leaves the conductor (lengths in cells).
struct Exit {
  /// Distance from the start point to the surface along the line.
  double length = 0;
  /// Second derivative of `length` with respect to a sideways offset of the line.
  double curvature = 0;
  /// Derivative of `length` with respect to the position of the conductor's centre.
  Vec2 gradient;
};

/// Computes where a line leaves a circular conductor. The line starts at p inside the conductor, runs in direction e (a
/// unit vector) and is shifted sideways by offset * perpendicular(e). A line that misses the circle gets the exit of a
/// line that barely meets it.
LICHTENBERG_HOST_DEVICE inline Exit circle_exit(Vec2 p, Vec2 e, const SurfaceCircle& surface, double offset = 0) {
  const double radius = surface.radius;
  const Vec2 w = p - surface.centre;
  const double across = cross(e, w) + offset, size = std::abs(radius), sign = radius < 0 ? -1.0 : 1.0;
  // A line past the circle gets the exit of a line that barely meets it.
  const double root = std::sqrt(std::max(size * size - across * across, 1e-6 * size * size));
  const Vec2 normal = (root * e + sign * across * perpendicular(e)) / size;
  return {-dot(w, e) + sign * root, -sign * size * size / (root * root * root), normal * (size / root)};
}

/// Returns true if the line through p in direction e, shifted sideways by offset * perpendicular(e), meets the circle.
LICHTENBERG_HOST_DEVICE inline bool meets(Vec2 p, Vec2 e, const SurfaceCircle& surface, double offset) {
  return std::abs(cross(e, p - surface.centre) + offset) < std::abs(surface.radius);
}

/// Lower bound of a gap between conductors (cells), smaller than an atom for cells of 0.1 mm. With it, touching
/// conductors of different potential have a large but finite conductance.
inline constexpr double smallest_gap = 1e-6;

/// Conductance between two conductors a and b (per depth and permittivity), and its derivatives with respect to their
/// positions (per cell width).
struct PairConductance {
  double value = 0;
  Vec2 gradient_a, gradient_b;
};

/// Computes the conductance of the gap between two circular conductors across a face of unit width. It is the integral
/// of ds / gap(s) over the sideways offset s in [-1/2, 1/2], where a gap is at least `smallest_gap`. The link starts at
/// p inside conductor a and ends inside conductor b, at distance `length` in direction e (a unit vector). Lengths are
/// in cells. One radius may be negative (SurfaceCircle). The returned derivatives are with respect to both positions.
/// The result is 1 / gap for a wide gap. A narrow gap is approximately a parabola with its minimum at s0. The
/// substitution s = s0 + w tan u makes the integrand nearly constant, so that eight Gauss points suffice also for a
/// narrow gap.
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

/// Computes the conductance between two circles in the open plane, for two disks in one cell (Stephenson 2018, D 6.37).
/// It is 2 pi / arccosh u with u = (d^2 - r_a^2 - r_b^2) / (2 r_a r_b); d is the distance of the centres. At contact, u
/// corresponds to a gap of about `smallest_gap`. Lengths are in cells. The derivatives are with respect to the centres.
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
