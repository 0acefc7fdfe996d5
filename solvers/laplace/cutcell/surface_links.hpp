#pragma once

// Which cells a body covers and how strongly a link that meets its surface conducts: link.hpp's formulas applied to
// the shapes. One source for the CPU and a CUDA device, which cannot hold a std::variant.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

#include "solvers/geometry/shape.hpp"
#include "solvers/laplace/cutcell/link.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// How a fluid cell is coupled to a conductor's surface.
enum class LinkFormula {
  log_fitted,  ///< exact for an isolated circle (link.hpp)
  plain,       ///< 1 / cut length
  aperture,    ///< open faces, surface / distance (apertures.hpp); assembled systems only
};

struct Outline;

/// Conductance between the fluid cell centre p and a body in the next cell in direction e, and its derivative with
/// respect to the body's position. Lengths are in cells.
using LinkFunction = Conductance (*)(const Outline& body, Vec2 p, Vec2 e);

/// A formula for the links between fluid cells and a disk, in place of LinkFormula, with data of the disk: a coat, say.
/// Grids of the CPU and the device's algorithms on the host call the same function; a CUDA device cannot, and refuses
/// it. CutCellSolver checks that no other formula is needed: that the disk is resolved and stands apart from others.
class LinkModel {
 public:
  virtual ~LinkModel() = default;
  virtual std::string name() const = 0;  ///< for error messages
  /// Numbers for `formula`, which finds them in Outline::data: without unit, the same for cells of every size.
  virtual std::array<double, 2> data(const Body& body) const = 0;
  virtual LinkFunction formula() const = 0;
};

/// A body's shape in units of cells.
struct Outline {
  enum class Kind : std::int32_t { disk, ring, bar } kind = Kind::disk;
  Vec2 centre;                  ///< of a disk or ring, of a bar's one end
  Vec2 end;                     ///< a bar's other end
  double size = 0;              ///< radius, or a bar's width
  LinkFunction link = nullptr;  ///< of the body's link model; null: LinkFormula
  double data[2] = {};          ///< of the link model

  LICHTENBERG_HOST_DEVICE bool round() const { return kind != Kind::bar; }
};

/// The shape with every length divided by h.
inline Outline outline_in_cells(const Shape& shape, double h) {
  if (const auto* disk = std::get_if<Disk>(&shape))
    return {Outline::Kind::disk, disk->centre / h, {}, disk->radius / h};
  if (const auto* ring = std::get_if<Ring>(&shape))
    return {Outline::Kind::ring, ring->centre / h, {}, ring->radius / h};
  const auto& bar = std::get<Bar>(shape);
  return {Outline::Kind::bar, bar.from / h, bar.to / h, bar.width / h};
}

/// The body's shape and the data of its links.
inline Outline outline_in_cells(const Body& body, double h) {
  Outline outline = outline_in_cells(body.shape, h);
  if (body.link_model) {
    const std::array<double, 2> data = body.link_model->data(body);
    outline.link = body.link_model->formula();
    outline.data[0] = data[0], outline.data[1] = data[1];
  }
  return outline;
}

/// Unit vector towards a side of a cell, by SideIndex.
LICHTENBERG_HOST_DEVICE inline Vec2 direction(int side) {
  return {static_cast<double>((side == 1) - (side == 0)), static_cast<double>((side == 3) - (side == 2))};
}

LICHTENBERG_HOST_DEVICE inline Vec2 cell_centre(int i, int j) { return {i + 0.5, j + 0.5}; }

LICHTENBERG_HOST_DEVICE inline double signed_distance(const Outline& outline, Vec2 p) {
  if (outline.kind == Outline::Kind::disk) return signed_distance(Disk{outline.centre, outline.size}, p);
  if (outline.kind == Outline::Kind::ring) return signed_distance(Ring{outline.centre, outline.size}, p);
  return signed_distance(Bar{outline.centre, outline.end, outline.size}, p);
}

/// Columns `from_i` to `to_i` and rows `from_j` to `to_j`, all included.
struct CellRange {
  int from_i, to_i, from_j, to_j;
};

LICHTENBERG_HOST_DEVICE inline int cell_at(double x, int n) {
  const int i = static_cast<int>(std::floor(x));
  return i < 0 ? 0 : i < n ? i : n - 1;
}

