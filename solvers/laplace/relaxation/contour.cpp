#include "solvers/laplace/relaxation/contour.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::laplace {
namespace {

using std::numbers::pi;

struct OffsetPoint {
  Vec2 at;
  Vec2 outward;  ///< Unit vector away from the body's surface
};

double perimeter(const Disk& disk, double offset) { return 2 * pi * (disk.radius + offset); }
double perimeter(const Ring& ring, double offset) { return 2 * pi * (ring.radius - offset); }
double perimeter(const Bar& bar, double offset) { return 2 * (norm(bar.to - bar.from) + bar.width) + 2 * pi * offset; }
double perimeter(const Freeform&, double) { return 0; }  // refused before

/// Returns the point at fraction t in [0, 1) of the curve, counterclockwise as seen from inside the body.
OffsetPoint offset_point(const Disk& disk, double offset, double t) {
  const Vec2 outward = {std::cos(2 * pi * t), std::sin(2 * pi * t)};
  return {disk.centre + (disk.radius + offset) * outward, outward};
}

/// Returns the point for a ring. Its conductor lies outside the circle: the outward normal points to the centre, and
/// the direction of the curve is reversed.
OffsetPoint offset_point(const Ring& ring, double offset, double t) {
  const Vec2 radial = {std::cos(2 * pi * t), -std::sin(2 * pi * t)};
  return {ring.centre + (ring.radius - offset) * radial, -radial};
}

/// Returns the point for a bar: straight sides moved outward, joined by quarter circles around the corners.
OffsetPoint offset_point(const Bar& bar, double offset, double t) {
  const Vec2 axis = (bar.to - bar.from) / norm(bar.to - bar.from);
  const Vec2 across = perpendicular(axis);
  const Vec2 a = bar.from, b = bar.to, half = 0.5 * bar.width * across;
  const Vec2 corners[] = {a - half, b - half, b + half, a + half};
  const Vec2 along[] = {axis, across, -axis, -across};
  double s = t * perimeter(bar, offset);
  for (int k = 0; k < 4; ++k) {
    const double length = k % 2 == 0 ? norm(b - a) : bar.width;
    const Vec2 outward = -perpendicular(along[k]);
    if (s < length) return {corners[k] + s * along[k] + offset * outward, outward};
    s -= length;
    const double angle = offset > 0 ? s / offset : 0;
    if (angle < pi / 2 || k == 3) {
      const Vec2 turned = std::cos(angle) * outward + std::sin(angle) * along[k];
      return {corners[(k + 1) % 4] + offset * turned, turned};
    }
    s -= 0.5 * pi * offset;
  }
  return {};  // Unreachable: the fourth corner returns
}

OffsetPoint offset_point(const Freeform&, double, double) { return {}; }

std::vector<OffsetPoint> offset_curve(const Shape& shape, double offset, int points, double spacing) {
  return std::visit(
      [&](const auto& s) {
        const int needed = static_cast<int>(std::ceil(2 * perimeter(s, offset) / spacing));
        std::vector<OffsetPoint> curve(std::max(points, needed));
        for (std::size_t k = 0; k < curve.size(); ++k)
          curve[k] = offset_point(s, offset, static_cast<double>(k) / curve.size());
        return curve;
      },
      shape);
}

/// Returns the bodies within `reach` of body `index`. Only disks are tested; there are few of the others.
std::vector<const Shape*> neighbours(const LaplaceProblem& problem, std::size_t index, double reach) {
  const Body& own = problem.bodies[index];
  const Disk* disk = std::get_if<Disk>(&own.shape);
  std::vector<const Shape*> near;
  for (const Body& other : problem.bodies)
    if (&other != &own && (!disk || gap(*disk, other.shape) < reach)) near.push_back(&other.shape);
  return near;
}

/// Moves a point to half the gap along the normal if another surface is nearer than the own one, which is at `offset`.
Vec2 move_to_half_gap(const OffsetPoint& point, const std::vector<const Shape*>& near, double offset) {
  double nearest = offset;
  for (const Shape* shape : near) nearest = std::min(nearest, signed_distance(*shape, point.at));
  const double reduced = std::max(0.5 * (offset + nearest), 0.0);
  return point.at - (offset - reduced) * point.outward;
}

}  // namespace

std::vector<ContourPoint> contour(const LaplaceProblem& problem, std::size_t index, double offset, int points,
                                  double spacing) {
  const std::vector<OffsetPoint> curve = offset_curve(problem.bodies[index].shape, offset, points, spacing);
  const std::vector<const Shape*> near = neighbours(problem, index, 2 * offset);
  const std::size_t n = curve.size();
  std::vector<ContourPoint> result(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 p = near.empty() ? curve[k].at : move_to_half_gap(curve[k], near, offset);
    result[k].at = {std::clamp(p.x, 0.0, problem.size.x), std::clamp(p.y, 0.0, problem.size.y)};
  }
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 tangent = 0.5 * (result[(k + 1) % n].at - result[(k + n - 1) % n].at);
    result[k].normal_ds = -perpendicular(tangent);
  }
  return result;
}

}  // namespace lichtenberg::laplace
