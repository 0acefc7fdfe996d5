#pragma once

// Formulas of link.hpp applied to the shapes: the cells that a body covers, and the conductances of links to its
// surface. One source for the CPU and CUDA devices; device code has no std::variant.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "solvers/geometry/shape.hpp"
#include "solvers/laplace/cutcell/link.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Formula of the conductance of links between fluid cells and conductors at cut cells.
enum class LinkFormula {
  /// Logarithmic profile of the potential, exact for an isolated circle (log_fitted_link).
  log_fitted,
  /// 1 / cut length: a linear profile from the cell centre to the surface.
  plain,
  /// Textbook cut cells: open fractions of faces, and surface area / distance (apertures.hpp). Assembled systems only.
  aperture,
};

struct Outline;

/// Function that returns the conductance of the link between a fluid cell centre p and a body in a neighbouring cell.
/// The neighbouring cell lies in direction e (a unit vector) from p. Lengths are in cells. The result contains the
/// derivative with respect to the body's position.
using LinkFunction = Conductance (*)(const Outline& body, Vec2 p, Vec2 e);

/// User-defined formula for the conductance between fluid cells and a disk, in place of LinkFormula. It may use data of
/// the disk such as the thickness of a coating. The CPU solver and the device algorithms on the host call it; a CUDA
/// device refuses it. CutCellSolver checks that the grid resolves the disk and that its gaps are wide, so that no other
/// formula is needed.
class LinkModel {
 public:
  virtual ~LinkModel() = default;
  /// Returns the name of the model for error messages.
  virtual std::string name() const = 0;
  /// Returns two dimensionless parameters of the body, such as a coating's thickness over the radius. The function that
  /// formula() returns reads them in Outline::data. They must be the same for cells of any size.
  virtual std::array<double, 2> data(const Body& body) const = 0;
  /// Returns the function that computes the conductance of a link between a fluid cell and the disk.
  virtual LinkFunction formula() const = 0;
};

/// Shape of a body (conductor) in units of cells: disk, ring, bar or closed curve. CUDA device code uses it in place of
/// std::variant; it has no closed curves.
struct Outline {
  enum class Kind : std::int32_t { disk, ring, bar, curve } kind = Kind::disk;
  /// Centre of a disk, a ring or a curve's bounding rectangle, first end of a bar's longer axis.
  Vec2 centre;
  /// Second end of that axis, or half the width and height of a curve's bounding rectangle.
  Vec2 end;
  /// Radius, or the bar's extent across that axis, or the curve's area over its perimeter.
  double size = 0;
  /// Formula of the body's link model, which uses `data`; null: the solver's LinkFormula.
  LinkFunction link = nullptr;
  double data[2] = {};
  /// Closed curve (m), and the size of a cell (m).
  const ClosedCurve* curve = nullptr;
  double cell = 0;

  LICHTENBERG_HOST_DEVICE bool round() const { return kind == Kind::disk || kind == Kind::ring; }
};

/// Returns the same rectangle as a bar whose axis runs along its longer sides.
inline Bar with_longer_axis(const Bar& bar) {
  const Vec2 axis = bar.to - bar.from;
  const double length = norm(axis);
  if (length >= bar.width) return bar;
  const Vec2 centre = 0.5 * (bar.from + bar.to), half_width = 0.5 * bar.width / length * Vec2{-axis.y, axis.x};
  return {centre - half_width, centre + half_width, length};
}

// Functions for closed curves (curve_links.cpp), which are not in device code. Lengths are in cells.

/// Returns the outline of a closed curve for cells of size h (m).
Outline curve_outline(const ClosedCurve& curve, double h);
/// Returns true if the curve's conductor covers p. A conductor much thinner than a cell is widened, so that it covers a
/// connected chain of cells.
bool curve_covers(const Outline& body, Vec2 p);
/// Computes whether the curve's conductor covers the centres of the cells of row j in the columns `from` to `to`, as
/// curve_covers does, but in a pass along the row.
void covered_columns(const Outline& body, int j, int from, int to, std::vector<char>& covered);

