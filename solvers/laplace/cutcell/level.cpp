#include "solvers/laplace/cutcell/level.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/laplace/cutcell/link.hpp"

namespace lichtenberg::laplace {

namespace {

constexpr std::array<Vec2, 4> directions{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};  // by SideIndex

/// Distance from p, outside the shape, along the unit vector e to its surface, with the outward normal there.
/// A ray that misses (a body thinner than a cell, taken as one cell) gets the distance to the nearest surface point.
struct Hit {
  double length;
  Vec2 normal;
};

Hit hit_circle(Vec2 p, Vec2 e, Vec2 centre, double radius, bool from_inside) {
  const Vec2 w = p - centre;
  const double along = dot(w, e), across = cross(e, w);
  const double root2 = radius * radius - across * across;
  const double side = from_inside ? -1.0 : 1.0;
  if (root2 <= 0 || (!from_inside && along > 0)) return {side * (norm(w) - radius), (-side / norm(e)) * e};
  const double length = -along - side * std::sqrt(root2);
  return {length, (side / radius) * (w + length * e)};
}

Hit hit_bar(Vec2 p, Vec2 e, const Bar& bar) {
  const double half_length = 0.5 * norm(bar.to - bar.from);
  const Vec2 axis = (bar.to - bar.from) / (2 * half_length);
  const Vec2 w = p - 0.5 * (bar.from + bar.to);
  const std::array<double, 2> position{dot(w, axis), cross(axis, w)};
  const std::array<double, 2> direction{dot(e, axis), cross(axis, e)};
  const std::array<double, 2> half{half_length, 0.5 * bar.width};
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

Hit hit(const Shape& shape, Vec2 p, Vec2 e) {
  if (const auto* disk = std::get_if<Disk>(&shape)) return hit_circle(p, e, disk->centre, disk->radius, false);
  if (const auto* ring = std::get_if<Ring>(&shape)) return hit_circle(p, e, ring->centre, ring->radius, true);
  return hit_bar(p, e, std::get<Bar>(shape));
}

/// Conductance between the fluid cell centre p and a body in the next cell in direction e.
Conductance fluid_link(const Shape& shape, Vec2 p, Vec2 e, LinkFormula formula) {
  const Vec2 corner_a = p + 0.5 * e + 0.5 * perpendicular(e);
  const Vec2 corner_b = p + 0.5 * e - 0.5 * perpendicular(e);
  if (formula == LinkFormula::log_fitted) {
    if (const auto* disk = std::get_if<Disk>(&shape))
      return log_fitted_link(p, corner_a, corner_b, disk->centre, disk->radius);
    if (const auto* ring = std::get_if<Ring>(&shape))
      return log_fitted_link(p, corner_a, corner_b, ring->centre, ring->radius, true);
  }
  const Hit surface = hit(shape, p, e);
  return plain_link(std::max(surface.length, smallest_cut), e, surface.normal);
}

/// Length of a link's part inside a body, from the covered centre p in direction e to where it leaves the body, and
/// its derivative with respect to the body's position.
Conductance covered_length(const Shape& shape, Vec2 p, Vec2 e) {
  if (const auto* disk = std::get_if<Disk>(&shape)) {
    const Exit exit = circle_exit(p, e, disk->centre, disk->radius);
    return {exit.length, exit.gradient};
  }
  const Hit surface = hit(shape, p + e, -e);
  return {1.0 - surface.length, surface.normal / dot(surface.normal, e)};
}

/// Conductance between the covered centre p and what lies `length` away in direction e: another conductor, or an
/// electrode side (`other` null).
PairConductance channel_between(const Shape& shape, Vec2 p, Vec2 e, double length, const Shape* other) {
  // A flat surface is a circle too, if it is large enough (and small enough for its centre's rounding).
  constexpr double flat_radius = 1e5;
  const Vec2 q = p + length * e;
  const auto* a = std::get_if<Disk>(&shape);
  const auto* b = other ? std::get_if<Disk>(other) : nullptr;
  if (a && b) return channel(p, e, length, a->centre, a->radius, b->centre, b->radius);
  if (a && !other) return channel(p, e, length, a->centre, a->radius, q + flat_radius * e, flat_radius);
  const Conductance in_a = covered_length(shape, p, e);
  const Conductance in_b = other ? covered_length(*other, q, -e) : Conductance{};
  const double c = 1.0 / std::max(length - in_a.value - in_b.value, smallest_gap);
  return {c, c * c * in_a.gradient, c * c * in_b.gradient};
}

}  // namespace

Shape in_cells(const Shape& shape, double h) {
  if (const auto* disk = std::get_if<Disk>(&shape)) return Disk{disk->centre / h, disk->radius / h};
  if (const auto* ring = std::get_if<Ring>(&shape)) return Ring{ring->centre / h, ring->radius / h};
  const auto& bar = std::get<Bar>(shape);
  return Bar{bar.from / h, bar.to / h, bar.width / h};
}

Level::Level(const LaplaceProblem& problem, int nx, int ny)
    : layout(nx, ny), h(problem.size.x / nx), cover(layout.size(), -1), diagonal(layout.size(), 0.0) {}

void Level::build(const LaplaceProblem& problem, LinkFormula formula) {
  shapes_.clear();
  for (const Body& body : problem.bodies) shapes_.push_back(in_cells(body.shape, h));
  cover_cells(problem);
  link_cells(problem, formula);
  link_sides(problem);
}

void Level::cover_cells(const LaplaceProblem& problem) {
  for (const std::ptrdiff_t slot : covered) cover[slot] = -1;
  covered.clear();
  covered_cells_.clear();
  lodgers_.clear();
  for (int body = 0; body < static_cast<int>(problem.bodies.size()); ++body) cover_body(shapes_[body], body);
  fluid_cells = static_cast<long>(layout.nx) * layout.ny - static_cast<long>(covered.size());
}

void Level::cover_body(const Shape& shape, int body) {
  const auto claim = [&](int i, int j) {
    const std::ptrdiff_t slot = layout(i, j);
    if (cover[slot] >= 0) return;
    cover[slot] = body;
    covered.push_back(slot);
    covered_cells_.push_back({i, j});
  };
  const auto column = [&](double x) { return std::clamp(static_cast<int>(std::floor(x)), 0, layout.nx - 1); };
  const auto row = [&](double y) { return std::clamp(static_cast<int>(std::floor(y)), 0, layout.ny - 1); };

  if (const auto* disk = std::get_if<Disk>(&shape)) {
    const std::size_t before = covered.size();
    const double r = disk->radius;
    for (int j = row(disk->centre.y - r); j <= row(disk->centre.y + r); ++j) {
      const double dy = j + 0.5 - disk->centre.y;
      for (int i = column(disk->centre.x - r); i <= column(disk->centre.x + r); ++i) {
        const double dx = i + 0.5 - disk->centre.x;
        if (dx * dx + dy * dy <= r * r) claim(i, j);
      }
    }
    // A conductor is a conductor on every grid: one that covers no cell centre takes the cell it lies in. The
    // log-fitted link stays right for it (it knows R, however small). Where that cell is taken, it is linked to the
    // conductor that has it.
    if (covered.size() == before) {
      claim(column(disk->centre.x), row(disk->centre.y));
      if (covered.size() == before)
        lodgers_.push_back({body, cover[layout(column(disk->centre.x), row(disk->centre.y))]});
    }
    return;
  }
  if (const auto* bar = std::get_if<Bar>(&shape)) {
    // A bar thinner than a cell still separates what lies on its two sides: it takes a connected chain of cells.
    const Vec2 axis = (bar->to - bar->from) / norm(bar->to - bar->from);
    Bar thick = *bar;
    thick.width = std::max(bar->width, std::abs(axis.x) + std::abs(axis.y));
    const double margin = 0.5 * thick.width + 1;
    for (int j = row(std::min(bar->from.y, bar->to.y) - margin); j <= row(std::max(bar->from.y, bar->to.y) + margin);
         ++j)
      for (int i = column(std::min(bar->from.x, bar->to.x) - margin);
           i <= column(std::max(bar->from.x, bar->to.x) + margin); ++i)
        if (signed_distance(thick, {i + 0.5, j + 0.5}) <= 0) claim(i, j);
    return;
  }
  for (int j = 0; j < layout.ny; ++j)
    for (int i = 0; i < layout.nx; ++i)
      if (signed_distance(shape, {i + 0.5, j + 0.5}) <= 0) claim(i, j);
}

void Level::link_cells(const LaplaceProblem& problem, LinkFormula formula) {
  links.clear();
  cross_gradients.clear();
  pairs.clear();
  for (int colour = 0; colour < 2; ++colour)
    for (int j = 0; j < layout.ny; ++j) {
      const auto begin = diagonal.begin() + layout.row(colour, j);
      std::fill(begin, begin + layout.row_length(colour, j), 4.0);
    }
  for (const std::ptrdiff_t slot : covered) diagonal[slot] = 0;
  for (std::size_t k = 0; k < covered.size(); ++k) link_cell(problem, formula, covered_cells_[k], cover[covered[k]]);
  for (const Lodger& lodger : lodgers_) link_lodger(problem, lodger);
}

void Level::link_lodger(const LaplaceProblem& problem, Lodger lodger) {
  if (problem.bodies[lodger.body].group == problem.bodies[lodger.host].group) return;
  const auto& disk = std::get<Disk>(shapes_[lodger.body]);
  const Shape& host = shapes_[lodger.host];
  if (const auto* other = std::get_if<Disk>(&host)) {
    const PairConductance c = circle_pair(disk.centre, disk.radius, other->centre, other->radius);
    pairs.push_back({lodger.body, lodger.host, c.value, c.gradient_a, c.gradient_b});
    return;
  }
  // Beside a body of another shape: a circle in front of a plane.
  const double gap = std::max(signed_distance(host, disk.centre) - disk.radius, smallest_gap);
  pairs.push_back({lodger.body, lodger.host, 2 * std::numbers::pi / std::acosh(1 + gap / disk.radius), {}, {}});
}

void Level::link_cell(const LaplaceProblem& problem, LinkFormula formula, Cell cell, int body) {
  for (int d = 0; d < 4; ++d) {
    const Vec2 e = directions[d];
    const Cell next{cell.i + static_cast<int>(e.x), cell.j + static_cast<int>(e.y)};
    if (!inside(next)) continue;
    const std::ptrdiff_t slot = layout(next.i, next.j);
    const int other = cover[slot];
    if (other < 0) {
      Conductance c = fluid_link(shapes_[body], centre(next), -e, formula);
      const Cell beyond{next.i + static_cast<int>(e.x), next.j + static_cast<int>(e.y)};
      if (inside(beyond)) squeeze(problem, cell, body, e, cover[layout(beyond.i, beyond.j)], c);
      links.push_back({slot, body, c.value, c.gradient});
      diagonal[slot] += c.value - 1.0;  // the neighbour is no fluid cell
    } else if (other > body && problem.bodies[other].group != problem.bodies[body].group) {
      const PairConductance c = channel_between(shapes_[body], centre(cell), e, 1.0, &shapes_[other]);
      pairs.push_back({body, other, c.value, c.gradient_a, c.gradient_b});
    }
  }
}

/// A lone fluid cell between two conductors: its two links are in series and make 1 / gap along the line through its
/// centre. Both get the factor that turns this into the channel's integral over the width of the cell. The factor
/// depends on the other conductor's position too.
void Level::squeeze(const LaplaceProblem& problem, Cell cell, int body, Vec2 e, int other, Conductance& c) {
  if (other < 0 || problem.bodies[other].group == problem.bodies[body].group) return;
  const auto* a = std::get_if<Disk>(&shapes_[body]);
  const auto* b = std::get_if<Disk>(&shapes_[other]);
  if (!a || !b) return;
  const Vec2 p = centre(cell);
  const Exit in_a = circle_exit(p, e, a->centre, a->radius), in_b = circle_exit(p + 2.0 * e, -e, b->centre, b->radius);
  const double gap = std::max(2.0 - in_a.length - in_b.length, smallest_gap);
  if (gap > 1.0) return;  // wider than a cell: the two links resolve it themselves
  const PairConductance integral = channel(p, e, 2.0, a->centre, a->radius, b->centre, b->radius);
  const double factor = integral.value * gap;
  cross_gradients.push_back(
      {static_cast<int>(links.size()), other, c.value * (gap * integral.gradient_b - integral.value * in_b.gradient)});
  c.gradient = factor * c.gradient + c.value * (gap * integral.gradient_a - integral.value * in_a.gradient);
  c.value *= factor;
}

void Level::link_sides(const LaplaceProblem& problem) {
  side_links.clear();
  for (int side = 0; side < 4; ++side) {
    const bool vertical = side == left || side == right;
    const bool electrode = problem.sides[side].kind == Side::Kind::electrode;
    const Vec2 e = directions[side];
    for (int k = 0; k < (vertical ? layout.ny : layout.nx); ++k) {
      const Cell cell =
          vertical ? Cell{side == left ? 0 : layout.nx - 1, k} : Cell{k, side == bottom ? 0 : layout.ny - 1};
      const std::ptrdiff_t slot = layout(cell.i, cell.j);
      const int body = cover[slot];
      if (!electrode) {
        if (body < 0) diagonal[slot] -= 1.0;
        continue;
      }
      const double potential = problem.sides[side].potential_at(h * (centre(cell) + 0.5 * e));
      if (body < 0) {
        diagonal[slot] += 1.0;  // half a cell to the wall: conductance 2 in place of 1
        side_links.push_back({slot, -1, side, 2.0, potential, {}});
      } else {
        const PairConductance c = channel_between(shapes_[body], centre(cell), e, 0.5, nullptr);
        side_links.push_back({-1, body, side, c.value, potential, c.gradient_a});
      }
    }
  }
}

}  // namespace lichtenberg::laplace