/// Cells of an nx x ny grid among which all that the body covers are.
LICHTENBERG_HOST_DEVICE inline CellRange cells_around(const Outline& body, int nx, int ny) {
  if (body.kind == Outline::Kind::ring) return {0, nx - 1, 0, ny - 1};
  Vec2 low = body.centre, high = body.centre;
  double margin = body.size;
  if (body.kind == Outline::Kind::bar) {
    low = {std::min(low.x, body.end.x), std::min(low.y, body.end.y)};
    high = {std::max(high.x, body.end.x), std::max(high.y, body.end.y)};
    margin = 0.5 * std::max(body.size, 2.0) + 1;
  }
  return {cell_at(low.x - margin, nx), cell_at(high.x + margin, nx), cell_at(low.y - margin, ny),
          cell_at(high.y + margin, ny)};
}

/// Whether the body covers the centre of cell (i, j).
LICHTENBERG_HOST_DEVICE inline bool covers(const Outline& body, int i, int j) {
  if (body.kind == Outline::Kind::disk) {
    const double dx = i + 0.5 - body.centre.x, dy = j + 0.5 - body.centre.y;
    return dx * dx + dy * dy <= body.size * body.size;
  }
  if (body.kind == Outline::Kind::ring) return signed_distance(body, cell_centre(i, j)) <= 0;
  // A bar thinner than a cell still separates what lies on its two sides: it takes a connected chain of cells.
  const Vec2 axis = (body.end - body.centre) / norm(body.end - body.centre);
  const double width = std::max(body.size, std::abs(axis.x) + std::abs(axis.y));
  return signed_distance(Bar{body.centre, body.end, width}, cell_centre(i, j)) <= 0;
}

/// Distance from p, outside the shape, along the unit vector e to its surface, with the outward normal there.
/// A ray that misses (a body thinner than a cell, taken as one cell) gets the distance to the nearest surface point.
struct Hit {
  double length;
  Vec2 normal;
};

LICHTENBERG_HOST_DEVICE inline Hit hit_circle(Vec2 p, Vec2 e, Vec2 centre, double radius, bool from_inside) {
  const Vec2 w = p - centre;
  const double along = dot(w, e), across = cross(e, w);
  const double root2 = radius * radius - across * across;
  const double side = from_inside ? -1.0 : 1.0;
  if (root2 <= 0 || (!from_inside && along > 0)) return {side * (norm(w) - radius), (-side / norm(e)) * e};
  const double length = -along - side * std::sqrt(root2);
  return {length, (side / radius) * (w + length * e)};
}

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

LICHTENBERG_HOST_DEVICE inline Hit hit(const Outline& body, Vec2 p, Vec2 e) {
  if (body.round()) return hit_circle(p, e, body.centre, body.size, body.kind == Outline::Kind::ring);
  return hit_bar(p, e, Bar{body.centre, body.end, body.size});
}

/// Conductance between the fluid cell centre p and a body in the next cell in direction e.
LICHTENBERG_HOST_DEVICE inline Conductance fluid_link(const Outline& body, Vec2 p, Vec2 e, LinkFormula formula) {
#ifndef __CUDA_ARCH__
  if (body.link) return body.link(body, p, e);
#endif
  const Vec2 corner_a = p + 0.5 * e + 0.5 * perpendicular(e);
  const Vec2 corner_b = p + 0.5 * e - 0.5 * perpendicular(e);
  if (formula == LinkFormula::log_fitted && body.round())
    return log_fitted_link(p, corner_a, corner_b, body.centre, body.size, body.kind == Outline::Kind::ring);
  const Hit surface = hit(body, p, e);
  return plain_link(at_least(surface.length, smallest_cut), e, surface.normal);
}

/// Length of a link's part inside a body, from the covered centre p in direction e to where it leaves the body, and
/// its derivative with respect to the body's position.
LICHTENBERG_HOST_DEVICE inline Conductance covered_length(const Outline& body, Vec2 p, Vec2 e) {
  if (body.kind == Outline::Kind::disk) {
    const Exit exit = circle_exit(p, e, body.centre, body.size);
    return {exit.length, exit.gradient};
  }
  const Hit surface = hit(body, p + e, -e);
  return {1.0 - surface.length, surface.normal / dot(surface.normal, e)};
}

/// A surface as `channel` takes it: a circle, of negative radius if the conductor lies round it.
struct Curve {
  Vec2 centre;
  double radius;
};