/// Converts a shape to units of cells: divides every length by the cell size h (m).
inline Outline outline_in_cells(const Shape& shape, double h) {
  if (const auto* disk = std::get_if<Disk>(&shape))
    return {Outline::Kind::disk, disk->centre / h, {}, disk->radius / h};
  if (const auto* ring = std::get_if<Ring>(&shape))
    return {Outline::Kind::ring, ring->centre / h, {}, ring->radius / h};
  if (const auto* freeform = std::get_if<Freeform>(&shape)) return curve_outline(*freeform->curve, h);
  const Bar bar = with_longer_axis(std::get<Bar>(shape));
  return {Outline::Kind::bar, bar.from / h, bar.to / h, bar.width / h};
}

/// Converts a body's shape to units of cells of size h (m), with the formula and data of its link model.
inline Outline outline_in_cells(const Body& body, double h) {
  Outline outline = outline_in_cells(body.shape, h);
  if (body.link_model) {
    const std::array<double, 2> data = body.link_model->data(body);
    outline.link = body.link_model->formula();
    outline.data[0] = data[0], outline.data[1] = data[1];
  }
  return outline;
}

/// Returns the unit vector from a cell's centre towards one of its sides. `side`: 0 left, 1 right, 2 bottom, 3 top
/// (SideIndex).
LICHTENBERG_HOST_DEVICE inline Vec2 direction(int side) {
  return {static_cast<double>((side == 1) - (side == 0)), static_cast<double>((side == 3) - (side == 2))};
}

/// Returns the centre of cell (i, j), in cells.
LICHTENBERG_HOST_DEVICE inline Vec2 cell_centre(int i, int j) { return {i + 0.5, j + 0.5}; }

/// Computes the signed distance (cells) from p to the body's surface, positive in the fluid.
LICHTENBERG_HOST_DEVICE inline double signed_distance(const Outline& outline, Vec2 p) {
#ifndef __CUDA_ARCH__
  if (outline.kind == Outline::Kind::curve)
    return lichtenberg::signed_distance(Freeform{outline.curve}, outline.cell * p) / outline.cell;
#endif
  if (outline.kind == Outline::Kind::disk) return signed_distance(Disk{outline.centre, outline.size}, p);
  if (outline.kind == Outline::Kind::ring) return signed_distance(Ring{outline.centre, outline.size}, p);
  return signed_distance(Bar{outline.centre, outline.end, outline.size}, p);
}

/// Rectangle of cells: columns `from_i` to `to_i` and rows `from_j` to `to_j`, ends included.
struct CellRange {
  int from_i, to_i, from_j, to_j;
};

/// Returns the index of the cell that contains the coordinate x (in cells), limited to 0 ... n - 1.
LICHTENBERG_HOST_DEVICE inline int cell_at(double x, int n) {
  const int i = static_cast<int>(std::floor(x));
  return i < 0 ? 0 : i < n ? i : n - 1;
}

/// Computes a rectangle of cells of an nx x ny grid that contains all cells covered by the body. A ring covers the
/// cells outside its circle, so that it gets the whole grid.
LICHTENBERG_HOST_DEVICE inline CellRange cells_around(const Outline& body, int nx, int ny) {
  if (body.kind == Outline::Kind::ring || (body.kind == Outline::Kind::curve && body.end.x < 0))
    return {0, nx - 1, 0, ny - 1};
  Vec2 low = body.centre, high = body.centre;
  double margin = body.size;
  if (body.kind == Outline::Kind::bar) {
    low = {std::min(low.x, body.end.x), std::min(low.y, body.end.y)};
    high = {std::max(high.x, body.end.x), std::max(high.y, body.end.y)};
    margin = 0.5 * std::max(body.size, 2.0) + 1;
  }
  if (body.kind == Outline::Kind::curve) {
    low = body.centre - body.end;
    high = body.centre + body.end;
    margin = 1;
  }
  return {cell_at(low.x - margin, nx), cell_at(high.x + margin, nx), cell_at(low.y - margin, ny),
          cell_at(high.y + margin, ny)};
}

/// Returns true if the body covers the centre of cell (i, j). A bar thinner than about a cell is widened so that it
/// covers a connected chain of cells.
LICHTENBERG_HOST_DEVICE inline bool covers(const Outline& body, int i, int j) {
  if (body.kind == Outline::Kind::disk) {
    const double dx = i + 0.5 - body.centre.x, dy = j + 0.5 - body.centre.y;
    return dx * dx + dy * dy <= body.size * body.size;
  }
  if (body.kind == Outline::Kind::ring) return signed_distance(body, cell_centre(i, j)) <= 0;
#ifndef __CUDA_ARCH__
  if (body.kind == Outline::Kind::curve) return curve_covers(body, cell_centre(i, j));
#endif
  // A bar thinner than a cell separates the fluid on its two sides: it covers a connected chain of cells.
  const Vec2 axis = (body.end - body.centre) / norm(body.end - body.centre);
  const double width = std::max(body.size, std::abs(axis.x) + std::abs(axis.y));
  return signed_distance(Bar{body.centre, body.end, width}, cell_centre(i, j)) <= 0;
}

