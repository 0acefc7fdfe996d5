#pragma once

#include <variant>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/geometry/shape.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A fixed sphere in three dimensions (m). In a box with periodic sides, distances are to its nearest image.
struct Ball {
  Vec3 centre;
  double radius = 0;
  Box<3> box;
};

/// A side of the domain as a flat wall: a point on it (m), and its unit normal, which points into the fluid.
struct FlatWall {
  Vec3 point, normal;
};

/// Surface of a fixed body: an electrode or a side of the domain. Plane shapes ignore z.
using Surface = std::variant<Disk, Bar, Ring, Freeform, Ball, FlatWall>;

/// Converts a plane shape to a surface.
Surface surface_of(const Shape& shape);
/// Returns the surface of an electrode: a sphere in a three-dimensional domain, otherwise its plane shape.
Surface surface_of(const Electrode& electrode, const Domain& domain);
/// Returns the sides of a domain as flat walls, in the order of side_names (left, right, bottom, top, front, back). A
/// plane domain has the first four.
std::vector<Surface> sides_of(const Domain& domain);

/// Local geometry of a surface near a point: distance, normal and curvature.
struct View {
  double distance = 0;   ///< distance of the point from the surface (m), negative inside the body
  Vec3 normal;           ///< gradient of the distance: unit vector away from the body
  double turning = 0;    ///< rotation of the normal per sideways displacement of the point (1/m)
  double curvature = 0;  ///< curvature of the surface (1/m): positive for convex bodies, negative inside a ring
};

/// Returns the distance (m), normal and curvature of a surface near `point` (m). A bar's corner counts as flat
/// (curvature 0), because its sharpness is not physical for a contact.
View view(const Surface& surface, Vec3 point);

}  // namespace lichtenberg::effects
