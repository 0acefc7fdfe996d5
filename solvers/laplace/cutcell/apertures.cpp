#include "solvers/laplace/cutcell/apertures.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/geometry/circle_cell.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"

namespace lichtenberg::laplace {

namespace {

/// Lower bound of the distance from a cell's centre to a surface (cells). If the centre is close to the surface, this
/// distance is no measure of the distance of the cell's fluid.
constexpr double least_distance = 0.25;

/// Open fraction of a face below which the face is closed: the rounding error in single precision.
constexpr float rounding = 1e-6f;

/// Surface of a round body in units of cells.
struct Round {
  Disk circle;
  bool fluid_inside;

  /// Returns the range of cells of an nx x ny grid of which the body may cover a part or a face.
  CellRange around(int nx, int ny) const {
    if (fluid_inside) return {0, nx - 1, 0, ny - 1};
    const Vec2 low = circle.centre - Vec2{circle.radius + 1, circle.radius + 1};
    const Vec2 high = circle.centre + Vec2{circle.radius + 1, circle.radius + 1};
    return {cell_at(low.x, nx), cell_at(high.x, nx), cell_at(low.y, ny), cell_at(high.y, ny)};
  }
  /// Returns the length of the face from a to b that the body covers (cells).
  double covers(Vec2 a, Vec2 b) const {
    const double inside = length_inside(circle, a, b);
    return fluid_inside ? 1.0 - inside : inside;
  }
  double distance(Vec2 p) const { return (fluid_inside ? -1.0 : 1.0) * (norm(p - circle.centre) - circle.radius); }
};

template <class Work>
void for_cells(const Round& body, int nx, int ny, const Work& work) {
  const CellRange range = body.around(nx, ny);
  for (int j = range.from_j; j <= range.to_j; ++j)
    for (int i = range.from_i; i <= range.to_i; ++i) work(i, j);
}

std::vector<Round> round_bodies(const LaplaceProblem& problem, double h) {
  std::vector<Round> bodies;
  for (const Body& body : problem.bodies) {
    const Outline outline = outline_in_cells(body.shape, h);
    if (!outline.round())
      throw InputError(
          "field.boundary_stencil = \"aperture\" is for round conductors and electrodes: a bar, polygon, ellipse or "
          "curve "
          "needs another formula");
    bodies.push_back({{outline.centre, outline.size}, outline.kind == Outline::Kind::ring});
  }
  return bodies;
}

/// Open fractions of all cells' faces, the parts outside all bodies.
class Faces {
 public:
  Faces(const std::vector<Round>& bodies, int nx, int ny)
      : nx_(nx), ny_(ny), upright_((nx + 1) * ny, 1.0f), level_(nx * (ny + 1), 1.0f) {
    for (const Round& body : bodies)
      for_cells(body, nx, ny, [&](int i, int j) {
        const Vec2 corner{static_cast<double>(i), static_cast<double>(j)};
        close(open(i, j, left), body.covers(corner, corner + Vec2{0, 1}));
        close(open(i, j, bottom), body.covers(corner, corner + Vec2{1, 0}));
        if (i == nx - 1) close(open(i, j, right), body.covers(corner + Vec2{1, 0}, corner + Vec2{1, 1}));
        if (j == ny - 1) close(open(i, j, top), body.covers(corner + Vec2{0, 1}, corner + Vec2{1, 1}));
      });
  }

  /// Returns the open fraction of a face of cell (i, j), from 0 to 1, in single precision as in the Level.
  float& open(int i, int j, int side) {
    if (side == left || side == right) return upright_[j * (nx_ + 1) + i + (side == right)];
    return level_[(j + (side == top)) * nx_ + i];
  }
  double all(int i, int j) {
    double sum = 0;
    for (const int side : {left, right, bottom, top}) sum += open(i, j, side);
    return sum;
  }