/// Intersection of a ray from a point outside a conductor with its surface: distance along the ray (cells) and outward
/// normal. A ray that misses (past a body thinner than a cell) gets the distance to the nearest surface point.
struct Hit {
  double length;
  Vec2 normal;
};

/// Computes the intersection of the ray from p in direction e (along an axis) with a closed curve.
Hit hit_curve(const Outline& body, Vec2 p, Vec2 e);
/// fluid_link for a closed curve. LinkFormula::log_fitted applies to circular pieces of a radius above a cell.
Conductance curve_link(const Outline& body, Vec2 p, Vec2 e, LinkFormula formula);
/// conductor_link if at least one of the two conductors is a closed curve.
PairConductance curve_conductor_link(const Outline& body, Vec2 p, Vec2 e, double length, const Outline* other);
/// Returns the circle that represents the curve's surface at the exit of the line from the covered point p in direction
/// e, towards the body `facing`.
SurfaceCircle curve_circle(const Outline& body, Vec2 p, Vec2 e, const Outline* facing);
/// Returns the point of the curve on which the derivative of a link acts (LinkArm). The link starts at the covered cell
/// centre p and runs in direction e. The point is the centre of a circular piece, or the point where the line leaves
/// the curve. The result is 0 for other shapes.
Vec2 curve_arm(const Outline& body, Vec2 p, Vec2 e);
/// Returns true if two circles face each other so that the gap between them widens on both sides, as gap_conductance
/// assumes, and if both are wider than a cell.
LICHTENBERG_HOST_DEVICE inline bool is_channel(const SurfaceCircle& a, const SurfaceCircle& b) {
  return std::abs(a.radius) >= 1 && std::abs(b.radius) >= 1 && 1 / a.radius + 1 / b.radius > 1e-6;
}

/// Computes the intersection of the ray from p in direction e with a circle. `from_inside`: p lies within the circle,
/// whose outside is the conductor (a ring).
LICHTENBERG_HOST_DEVICE inline Hit hit_circle(Vec2 p, Vec2 e, Vec2 centre, double radius, bool from_inside) {
  const Vec2 w = p - centre;
  const double along = dot(w, e), across = cross(e, w);
  const double root2 = radius * radius - across * across;
  const double side = from_inside ? -1.0 : 1.0;
  if (root2 <= 0 || (!from_inside && along > 0)) return {side * (norm(w) - radius), (-side / norm(e)) * e};
  const double length = -along - side * std::sqrt(root2);
  return {length, (side / radius) * (w + length * e)};
}

/// Computes the intersection of the ray from p in direction e with a bar (a rotated rectangle).
LICHTENBERG_HOST_DEVICE inline Hit hit_bar(Vec2 p, Vec2 e, const Bar& bar) {
  const double half_length = 0.5 * norm(bar.to - bar.from);
  const Vec2 axis = (bar.to - bar.from) / (2 * half_length);
  const Vec2 w = p - 0.5 * (bar.from + bar.to);
  const double position[2] = {dot(w, axis), cross(axis, w)};
  const double direction[2] = {dot(e, axis), cross(axis, e)};
  const double half[2] = {half_length, 0.5 * bar.width};
  double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
  int face = 0;
  for (int k = 0; k < 2; ++k) {
    if (direction[k] == 0) {
      if (std::abs(position[k]) > half[k]) leave = -std::numeric_limits<double>::infinity();
      continue;
    }
    const double toward = direction[k] > 0 ? -1.0 : 1.0;
    const double t_in = (toward * half[k] - position[k]) / direction[k];
    const double t_out = (-toward * half[k] - position[k]) / direction[k];
    if (t_in > enter) {
      enter = t_in;
      face = k;
    }
    leave = std::min(leave, t_out);
  }
  if (enter > leave || enter < 0) return {std::max(signed_distance(bar, p), 1e-3), -e};
  const Vec2 normal = face == 0 ? axis : perpendicular(axis);
  return {enter, dot(normal, e) < 0 ? normal : -normal};
}

