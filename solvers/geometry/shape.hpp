#pragma once

#include <algorithm>
#include <variant>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Circular conductor of the plane; centre and radius in m. A disk with its centre on a wall describes a half-disk,
/// because the domain ends at the wall.
struct Disk {
  Vec2 centre;
  double radius = 0;
};

/// Bar-shaped conductor of the plane: a rectangle whose axis extends from `from` to `to`, with flat ends. Lengths are
/// in m.
struct Bar {
  Vec2 from, to;
  double width = 0;
};

/// Conductor that fills the plane outside a circle, such as the rim of a round dish. Centre and radius (m) are those of
/// the circle.
struct Ring {
  Vec2 centre;
  double radius = 0;
};

class ClosedCurve;

/// Conductor of the plane whose surface is a closed curve, such as a polygon or an ellipse (closed_curve.hpp). The
/// curve must outlive the shape.
struct Freeform {
  const ClosedCurve* curve = nullptr;
};

/// Shape of a conductor of the plane.
using Shape = std::variant<Disk, Bar, Ring, Freeform>;

/// Returns the distance (m) from p to the edge of the disk, negative inside the disk.
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Disk& disk, Vec2 p) {
  return norm(p - disk.centre) - disk.radius;
}
/// Returns the distance (m) from p to the circle of the ring, negative outside the circle, where the conductor is.
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Ring& ring, Vec2 p) {
  return ring.radius - norm(p - ring.centre);
}
/// Returns the distance (m) from p to the edge of the bar, negative inside the bar.
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Bar& bar, Vec2 p) {
  const double length = norm(bar.to - bar.from);
  const Vec2 axis = (bar.to - bar.from) / length;
  const Vec2 r = p - 0.5 * (bar.from + bar.to);
  const double along = std::abs(dot(r, axis)) - 0.5 * length;
  const double across = std::abs(cross(axis, r)) - 0.5 * bar.width;
  const double outside = std::hypot(std::max(along, 0.0), std::max(across, 0.0));
  return outside + std::min(std::max(along, across), 0.0);
}

/// Returns the distance (m) from p to the curve, negative inside the conductor.
double signed_distance(const Freeform& shape, Vec2 p);

/// Returns the distance (m) from p to the surface of the shape, negative inside the conductor.
inline double signed_distance(const Shape& shape, Vec2 p) {
  return std::visit([p](const auto& s) { return signed_distance(s, p); }, shape);
}

/// Returns the surface-to-surface gap (m) between a disk and another conductor; negative if they overlap.
inline double gap(const Disk& disk, const Shape& shape) { return signed_distance(shape, disk.centre) - disk.radius; }

}  // namespace lichtenberg
