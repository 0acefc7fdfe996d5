// Polygons, ellipses and splines as closed curves of straight and circular pieces.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/geometry/closed_curve.hpp"

namespace lichtenberg {
namespace {

using std::numbers::pi;

/// Largest deviation of circular pieces from a smooth curve, relative to its size. At 1000 cells it is 1e-5 cell.
constexpr double biarc_tolerance = 1e-8;

/// Sagitta below which an arc counts as straight, relative to the curve's size. Circles of larger radius would lose
/// digits.
constexpr double straight = 1e-10;

Vec2 rotated(Vec2 a, double angle) {
  return {std::cos(angle) * a.x - std::sin(angle) * a.y, std::sin(angle) * a.x + std::cos(angle) * a.y};
}

/// Adds an arc from `from` to `to` around `centre`, divided where its tangent is along an axis, so that its parts are
/// monotone. `radius` is negative for an arc to the right.
void add_arc(Vec2 from, Vec2 to, Vec2 centre, double radius, std::vector<CurvePiece>& pieces) {
  const Vec2 a = from - centre, b = to - centre;
  const double start = std::atan2(a.y, a.x), sweep = std::atan2(cross(a, b), dot(a, b)), size = std::abs(radius);
  constexpr double least = 1e-9;  // rad; a shorter part is monotone to rounding
  const int sign = sweep > 0 ? 1 : -1;
  Vec2 last = from;
  int quarter = static_cast<int>(sign > 0 ? std::floor(start / (pi / 2)) + 1 : std::ceil(start / (pi / 2)) - 1);
  for (; sign * (quarter * pi / 2 - start) < sign * sweep - least; quarter += sign) {
    if (sign * (quarter * pi / 2 - start) < least) continue;
    const int direction_index = ((quarter % 4) + 4) % 4;
    const Vec2 direction{static_cast<double>((direction_index == 0) - (direction_index == 2)),
                         static_cast<double>((direction_index == 1) - (direction_index == 3))};
    const Vec2 cut = centre + size * direction;
    pieces.push_back({last, cut, centre, radius});
    last = cut;
  }
  pieces.push_back({last, to, centre, radius});
}

/// Adds the arc that starts at `from` in the direction `tangent` and ends at `to`. `size`: size of the whole curve.
void add_tangent_arc(Vec2 from, Vec2 tangent, Vec2 to, double size, std::vector<CurvePiece>& pieces) {
  const Vec2 chord = to - from;
  if (norm2(chord) == 0) return;
  const double curvature = 2 * cross(tangent, chord) / norm2(chord);
  if (std::abs(curvature) * norm2(chord) / 8 < straight * size) {
    pieces.push_back({from, to, {}, 0});
    return;
  }
  add_arc(from, to, from + perpendicular(tangent) / curvature, 1 / curvature, pieces);
}

/// Smooth curve with a parameter: points (m) and unit tangents.
struct SmoothCurve {
  std::function<Vec2(double)> point, tangent;
  double size;
};

/// Returns the distance of p from the line or circle of the nearest of some pieces.
double deviation(std::span<const CurvePiece> pieces, Vec2 p) {
  double least = INFINITY;
  for (const CurvePiece& piece : pieces)
    least = std::min(least, piece.radius == 0 ? std::abs(dot(outward(piece, p), p - piece.from))
                                              : std::abs(norm(p - piece.centre) - std::abs(piece.radius)));
  return least;
}

/// Adds pairs of arcs with a common tangent (biarcs) for the parameters from a to b, and halves the interval until they
/// deviate little (Bolton 1975). The two arcs of a pair meet halfway between the points at the distance d along the
/// tangents t from the ends, with |v - d (t_a + t_b)| = 2 d. v is the vector between the ends.
void add_biarcs(const SmoothCurve& curve, double a, double b, int depth, std::vector<CurvePiece>& pieces) {
  const Vec2 from = curve.point(a), to = curve.point(b), at_from = curve.tangent(a), at_to = curve.tangent(b);
  const Vec2 v = to - from, sum = at_from + at_to;
  const double along = dot(v, sum), difference2 = norm2(at_from - at_to);  // 2 (1 - t_a.t_b)
  const double d = norm2(v) / (along + std::sqrt(along * along + difference2 * norm2(v)));
  const Vec2 middle = 0.5 * (from + to + d * (at_from - at_to));
  const std::size_t before = pieces.size();
  if (along > 0 && dot(at_from, at_to) > 0) {
    add_tangent_arc(from, at_from, middle, curve.size, pieces);
    const std::size_t second = pieces.size();
    add_tangent_arc(to, -at_to, middle, curve.size, pieces);  // backwards from the end
    std::reverse(pieces.begin() + static_cast<std::ptrdiff_t>(second), pieces.end());
    for (std::size_t k = second; k < pieces.size(); ++k) {
      std::swap(pieces[k].from, pieces[k].to);
      pieces[k].radius = -pieces[k].radius;
    }
    double worst = 0;
    for (const double share : {0.2, 0.35, 0.65, 0.8})
      worst = std::max(worst, deviation(std::span(pieces).subspan(before), curve.point(a + share * (b - a))));
    if (worst < biarc_tolerance * curve.size) return;
  }
  constexpr int deepest = 24;
  if (depth == deepest) {  // a cusp
    pieces.resize(before);
    if (from != to) pieces.push_back({from, to, {}, 0});
    return;
  }
  pieces.resize(before);
  add_biarcs(curve, a, 0.5 * (a + b), depth + 1, pieces);
  add_biarcs(curve, 0.5 * (a + b), b, depth + 1, pieces);
}

bool cross_each_other(const CurvePiece& a, const CurvePiece& b) {
  const auto side = [](const CurvePiece& line, Vec2 p) { return cross(line.to - line.from, p - line.from); };
  const auto between = [](const CurvePiece& line, Vec2 p) { return dot(p - line.from, p - line.to) <= 0; };
  const double a_from = side(b, a.from), a_to = side(b, a.to), b_from = side(a, b.from), b_to = side(a, b.to);
  if ((a_from > 0) != (a_to > 0) && (b_from > 0) != (b_to > 0) && a_from != 0 && a_to != 0 && b_from != 0 && b_to != 0)
    return true;
  return (a_from == 0 && between(b, a.from)) || (a_to == 0 && between(b, a.to)) ||
         (b_from == 0 && between(a, b.from)) || (b_to == 0 && between(a, b.to));
}

/// Finds two pieces that are not neighbours and whose chords meet, by a sweep along x.
std::optional<std::pair<int, int>> find_crossing(std::span<const CurvePiece> pieces) {
  const int n = static_cast<int>(pieces.size());
  const auto low = [&](int k) { return std::min(pieces[k].from.x, pieces[k].to.x); };
  const auto high = [&](int k) { return std::max(pieces[k].from.x, pieces[k].to.x); };
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, low);
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n && low(order[j]) <= high(order[i]); ++j) {
      const int a = std::min(order[i], order[j]), b = std::max(order[i], order[j]);
      if (b - a != 1 && b - a != n - 1 && cross_each_other(pieces[a], pieces[b])) return std::pair{a, b};
    }
  return std::nullopt;
}

