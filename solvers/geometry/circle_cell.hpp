#pragma once

// Intersection of a circle with a rectangular cell: exact lengths of the cut edges and of the arc.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "solvers/geometry/shape.hpp"

namespace lichtenberg {

/// Returns the length (m) of the part of the line segment from a to b that lies inside the disk.
inline double length_inside(const Disk& disk, Vec2 a, Vec2 b) {
  const double length = norm(b - a);
  const Vec2 e = (b - a) / length;
  const double middle = dot(disk.centre - a, e), across = cross(e, disk.centre - a);
  const double half2 = disk.radius * disk.radius - across * across;
  if (half2 <= 0) return 0;
  const double half = std::sqrt(half2);
  return std::max(0.0, std::min(middle + half, length) - std::max(middle - half, 0.0));
}

/// Length and integrated normal of the arcs of a circle within a rectangle.
struct Arc {
  double length = 0;  ///< Total length (m)
  Vec2 normal;        ///< Integral of the circle's outward unit normal along the arcs (m)
};

/// Computes total length (m) and integrated outward normal (m) of the arcs of the disk's edge that lie inside a
/// rectangle. The corners of the rectangle are in m. Both results are 0 if no part of the edge is inside.
inline Arc arc_inside(const Disk& disk, Vec2 lower_left, Vec2 upper_right) {
  constexpr double pi = std::numbers::pi;
  const double r = disk.radius;
  std::array<double, 10> cut;  // Angles at which the circle meets the lines of the edges, and -pi and pi
  cut.fill(pi);
  cut[0] = -pi;
  int cuts = 1;
  for (const Vec2 corner : {lower_left, upper_right}) {
    const Vec2 from_centre = (corner - disk.centre) / r;
    if (std::abs(from_centre.x) < 1) {
      const double angle = std::acos(from_centre.x);
      cut[cuts++] = angle;
      cut[cuts++] = -angle;
    }
    if (std::abs(from_centre.y) < 1) {
      const double angle = std::asin(from_centre.y);
      cut[cuts++] = angle;
      cut[cuts++] = angle > 0 ? pi - angle : -pi - angle;
    }
  }
  std::sort(cut.begin(), cut.end());
  Arc arc;
  for (std::size_t k = 0; k + 1 < cut.size(); ++k) {
    const double from = cut[k], to = cut[k + 1], middle = 0.5 * (from + to);
    const Vec2 p = disk.centre + r * Vec2{std::cos(middle), std::sin(middle)};
    if (p.x <= lower_left.x || p.x >= upper_right.x || p.y <= lower_left.y || p.y >= upper_right.y) continue;
    arc.length += r * (to - from);
    arc.normal += r * Vec2{std::sin(to) - std::sin(from), std::cos(from) - std::cos(to)};
  }
  return arc;
}

}  // namespace lichtenberg
