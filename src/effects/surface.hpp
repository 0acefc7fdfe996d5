#pragma once

#include <array>
#include <variant>

#include "solvers/geometry/shape.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A side of the domain as a wall: the fluid is where `normal` points.
struct HalfPlane {
  Vec2 point, normal;
};

/// The surface of a fixed body.
using Surface = std::variant<Disk, Bar, Ring, HalfPlane>;

Surface surface_of(const Shape& shape);
/// Left, right, bottom, top.
std::array<Surface, 4> sides_of(const Domain& domain);

/// What a surface looks like from a point.
struct View {
  double distance = 0;   ///< m, from the point to the surface, negative inside the body
  Vec2 normal;           ///< gradient of the distance: unit vector from the surface to the point
  double turning = 0;    ///< 1/m: moving the point sideways by s turns the normal by turning * s
  double curvature = 0;  ///< 1/m, of the surface: positive where the body bulges, negative inside a ring
};

/// A bar's corner is taken as flat (curvature 0): its sharpness is no physics of a contact.
View view(const Surface& surface, Vec2 point);

}  // namespace lichtenberg::effects
