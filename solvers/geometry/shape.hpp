#pragma once

#include <algorithm>
#include <variant>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Circular conductor. A half-disk on a wall is a disk with its centre on the wall: the domain cuts it.
struct Disk {
  Vec2 centre;
  double radius = 0;
};

/// Straight bar with flat ends: the rectangle of `width` with its axis from `from` to `to`.
struct Bar {
  Vec2 from, to;
  double width = 0;
};

/// Exterior of a circle: a dish whose rim is the conductor.
struct Ring {
  Vec2 centre;
  double radius = 0;
};

using Shape = std::variant<Disk, Bar, Ring>;

LICHTENBERG_HOST_DEVICE inline double signed_distance(const Disk& disk, Vec2 p) {
  return norm(p - disk.centre) - disk.radius;
}
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Ring& ring, Vec2 p) {
  return ring.radius - norm(p - ring.centre);
}
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Bar& bar, Vec2 p) {
  const double length = norm(bar.to - bar.from);
  const Vec2 axis = (bar.to - bar.from) / length;
  const Vec2 r = p - 0.5 * (bar.from + bar.to);
  const double along = std::abs(dot(r, axis)) - 0.5 * length;
  const double across = std::abs(cross(axis, r)) - 0.5 * bar.width;
  const double outside = std::hypot(std::max(along, 0.0), std::max(across, 0.0));
  return outside + std::min(std::max(along, across), 0.0);
}

/// Returns the distance (m) from p to the surface of the shape, negative inside the conductor.
inline double signed_distance(const Shape& shape, Vec2 p) {
  return std::visit([p](const auto& s) { return signed_distance(s, p); }, shape);
}

/// Returns the surface-to-surface gap (m) between a disk and a shape; negative if they overlap.
inline double gap(const Disk& disk, const Shape& shape) { return signed_distance(shape, disk.centre) - disk.radius; }

}  // namespace lichtenberg