double size_of(std::span<const Vec2> points) {
  Vec2 low = points[0], high = points[0];
  for (const Vec2 p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  return std::max(high.x - low.x, high.y - low.y);
}

double enclosed_area(std::span<const Vec2> points) {
  double area = 0;
  for (std::size_t k = 0; k < points.size(); ++k)
    area += 0.5 * cross(points[k] - points[0], points[(k + 1) % points.size()] - points[0]);
  return area;
}

std::string side_text(std::size_t k, std::size_t n) {
  return "the side from point " + std::to_string(k + 1) + " to " + std::to_string((k + 1) % n + 1);
}

/// Checks the points of a polygon or a spline.
void check_points(std::span<const Vec2> points) {
  constexpr std::size_t most = 10000;
  const std::size_t n = points.size();
  if (n < 3) throw InputError("is open: it has " + std::to_string(n) + " points and needs at least 3");
  if (n > most)
    throw InputError("has " + std::to_string(n) + " points: at most " + std::to_string(most) + " are allowed");
  const double size = size_of(points);
  for (std::size_t k = 0; k < n; ++k)
    if (!(norm(points[(k + 1) % n] - points[k]) > 1e-9 * size))
      throw InputError("has equal points " + std::to_string(k + 1) + " and " + std::to_string((k + 1) % n + 1) +
                       ": neighbours must differ, and the last point is joined to the first without repeating it");
}

std::vector<Vec2> counterclockwise(std::span<const Vec2> points) {
  const double size = size_of(points);
  if (!(std::abs(enclosed_area(points)) > 1e-12 * size * size))
    throw InputError("encloses no area: its points must not lie on one line");
  std::vector<Vec2> ordered(points.begin(), points.end());
  if (enclosed_area(points) < 0) std::reverse(ordered.begin() + 1, ordered.end());
  return ordered;
}

void check_sides(std::span<const Vec2> points) {
  const std::size_t n = points.size();
  std::vector<CurvePiece> sides(n);
  for (std::size_t k = 0; k < n; ++k) sides[k] = {points[k], points[(k + 1) % n], {}, 0};
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 a = sides[k].to - sides[k].from, b = sides[(k + 1) % n].to - sides[(k + 1) % n].from;
    if (dot(a, b) < 0 && std::abs(cross(a, b)) <= 1e-9 * norm(a) * norm(b))
      throw InputError("folds back on itself at point " + std::to_string((k + 1) % n + 1) +
                       ": it must not cross or touch itself");
  }
  if (const auto found = find_crossing(sides))
    throw InputError("crosses itself: " + side_text(found->first, n) + " meets " + side_text(found->second, n));
}