/// Computes the intersection of the ray from the fluid point p in direction e with the body's surface. Lengths are in
/// cells.
LICHTENBERG_HOST_DEVICE inline Hit hit(const Outline& body, Vec2 p, Vec2 e) {
  if (body.round()) return hit_circle(p, e, body.centre, body.size, body.kind == Outline::Kind::ring);
#ifndef __CUDA_ARCH__
  if (body.kind == Outline::Kind::curve) return hit_curve(body, p, e);
#endif
  return hit_bar(p, e, Bar{body.centre, body.end, body.size});
}

/// Computes the conductance of the link between the fluid cell centre p and a body in the neighbouring cell in
/// direction e. The body's own link model replaces `formula` (not in device code). For bars, and for
/// LinkFormula::aperture, the formula is LinkFormula::plain. Lengths are in cells; e is a unit vector. The returned
/// derivative is with respect to the body's position.
LICHTENBERG_HOST_DEVICE inline Conductance fluid_link(const Outline& body, Vec2 p, Vec2 e, LinkFormula formula) {
#ifndef __CUDA_ARCH__
  if (body.link) return body.link(body, p, e);
  if (body.kind == Outline::Kind::curve) return curve_link(body, p, e, formula);
#endif
  const Vec2 corner_a = p + 0.5 * e + 0.5 * perpendicular(e);
  const Vec2 corner_b = p + 0.5 * e - 0.5 * perpendicular(e);
  if (formula == LinkFormula::log_fitted && body.round())
    return log_fitted_link(p, corner_a, corner_b, body.centre, body.size, body.kind == Outline::Kind::ring);
  const Hit surface = hit(body, p, e);
  return plain_link(at_least(surface.length, smallest_cut), e, surface.normal);
}

/// Computes the length (cells) inside a body of the line between two neighbouring cell centres. It runs from the centre
/// p, which the body covers, in direction e to the surface. The returned derivative is with respect to the body's
/// position.
LICHTENBERG_HOST_DEVICE inline Conductance covered_length(const Outline& body, Vec2 p, Vec2 e) {
  if (body.kind == Outline::Kind::disk) {
    const Exit exit = circle_exit(p, e, {body.centre, body.size});
    return {exit.length, exit.gradient};
  }
  const Hit surface = hit(body, p + e, -e);
  return {1.0 - surface.length, surface.normal / dot(surface.normal, e)};
}

/// Represents a flat conductor surface by a circle of radius 1e5 cells, for gap_conductance. The radius is large enough
/// to be flat and small enough for the rounding of the centre. n: normal out of the conductor; `on_surface`: any point
/// on it. The circle touches the surface opposite the point `facing`. Half a cell away, its curvature changes the gap
/// by 1e-6 cell.
LICHTENBERG_HOST_DEVICE inline SurfaceCircle flat_surface(Vec2 on_surface, Vec2 n, Vec2 facing) {
  constexpr double flat_radius = 1e5;
  const Vec2 along = perpendicular(n);
  return {on_surface + dot(along, facing - on_surface) * along - flat_radius * n, flat_radius};
}

/// Returns the circle that represents a body's surface at the exit of a line towards another body, `facing`. The line
/// starts at the cell centre p, which the body covers, and runs in direction e. Lengths are in cells.
LICHTENBERG_HOST_DEVICE inline SurfaceCircle surface_circle(const Outline& body, Vec2 p, Vec2 e,
                                                            const Outline& facing) {
  if (body.kind == Outline::Kind::disk) return {body.centre, body.size};
  if (body.kind == Outline::Kind::ring) return {body.centre, -body.size};
#ifndef __CUDA_ARCH__
  if (body.kind == Outline::Kind::curve) return curve_circle(body, p, e, &facing);
  if (facing.kind == Outline::Kind::curve) {
    const Conductance covered = covered_length(body, p, e);
    const Vec2 exit = p + covered.value * e;
    return flat_surface(exit, covered.gradient / norm(covered.gradient), exit);
  }
#endif
  const Conductance covered = covered_length(body, p, e);
  return flat_surface(p + covered.value * e, covered.gradient / norm(covered.gradient), facing.centre);
}

