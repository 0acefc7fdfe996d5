#pragma once

#include <variant>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/geometry/shape.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A sphere in space. Through periodic sides of the box its nearest image is seen.
struct Ball {
  Vec3 centre;
  double radius = 0;
  Box<3> box;
};

/// A side of the domain as a wall: the fluid is where `normal` points.
struct FlatWall {
  Vec3 point, normal;
};

/// The surface of a fixed body. Disk, bar and ring are those of the plane, which know no z.
using Surface = std::variant<Disk, Bar, Ring, Ball, FlatWall>;

Surface surface_of(const Shape& shape);
/// Of an electrode in that domain.
Surface surface_of(const Electrode& electrode, const Domain& domain);
/// As in side_names; a plane domain has four.
std::vector<Surface> sides_of(const Domain& domain);

/// What a surface looks like from a point.
struct View {
  double distance = 0;   ///< m, from the point to the surface, negative inside the body
  Vec3 normal;           ///< gradient of the distance: unit vector from the surface to the point
  double turning = 0;    ///< 1/m: moving the point sideways by s turns the normal by turning * s
  double curvature = 0;  ///< 1/m, of the surface: positive where the body bulges, negative inside a ring
};

/// A bar's corner is taken as flat (curvature 0): its sharpness is no physics of a contact.
View view(const Surface& surface, Vec3 point);

}  // namespace lichtenberg::effects