/// Corner of a polygon: ends of its circle on the two sides, and their distance from the corner (m).
struct Corner {
  Vec2 from, to, centre;
  double radius = 0, distance = 0;
};

Corner round_corner(Vec2 before, Vec2 at, Vec2 after, double radius) {
  const Vec2 in = (at - before) / norm(at - before), out = (after - at) / norm(after - at);
  const double angle = std::atan2(cross(in, out), dot(in, out));
  if (radius == 0 || std::abs(angle) < 1e-9) return {at, at, at};
  const double distance = radius * std::tan(0.5 * std::abs(angle)), signed_radius = angle > 0 ? radius : -radius;
  const Vec2 from = at - distance * in;
  return {from, at + distance * out, from + signed_radius * perpendicular(in), signed_radius, distance};
}

/// Periodic cubic spline over the lengths of the chords.
class Spline {
 public:
  explicit Spline(std::vector<Vec2> points) : point_(std::move(points)), slope_(point_.size()), chord_(point_.size()) {
    const std::size_t n = point_.size();
    for (std::size_t k = 0; k < n; ++k) chord_[k] = norm(point_[(k + 1) % n] - point_[k]);
    // Continuous second derivatives: a periodic system with a dominant diagonal. Each sweep of Gauss and Seidel reduces
    // the error by at least a factor of two.
    for (int sweep = 0; sweep < 60; ++sweep)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t before = (k + n - 1) % n, after = (k + 1) % n;
        const double left = chord_[before], right = chord_[k];
        const Vec2 mean = (right / left) * (point_[k] - point_[before]) + (left / right) * (point_[after] - point_[k]);
        slope_[k] = (3.0 * mean - right * slope_[before] - left * slope_[after]) / (2 * (left + right));
      }
  }
  Vec2 point(std::size_t k, double t) const {
    const auto [a, b, m, n] = ends(k);
    const double u = 1 - t;
    return u * u * (1 + 2 * t) * a + t * t * (3 - 2 * t) * b + t * u * u * m - t * t * u * n;
  }
  Vec2 tangent(std::size_t k, double t) const {
    const auto [a, b, m, n] = ends(k);
    const Vec2 rate = 6 * t * (1 - t) * (b - a) + (1 - t) * (1 - 3 * t) * m + t * (3 * t - 2) * n;
    return rate / std::max(norm(rate), 1e-300);
  }

 private:
  struct Ends {
    Vec2 a, b, slope_a, slope_b;
  };
  Ends ends(std::size_t k) const {
    const std::size_t next = (k + 1) % point_.size();
    return {point_[k], point_[next], chord_[k] * slope_[k], chord_[k] * slope_[next]};
  }
  std::vector<Vec2> point_, slope_;
  std::vector<double> chord_;
};

}  // namespace

