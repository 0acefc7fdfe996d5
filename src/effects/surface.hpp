#pragma once

#include <variant>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/geometry/shape.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A sphere in space, represented by its nearest image in a box with periodic sides.
struct Ball {
  Vec3 centre;
  double radius = 0;
  Box<3> box;
};

/// A side of the domain as a wall; `normal` points into the fluid.
struct FlatWall {
  Vec3 point, normal;
};

/// Surface of a fixed body. Disk, bar and ring are two-dimensional and ignore z.
using Surface = std::variant<Disk, Bar, Ring, Ball, FlatWall>;

Surface surface_of(const Shape& shape);
/// Returns the surface of an electrode in that domain.
Surface surface_of(const Electrode& electrode, const Domain& domain);
/// Returns the sides in the order of side_names; a plane domain has four.
std::vector<Surface> sides_of(const Domain& domain);

/// Geometry of a surface near a point.
struct View {
  double distance = 0;   ///< m, from the point to the surface, negative inside the body
  Vec3 normal;           ///< gradient of the distance: unit vector from the surface to the point
  double turning = 0;    ///< 1/m: moving the point sideways by s rotates the normal by this value times s
  double curvature = 0;  ///< 1/m, of the surface: positive for convex bodies, negative inside a ring
};

/// Returns the geometry seen from `point`. A bar's corner counts as flat (curvature 0), because its sharpness is not
/// physical for a contact.
View view(const Surface& surface, Vec3 point);

}  // namespace lichtenberg::effects
