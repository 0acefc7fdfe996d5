#include "src/effects/surface.hpp"

#include <cmath>

#include "solvers/geometry/closed_curve.hpp"

namespace lichtenberg::effects {
namespace {

View view_of(const Disk& disk, Vec2 p) {
  const Vec2 r = p - disk.centre;
  const double distance = norm(r);
  return {distance - disk.radius, in_space(r / distance), 1 / distance, 1 / disk.radius};
}

View view_of(const Ring& ring, Vec2 p) {
  const Vec2 r = p - ring.centre;
  const double distance = norm(r);
  // All rim points are equally near to the centre.
  if (distance == 0) return {ring.radius, {1, 0, 0}, 0, -1 / ring.radius};
  return {ring.radius - distance, in_space(-r / distance), -1 / distance, -1 / ring.radius};
}

View view_of(const Bar& bar, Vec2 p) {
  const double length = norm(bar.to - bar.from);
  const Vec2 axis = (bar.to - bar.from) / length, side = perpendicular(axis);
  const Vec2 r = p - 0.5 * (bar.from + bar.to);
  const Vec2 along = std::copysign(1.0, dot(axis, r)) * axis, across = std::copysign(1.0, dot(side, r)) * side;
  const double beyond_end = std::abs(dot(axis, r)) - 0.5 * length;
  const double beyond_side = std::abs(dot(side, r)) - 0.5 * bar.width;
  if (beyond_end > 0 && beyond_side > 0) {
    const double distance = std::hypot(beyond_end, beyond_side);
    return {distance, in_space((beyond_end * along + beyond_side * across) / distance), 1 / distance, 0};
  }
  return beyond_end > beyond_side ? View{beyond_end, in_space(along), 0, 0} : View{beyond_side, in_space(across), 0, 0};
}

/// The nearest point of a closed curve determines the normal; the circle of its piece, or a corner, the curvature.
View view_of(const Freeform& shape, Vec2 p) {
  const ClosedCurve::Point nearest = shape.curve->nearest(p);
  const CurvePiece& piece = shape.curve->pieces()[nearest.piece];
  const double distance = shape.curve->covers(p) ? -nearest.distance : nearest.distance;
  const bool is_corner = nearest.at == piece.from || nearest.at == piece.to;
  const bool too_near = nearest.distance <= 1e-9 * shape.curve->perimeter();
  if (!is_corner || too_near || distance < 0) {
    const double curvature = piece.radius == 0 ? 0 : 1 / piece.radius, share = 1 + distance * curvature;
    const double turning = std::abs(share) > 1e-9 ? curvature / share : 0;  // 0 at the centre of a concave circle
    return {distance, in_space(outward(piece, nearest.at)), turning, curvature};
  }
  return {distance, in_space((p - nearest.at) / distance), 1 / distance, 0};
}

View view_of(const Ball& ball, Vec3 p) {
  const Vec3 r = ball.box.difference(p, ball.centre);
  const double distance = norm(r);
  return {distance - ball.radius, r / distance, 1 / distance, 1 / ball.radius};
}

View view_of(const FlatWall& wall, Vec3 p) { return {dot(p - wall.point, wall.normal), wall.normal, 0, 0}; }

}  // namespace

Surface surface_of(const Shape& shape) {
  return std::visit([](const auto& s) { return Surface{s}; }, shape);
}

Surface surface_of(const Electrode& electrode, const Domain& domain) {
  if (domain.dimension() == 3) return Ball{electrode.centre(), std::get<Disk>(electrode.shape).radius, domain.box()};
  return surface_of(electrode.shape);
}

std::vector<Surface> sides_of(const Domain& domain) {
  std::vector<Surface> sides;
  for (int k = 0; k < domain.dimension(); ++k) {
    Vec3 inward;
    inward[k] = 1;
    sides.push_back(FlatWall{{}, inward});
    sides.push_back(FlatWall{domain.size, -inward});
  }
  return sides;
}

View view(const Surface& surface, Vec3 point) {
  return std::visit(
      [point](const auto& s) {
        if constexpr (requires { view_of(s, point); })
          return view_of(s, point);
        else
          return view_of(s, plane(point));
      },
      surface);
}

}  // namespace lichtenberg::effects