ClosedCurve make_polygon(std::span<const Vec2> corners, double corner_radius, bool hollow) {
  check_points(corners);
  check_sides(corners);
  const std::vector<Vec2> points = counterclockwise(corners);
  const std::size_t n = points.size();
  std::vector<Corner> rounded;
  for (std::size_t k = 0; k < n; ++k)
    rounded.push_back(round_corner(points[(k + n - 1) % n], points[k], points[(k + 1) % n], corner_radius));
  std::vector<CurvePiece> pieces;
  for (std::size_t k = 0; k < n; ++k) {
    const Corner &corner = rounded[k], &next = rounded[(k + 1) % n];
    if (corner.radius != 0) add_arc(corner.from, corner.to, corner.centre, corner.radius, pieces);
    const double side = norm(points[(k + 1) % n] - points[k]), rest = side - corner.distance - next.distance;
    if (rest < -1e-9 * side)
      throw InputError("has a side of " + std::to_string(side) +
                       " m that is too short for its rounded corners, which take " +
                       std::to_string(corner.distance + next.distance) + " m of it");
    if (rest > 1e-9 * side)
      pieces.push_back({corner.to, next.from, {}, 0});
    else if (k + 1 < n)
      rounded[k + 1].from = corner.to;
    else
      pieces.front().from = corner.to;
  }
  if (corner_radius > 0)
    if (find_crossing(pieces)) throw InputError("crosses itself at a rounded corner: the corners' radius is too large");
  return ClosedCurve(std::move(pieces), hollow);
}

ClosedCurve make_ellipse(Vec2 centre, Vec2 semi_axes, double angle, bool hollow) {
  const auto point = [&](double t) {
    return centre + rotated({semi_axes.x * std::cos(t), semi_axes.y * std::sin(t)}, angle);
  };
  const auto tangent = [&](double t) {
    const Vec2 rate{-semi_axes.x * std::sin(t), semi_axes.y * std::cos(t)};
    return rotated(rate / norm(rate), angle);
  };
  const SmoothCurve curve{point, tangent, 2 * std::max(semi_axes.x, semi_axes.y)};
  std::vector<CurvePiece> pieces;
  for (int quarter = 0; quarter < 4; ++quarter) add_biarcs(curve, quarter * pi / 2, (quarter + 1) * pi / 2, 0, pieces);
  pieces.back().to = pieces.front().from;
  return ClosedCurve(std::move(pieces), hollow);
}

ClosedCurve make_spline(std::span<const Vec2> points, bool hollow) {
  check_points(points);
  const Spline spline(counterclockwise(points));
  std::vector<CurvePiece> pieces;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const SmoothCurve curve{[&](double t) { return spline.point(k, t); },
                            [&](double t) { return spline.tangent(k, t); }, size_of(points)};
    add_biarcs(curve, 0, 1, 0, pieces);
  }
  if (find_crossing(pieces)) throw InputError("crosses itself: it must not, also between its points");
  return ClosedCurve(std::move(pieces), hollow);
}

}  // namespace lichtenberg