/// A flat surface as a circle, large enough to be flat and small enough for its centre's rounding, n being the normal
/// out of the conductor. Its pole lies opposite `facing`: half a cell beside, its bulge would be a gap of 1e-6 cell.
LICHTENBERG_HOST_DEVICE inline Curve flat_curve(Vec2 on_surface, Vec2 n, Vec2 facing) {
  constexpr double flat_radius = 1e5;
  const Vec2 along = perpendicular(n);
  return {on_surface + dot(along, facing - on_surface) * along - flat_radius * n, flat_radius};
}

/// The surface of a body where the line from its covered centre p in direction e leaves it towards `facing`.
LICHTENBERG_HOST_DEVICE inline Curve curve(const Outline& body, Vec2 p, Vec2 e, const Outline& facing) {
  if (body.kind == Outline::Kind::disk) return {body.centre, body.size};
  if (body.kind == Outline::Kind::ring) return {body.centre, -body.size};
  const Conductance covered = covered_length(body, p, e);
  return flat_curve(p + covered.value * e, covered.gradient / norm(covered.gradient), facing.centre);
}

/// Conductance between the covered centre p and what lies `length` away in direction e: another conductor, or an
/// electrode side (`other` null). The channel's integral wherever one of the two is a disk.
LICHTENBERG_HOST_DEVICE inline PairConductance channel_between(const Outline& body, Vec2 p, Vec2 e, double length,
                                                               const Outline* other) {
  const Vec2 q = p + length * e;
  const bool disk = body.kind == Outline::Kind::disk, to_disk = other && other->kind == Outline::Kind::disk;
  if (to_disk || (disk && other)) {
    const Curve a = curve(body, p, e, *other), b = curve(*other, q, -e, body);
    return channel(p, e, length, a.centre, a.radius, b.centre, b.radius);
  }
  if (disk) {
    const Curve side = flat_curve(q, -e, body.centre);
    return channel(p, e, length, body.centre, body.size, side.centre, side.radius);
  }
  const Conductance in_a = covered_length(body, p, e);
  const Conductance in_b = other ? covered_length(*other, q, -e) : Conductance{};
  const double c = 1.0 / at_least(length - in_a.value - in_b.value, smallest_gap);
  return {c, c * c * in_a.gradient, c * c * in_b.gradient};
}

/// What a lone fluid cell's link to one conductor gains if a second conductor is on the cell's other side.
struct Squeeze {
  bool close = false;     ///< if false, nothing: the gap is wider than a cell, and the two links resolve it
  Vec2 partner_gradient;  ///< of the link's conductance with respect to the second conductor's position
};

/// A lone fluid cell between two conductors: its two links are in series and make 1 / gap along the line through its
/// centre. Both get the factor that turns this into the channel's integral over the width of the cell. The factor
/// depends on the other conductor's position too. `p` is the centre of the body's cell, the fluid one lies next to it
/// in direction e and the partner's cell behind that; `c`, the link's conductance, is changed.
LICHTENBERG_HOST_DEVICE inline Squeeze squeeze(const Outline& body, Vec2 p, Vec2 e, const Outline& partner,
                                               Conductance& c) {
  if (body.kind != Outline::Kind::disk && partner.kind != Outline::Kind::disk) return {};
  const Curve a = curve(body, p, e, partner), b = curve(partner, p + 2.0 * e, -e, body);
  const Exit in_a = circle_exit(p, e, a.centre, a.radius), in_b = circle_exit(p + 2.0 * e, -e, b.centre, b.radius);
  const double gap = at_least(2.0 - in_a.length - in_b.length, smallest_gap);
  if (gap > 1.0) return {};
  const PairConductance integral = channel(p, e, 2.0, a.centre, a.radius, b.centre, b.radius);
  const double factor = integral.value * gap;
  const Vec2 partner_gradient = c.value * (gap * integral.gradient_b - integral.value * in_b.gradient);
  c.gradient = factor * c.gradient + c.value * (gap * integral.gradient_a - integral.value * in_a.gradient);
  c.value *= factor;
  return {true, partner_gradient};
}

/// A disk that covers no cell's centre, in a cell that belongs to another body: its conductance to that one.
LICHTENBERG_HOST_DEVICE inline PairConductance shared_cell_link(const Outline& disk, const Outline& owner) {
  if (owner.kind == Outline::Kind::disk) return circle_pair(disk.centre, disk.size, owner.centre, owner.size);
  // Beside a body of another shape: a circle in front of a plane.
  const double gap = at_least(signed_distance(owner, disk.centre) - disk.size, smallest_gap);
  return {2 * std::numbers::pi / std::acosh(1 + gap / disk.size), {}, {}};
}

}  // namespace lichtenberg::laplace