/// Computes the conductance of the direct link between two conductors in neighbouring cells, without a fluid cell
/// between them. `body` covers the cell centre p; `other` covers the point at distance `length` (cells) in direction e.
/// A null `other` means an electrode side of the box. If at least one of the two is a disk, the result is the integral
/// over the gap (gap_conductance); otherwise it is 1 / gap. A gap is at least `smallest_gap`. The returned derivatives
/// are with respect to both positions.
LICHTENBERG_HOST_DEVICE inline PairConductance conductor_link(const Outline& body, Vec2 p, Vec2 e, double length,
                                                              const Outline* other) {
#ifndef __CUDA_ARCH__
  if (body.kind == Outline::Kind::curve || (other && other->kind == Outline::Kind::curve))
    return curve_conductor_link(body, p, e, length, other);
#endif
  const Vec2 q = p + length * e;
  const bool disk = body.kind == Outline::Kind::disk, to_disk = other && other->kind == Outline::Kind::disk;
  if (to_disk || (disk && other)) {
    return gap_conductance(p, e, length, surface_circle(body, p, e, *other), surface_circle(*other, q, -e, body));
  }
  if (disk) return gap_conductance(p, e, length, {body.centre, body.size}, flat_surface(q, -e, body.centre));
  const Conductance in_a = covered_length(body, p, e);
  const Conductance in_b = other ? covered_length(*other, q, -e) : Conductance{};
  const double c = 1.0 / at_least(length - in_a.value - in_b.value, smallest_gap);
  return {c, c * c * in_a.gradient, c * c * in_b.gradient};
}

/// Result of correct_for_opposed_surface, for a fluid cell in a narrow gap between two conductors.
struct OpposedSurfaceCorrection {
  /// True if the link was corrected: the gap is at most a cell wide, and one of the conductors is a disk.
  bool close = false;
  /// Derivative of the corrected conductance with respect to the position of the conductor on the other side of the
  /// gap.
  Vec2 partner_gradient;
};

/// Corrects the conductance c of a link across a gap of one fluid cell between two conductors, at least one of them a
/// disk. The cell's two links are in series and give 1 / gap along the line through the cell's centre. Both are
/// multiplied by the ratio of the gap's integral over the cell's width (gap_conductance) to this value. The ratio also
/// depends on the position of the other conductor, `partner`. Gaps wider than a cell are not corrected. p: centre of
/// the cell that `body` covers. The fluid cell is its neighbour in direction e, and the partner's cell is the next one.
LICHTENBERG_HOST_DEVICE inline OpposedSurfaceCorrection correct_for_opposed_surface(const Outline& body, Vec2 p, Vec2 e,
                                                                                    const Outline& partner,
                                                                                    Conductance& c) {
  const bool any_curve = body.kind == Outline::Kind::curve || partner.kind == Outline::Kind::curve;
  if (body.kind != Outline::Kind::disk && partner.kind != Outline::Kind::disk && !any_curve) return {};
  const SurfaceCircle a = surface_circle(body, p, e, partner), b = surface_circle(partner, p + 2.0 * e, -e, body);
  if (any_curve && !is_channel(a, b)) return {};
  const Exit in_a = circle_exit(p, e, a), in_b = circle_exit(p + 2.0 * e, -e, b);
  const double gap = at_least(2.0 - in_a.length - in_b.length, smallest_gap);
  if (gap > 1.0) return {};
  const PairConductance integral = gap_conductance(p, e, 2.0, a, b);
  const double factor = integral.value * gap;
  const Vec2 partner_gradient = c.value * (gap * integral.gradient_b - integral.value * in_b.gradient);
  c.gradient = factor * c.gradient + c.value * (gap * integral.gradient_a - integral.value * in_a.gradient);
  c.value *= factor;
  return {true, partner_gradient};
}

/// Computes the conductance between a disk that covers no cell centre and the body that covers the disk's cell. For two
/// disks it is the conductance between two circles in the plane (circle_pair). Any other body is approximated by a
/// plane, without derivatives.
LICHTENBERG_HOST_DEVICE inline PairConductance shared_cell_link(const Outline& disk, const Outline& owner) {
  if (owner.kind == Outline::Kind::disk) return circle_pair(disk.centre, disk.size, owner.centre, owner.size);
  // Another shape is approximated by a plane.
  const double gap = at_least(signed_distance(owner, disk.centre) - disk.size, smallest_gap);
  return {2 * std::numbers::pi / std::acosh(1 + gap / disk.size), {}, {}};
}

}  // namespace lichtenberg::laplace