 private:
  static void close(float& open, double covered) {
    open -= static_cast<float>(covered);
    if (open < rounding) open = 0;
  }
  int nx_, ny_;
  std::vector<float> upright_, level_;
};

/// Assigns cells without an open face to the body that their centre lies in, the first one where bodies overlap.
void cover_cells(const std::vector<Round>& bodies, Faces& faces, Level& level) {
  const Layout& at = level.layout;
  std::fill(level.owner.begin(), level.owner.end(), CellOwner());
  level.covered.clear();
  level.covered_start.assign(1, 0);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    for_cells(bodies[body], at.nx, at.ny, [&](int i, int j) {
      const std::ptrdiff_t slot = at(i, j);
      if (faces.all(i, j) > 0 || bodies[body].distance(cell_centre(i, j)) > 0 || !level.owner[slot].is_fluid()) return;
      level.owner[slot] = CellOwner::by(static_cast<int>(body));
      level.covered.push_back(slot);
    });
    level.covered_start.push_back(static_cast<int>(level.covered.size()));
  }
  level.fluid_cells = static_cast<long>(at.nx) * at.ny - static_cast<long>(level.covered.size());
}

void link_cells(Faces& faces, Level& level) {
  const Layout& at = level.layout;
  level.faces.east.assign(at.size(), 0.0f);
  level.faces.north.assign(at.size(), 0.0f);
  for (int j = 0; j < at.ny; ++j)
    for (int i = 0; i < at.nx; ++i) {
      const std::ptrdiff_t slot = at(i, j);
      level.diagonal[slot] = faces.all(i, j);
      if (i + 1 < at.nx) level.faces.east[slot] = faces.open(i, j, right);
      if (j + 1 < at.ny) level.faces.north[slot] = faces.open(i, j, top);
    }
}

/// Computes the links between cells and bodies: surface length in the cell / distance of the cell's centre. Returns the
/// row of each link.
std::vector<int> link_bodies(const std::vector<Round>& bodies, Level& level) {
  std::vector<int> row;
  level.links.clear();
  level.cross_gradients.clear();
  level.pairs.clear();
  level.link_start.assign(1, 0);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    for_cells(bodies[body], level.layout.nx, level.layout.ny, [&](int i, int j) {
      const std::ptrdiff_t slot = level.layout(i, j);
      if (!level.owner[slot].is_fluid()) return;
      const Vec2 corner{static_cast<double>(i), static_cast<double>(j)};
      const Arc arc = arc_inside(bodies[body].circle, corner, corner + Vec2{1, 1});
      if (arc.length == 0) return;
      const double distance = std::max(std::abs(bodies[body].distance(cell_centre(i, j))), least_distance);
      const double outward = bodies[body].fluid_inside ? -1 : 1;
      // Not the derivative of the conductance, which is meaningless here: this value gives the pressure
      // eps/2 (dV/dn)^2 on the arc as the link's force.
      const Vec2 gradient = (outward / (distance * distance)) * arc.normal;
      level.links.push_back({slot, static_cast<int>(body), arc.length / distance, gradient});
      level.diagonal[slot] += arc.length / distance;
      row.push_back(j);
    });
    level.link_start.push_back(static_cast<int>(level.links.size()));
  }
  return row;
}

void link_sides(const LaplaceProblem& problem, Faces& faces, Level& level) {
  level.side_links.clear();
  const Layout& at = level.layout;
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < faces_of(at, side); ++k) {
      const auto [i, j] = cell_at_face(at, side, k);
      const double open = faces.open(i, j, side);
      if (open == 0) continue;
      if (problem.sides[side].kind == Side::Kind::insulating) {
        level.diagonal[at(i, j)] -= open;
        continue;
      }
      level.diagonal[at(i, j)] += open;  // half a cell to the wall: conductance 2 instead of 1
      const double potential = problem.sides[side].potential_at(level.h * (cell_centre(i, j) + 0.5 * direction(side)));
      level.side_links.push_back({at(i, j), -1, side, 2.0 * open, potential, {}});
    }
  }
}

}  // namespace

void build_by_apertures(const LaplaceProblem& problem, Level& level) {
  const std::vector<Round> bodies = round_bodies(problem, level.h);
  Faces faces(bodies, level.layout.nx, level.layout.ny);
  cover_cells(bodies, faces, level);
  link_cells(faces, level);
  sort_links_by_row(link_bodies(bodies, level), level, parallel::Team::single());
  link_sides(problem, faces, level);
}

}  // namespace lichtenberg::laplace
