// Links of closed curves. Lengths are in cells, those of the curve in m.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/geometry/closed_curve.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

namespace {

/// A crossing may lie behind a cell centre by this length (cells), because of rounding.
constexpr double slack = 1e-6;

/// Returns the length by which a curve is widened. A curve contains a circle of the radius area / perimeter at least,
/// and a circle of half a cell's diagonal covers a cell centre.
double widening(const Outline& body) {
  return body.curve->hollow() ? 0.0 : std::max(0.0, 0.5 * std::numbers::sqrt2 - body.size);
}

/// Crossing of a ray with a curve; `piece` is null if there is none within reach.
struct Crossing {
  double length;
  Vec2 at;
  const CurvePiece* piece;
};

Crossing cross_curve(const Outline& body, Vec2 p, Vec2 e) {
  const int axis = e.x != 0 ? 0 : 1;
  const ClosedCurve::Point first = body.curve->first_crossing(body.cell * p, axis, e[axis] > 0, slack * body.cell);
  const double length = first.distance / body.cell;
  if (first.piece < 0 || length > 1 + widening(body) + slack) return {0, {}, nullptr};
  return {length, first.at, &body.curve->pieces()[first.piece]};
}

/// Returns the unit normal at a crossing, inclined against the ray by at least a small angle.
Vec2 normal_against(const Crossing& crossing, Vec2 e) {
  constexpr double least = 1e-6;
  const Vec2 normal = outward(*crossing.piece, crossing.at);
  const double along = dot(normal, e);
  return along < -least ? normal : normal - (along + least) * e;
}

}  // namespace

Outline curve_outline(const ClosedCurve& curve, double h) {
  const Vec2 half = curve.hollow() ? Vec2{-1, -1} : (0.5 / h) * (curve.high() - curve.low());
  return {Outline::Kind::curve,
          (0.5 / h) * (curve.low() + curve.high()),
          half,
          curve.area() / curve.perimeter() / h,
          nullptr,
          {},
          &curve,
          h};
}

bool curve_covers(const Outline& body, Vec2 p) {
  const double wider = widening(body);
  if (wider == 0) return body.curve->covers(body.cell * p);
  return body.curve->signed_distance(body.cell * p) <= wider * body.cell;
}

Hit hit_curve(const Outline& body, Vec2 p, Vec2 e) {
  const Crossing crossing = cross_curve(body, p, e);
  if (!crossing.piece) return {std::max(signed_distance(body, p), 1e-3), -e};
  return {crossing.length, normal_against(crossing, e)};
}

Conductance curve_link(const Outline& body, Vec2 p, Vec2 e, LinkFormula formula) {
  const Crossing crossing = cross_curve(body, p, e);
  if (!crossing.piece) {
    const ClosedCurve::Point nearest = body.curve->nearest(body.cell * p);
    const double distance = std::max(nearest.distance / body.cell, 1e-3);
    return {1 / distance, (p - nearest.at / body.cell) / (distance * distance * distance)};
  }
  const double radius = std::abs(crossing.piece->radius) / body.cell;
  if (formula == LinkFormula::log_fitted && radius >= 1) {
    const Vec2 face = p + 0.5 * e, half = 0.5 * perpendicular(e);
    return log_fitted_link(p, face + half, face - half, crossing.piece->centre / body.cell, radius,
                           crossing.piece->radius < 0);
  }
  return plain_link(at_least(crossing.length, smallest_cut), e, normal_against(crossing, e));
}

SurfaceCircle curve_circle(const Outline& body, Vec2 p, Vec2 e, const Outline* facing) {
  const Crossing crossing = cross_curve(body, p + e, -e);
  if (crossing.piece && crossing.piece->radius != 0)
    return {crossing.piece->centre / body.cell, crossing.piece->radius / body.cell};
  const Hit surface = hit_curve(body, p + e, -e);
  const Vec2 exit = p + (1 - surface.length) * e;
  const bool round = facing && facing->kind == Outline::Kind::disk;
  return flat_surface(exit, surface.normal, round ? facing->centre : exit);
}

void covered_columns(const Outline& body, int j, int from, int to, std::vector<char>& covered) {
  covered.assign(to - from + 1, 0);
  if (widening(body) > 0) {
    for (int i = from; i <= to; ++i) covered[i - from] = curve_covers(body, cell_centre(i, j));
    return;
  }
  thread_local std::vector<double> x;
  body.curve->crossings(body.cell * cell_centre(from, j).y, x);
  auto next = x.begin();
  for (int i = from; i <= to; ++i) {
    while (next != x.end() && *next <= body.cell * cell_centre(i, j).x) ++next;
    covered[i - from] = (x.end() - next) % 2 != (body.curve->hollow() ? 1 : 0);
  }
}

Vec2 curve_arm(const Outline& body, Vec2 p, Vec2 e) {
  if (body.kind != Outline::Kind::curve) return {};
  const Crossing crossing = cross_curve(body, p + e, -e);
  if (!crossing.piece) return body.curve->nearest(body.cell * (p + e)).at / body.cell;
  return (crossing.piece->radius != 0 ? crossing.piece->centre : crossing.at) / body.cell;
}

PairConductance curve_conductor_link(const Outline& body, Vec2 p, Vec2 e, double length, const Outline* other) {
  const Vec2 q = p + length * e;
  const SurfaceCircle a = other ? surface_circle(body, p, e, *other) : curve_circle(body, p, e, nullptr);
  const SurfaceCircle b = other ? surface_circle(*other, q, -e, body) : flat_surface(q, -e, q);
  if (is_channel(a, b)) return gap_conductance(p, e, length, a, b);
  const Conductance in_a = covered_length(body, p, e);
  const Conductance in_b = other ? covered_length(*other, q, -e) : Conductance{};
  const double c = 1.0 / at_least(length - in_a.value - in_b.value, smallest_gap);
  return {c, c * c * in_a.gradient, c * c * in_b.gradient};
}

}  // namespace lichtenberg::laplace
