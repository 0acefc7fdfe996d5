#include "solvers/geometry/closed_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/geometry/shape.hpp"

namespace lichtenberg {
namespace {

using std::numbers::pi;

Vec2 lower(Vec2 a, Vec2 b) { return {std::min(a.x, b.x), std::min(a.y, b.y)}; }
Vec2 upper(Vec2 a, Vec2 b) { return {std::max(a.x, b.x), std::max(a.y, b.y)}; }

double distance2(Vec2 low, Vec2 high, Vec2 p) {
  const Vec2 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y})};
  return norm2(out);
}

/// Returns the point of a piece that is nearest to p.
Vec2 nearest_on(const CurvePiece& piece, Vec2 p) {
  if (piece.radius == 0) {
    const Vec2 along = piece.to - piece.from;
    return piece.from + std::clamp(dot(p - piece.from, along) / norm2(along), 0.0, 1.0) * along;
  }
  const Vec2 r = p - piece.centre, a = piece.from - piece.centre, b = piece.to - piece.centre;
  const double sign = piece.radius > 0 ? 1 : -1, distance = norm(r);
  if (distance > 0 && sign * cross(a, r) >= 0 && sign * cross(r, b) >= 0 && dot(r, a + b) > 0)
    return piece.centre + (std::abs(piece.radius) / distance) * r;
  return norm2(p - piece.from) <= norm2(p - piece.to) ? piece.from : piece.to;
}

/// Returns the coordinate of a piece along an axis where its other coordinate is `at`.
double coordinate(const CurvePiece& piece, int axis, double at) {
  const int other = 1 - axis;
  if (piece.radius == 0) {
    const double share = (at - piece.from[other]) / (piece.to[other] - piece.from[other]);
    return piece.from[axis] + share * (piece.to[axis] - piece.from[axis]);
  }
  const double across = at - piece.centre[other];
  const double along = std::sqrt(std::max(piece.radius * piece.radius - across * across, 0.0));
  const double x = piece.centre[axis] + (piece.from[axis] + piece.to[axis] >= 2 * piece.centre[axis] ? along : -along);
  return std::clamp(x, std::min(piece.from[axis], piece.to[axis]), std::max(piece.from[axis], piece.to[axis]));
}

Vec2 direction_at(const CurvePiece& piece, Vec2 at) { return perpendicular(outward(piece, at)); }

/// Returns the angle (rad) from direction a to b, positive to the left.
double angle_between(Vec2 a, Vec2 b) { return std::atan2(cross(a, b), dot(a, b)); }

void reverse(std::vector<CurvePiece>& pieces) {
  std::ranges::reverse(pieces);
  for (CurvePiece& piece : pieces) {
    std::swap(piece.from, piece.to);
    piece.radius = -piece.radius;
  }
}

/// Returns the area between a piece and the lines from the origin to its ends.
double sector(const CurvePiece& piece) {
  const double triangle = 0.5 * cross(piece.from, piece.to), angle = std::abs(rotation(piece));
  const double segment = 0.5 * piece.radius * piece.radius * (angle - std::sin(angle));
  return triangle + (piece.radius > 0 ? segment : -segment);
}

/// Returns the integrals of x^2/2 dy and -y^2/2 dx over a piece, by five Gauss points. Their sums over a closed curve
/// are the integrals of x and y over the area inside.
Vec2 moment(const CurvePiece& piece, Vec2 origin) {
  constexpr double node[3] = {0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weight[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double angle = rotation(piece);
  Vec2 sum;
  for (int k = -2; k <= 2; ++k) {
    const double share = 0.5 + (k < 0 ? -0.5 : 0.5) * node[std::abs(k)], w = 0.5 * weight[std::abs(k)];
    Vec2 p = piece.from + share * (piece.to - piece.from), step = piece.to - piece.from;
    if (piece.radius != 0) {
      const Vec2 r = piece.from - piece.centre, side = perpendicular(r);
      const Vec2 radial = std::cos(share * angle) * r + std::sin(share * angle) * side;
      p = piece.centre + radial;
      step = angle * perpendicular(radial);
    }
    p -= origin;
    sum += w * Vec2{0.5 * p.x * p.x * step.y, -0.5 * p.y * p.y * step.x};
  }
  return sum;
}

/// Part of the surface: its length (m) and the angle (rad) by which its direction rotates.
struct Stretch {
  double length, rotation;
};

/// Divides a curve into stretches of at most `longest`, with corners as stretches without length.
std::vector<Stretch> stretches(std::span<const CurvePiece> pieces, double longest) {
  std::vector<Stretch> all;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const CurvePiece &piece = pieces[k], &next = pieces[(k + 1) % pieces.size()];
    const int parts = std::max(1, static_cast<int>(std::ceil(length(piece) / longest)));
    for (int part = 0; part < parts; ++part) all.push_back({length(piece) / parts, rotation(piece) / parts});
    all.push_back({0, angle_between(direction_at(piece, piece.to), direction_at(next, next.from))});
  }
  return all;
}

}  // namespace

double signed_distance(const Freeform& shape, Vec2 p) { return shape.curve->signed_distance(p); }

double length(const CurvePiece& piece) {
  return piece.radius == 0 ? norm(piece.to - piece.from) : std::abs(piece.radius * rotation(piece));
}

double rotation(const CurvePiece& piece) {
  return piece.radius == 0 ? 0 : angle_between(piece.from - piece.centre, piece.to - piece.centre);
}

Vec2 outward(const CurvePiece& piece, Vec2 at) {
  if (piece.radius == 0) return -perpendicular(piece.to - piece.from) / norm(piece.to - piece.from);
  const Vec2 radial = (at - piece.centre) / norm(at - piece.centre);
  return piece.radius > 0 ? radial : -radial;
}

ClosedCurve::ClosedCurve(std::vector<CurvePiece> pieces, bool hollow) : pieces_(std::move(pieces)), hollow_(hollow) {
  for (const CurvePiece& piece : pieces_) {
    perimeter_ += length(piece);
    area_ += sector(piece);
    centroid_ += moment(piece, pieces_[0].from);
  }
  centroid_ = pieces_[0].from + centroid_ / area_;
  if (hollow) reverse(pieces_);
  nodes_.reserve(2 * pieces_.size());
  add_node(0, static_cast<int>(pieces_.size()));
}

int ClosedCurve::add_node(int first, int end) {
  const int node = static_cast<int>(nodes_.size());
  nodes_.push_back({pieces_[first].from, pieces_[first].from, first, end, 0});
  for (int k = first; k < end; ++k) {
    nodes_[node].low = lower(nodes_[node].low, lower(pieces_[k].from, pieces_[k].to));
    nodes_[node].high = upper(nodes_[node].high, upper(pieces_[k].from, pieces_[k].to));
  }
  constexpr int leaf = 4;
  if (end - first <= leaf) return node;
  add_node(first, (first + end) / 2);
  const int second_half = add_node((first + end) / 2, end);
  nodes_[node].second_half = second_half;
  return node;
}

/// Calls visit(coordinate along the axis, index of the piece) for each crossing with the line where the other
/// coordinate is `at`. Of the ends of a piece only the lower one belongs to it, so that a line through a common end of
/// two pieces crosses once or passes by.
template <class Visit>
void ClosedCurve::for_crossings(int axis, double at, const Visit& visit) const {
  const int other = 1 - axis;
  int stack[64] = {0}, depth = 1;
  while (depth > 0) {
    const int k = stack[--depth];
    const Node& node = nodes_[k];
    if (at < node.low[other] || at >= node.high[other]) continue;
    if (node.second_half > 0) {
      stack[depth++] = node.second_half;
      stack[depth++] = k + 1;
      continue;
    }
    for (int n = node.first; n < node.end; ++n) {
      const CurvePiece& piece = pieces_[n];
      if ((at >= piece.from[other]) != (at >= piece.to[other])) visit(coordinate(piece, axis, at), n);
    }
  }
}

bool ClosedCurve::covers(Vec2 p) const {
  bool inside = false;
  for_crossings(0, p.y, [&](double x, int) { inside ^= x > p.x; });
  return inside != hollow_;
}

void ClosedCurve::crossings(double y, std::vector<double>& x) const {
  x.clear();
  for_crossings(0, y, [&](double at, int) { x.push_back(at); });
  std::ranges::sort(x);
}

ClosedCurve::Point ClosedCurve::first_crossing(Vec2 p, int axis, bool positive, double slack) const {
  Point first{p, std::numeric_limits<double>::infinity()};
  for_crossings(axis, p[1 - axis], [&](double at, int piece) {
    const double along = positive ? at - p[axis] : p[axis] - at;
    if (along < -slack || along >= first.distance) return;
    first.distance = along;
    first.piece = piece;
  });
  if (first.piece >= 0) first.at[axis] += positive ? first.distance : -first.distance;
  return first;
}

void ClosedCurve::search(int k, Vec2 p, Point& best) const {
  const Node& node = nodes_[k];
  if (node.second_half == 0) {
    for (int n = node.first; n < node.end; ++n) {
      const Vec2 at = nearest_on(pieces_[n], p);
      if (norm2(p - at) < best.distance) best = {at, norm2(p - at), n};
    }
    return;
  }
  int near = k + 1, far = node.second_half;
  double to_near = distance2(nodes_[near].low, nodes_[near].high, p);
  double to_far = distance2(nodes_[far].low, nodes_[far].high, p);
  if (to_far < to_near) {
    std::swap(near, far);
    std::swap(to_near, to_far);
  }
  if (to_near < best.distance) search(near, p, best);
  if (to_far < best.distance) search(far, p, best);
}

ClosedCurve::Point ClosedCurve::nearest(Vec2 p) const {
  Point best{p, std::numeric_limits<double>::infinity()};
  search(0, p, best);  // compares squares of distances
  best.distance = norm(p - best.at);
  return best;
}

double ClosedCurve::largest_rotation(double length) const {
  const std::vector<Stretch> all = stretches(pieces_, length / 8);
  const std::size_t n = all.size();
  double largest = 0, rotated_by = 0, along = 0;
  std::size_t first = 0;
  for (std::size_t last = 0; last < 2 * n; ++last) {
    rotated_by += all[last % n].rotation;
    along += all[last % n].length;
    while (along > length * (1 + 1e-9) && first < last) {
      rotated_by -= all[first % n].rotation;
      along -= all[first++ % n].length;
    }
    largest = std::max(largest, rotated_by);
  }
  return std::min(largest, pi);
}

ClosedCurve::ThinParts ClosedCurve::thin_parts(double width) const {
  struct Sample {
    double length;
    bool below_width;
  };
  std::vector<Sample> samples;
  for (const CurvePiece& piece : pieces_) {
    const int parts = std::max(1, static_cast<int>(std::ceil(4 * length(piece) / width)));
    for (int part = 0; part < parts; ++part) {
      const double share = (part + 0.5) / parts;
      const Vec2 at = nearest_on(piece, piece.from + share * (piece.to - piece.from));
      const Vec2 normal = outward(piece, at), inward = hollow_ ? normal : -normal;
      // The chord along the axis nearest to the normal, times the cosine of the angle to it
      const int axis = std::abs(inward.x) >= std::abs(inward.y) ? 0 : 1;
      const Vec2 start = at + 1e-6 * width * inward;
      // A start beyond the opposite surface means a thickness below 1e-6 widths.
      const bool is_beyond = covers(start) == hollow_;
      const Point across = is_beyond ? Point{} : first_crossing(start, axis, inward[axis] > 0);
      samples.push_back({length(piece) / parts, is_beyond || across.distance * std::abs(inward[axis]) < width});
    }
  }
  ThinParts thin;
  double run = 0;
  for (const Sample& sample : samples) thin.all += sample.below_width ? sample.length : 0;
  for (std::size_t k = 0; k < 2 * samples.size(); ++k) {
    const Sample& sample = samples[k % samples.size()];
    run = sample.below_width ? run + sample.length : 0;
    thin.longest = std::max(thin.longest, std::min(run, perimeter_));
  }
  return thin;
}

std::vector<Vec2> ClosedCurve::polygon(double tolerance) const {
  std::vector<Vec2> points;
  double along = 0, rotated_by = 0;
  // An arc deviates from its chord by an eighth of its length times its angle.
  const auto add = [&](Vec2 from, double part_length, double part_rotation) {
    along += part_length;
    rotated_by += std::abs(part_rotation);
    if (!points.empty() && along * rotated_by < 8 * tolerance) return;
    points.push_back(from);
    along = part_length;
    rotated_by = std::abs(part_rotation);
  };
  Vec2 direction;
  for (const CurvePiece& piece : pieces_) {
    const double angle = rotation(piece), all = length(piece);
    if (points.empty() || std::abs(angle_between(direction, direction_at(piece, piece.from))) > 1e-6)
      rotated_by = INFINITY;
    direction = direction_at(piece, piece.to);
    const int parts = std::max(1, static_cast<int>(std::ceil(std::sqrt(all * std::abs(angle) / (8 * tolerance)))));
    const Vec2 r = piece.from - piece.centre;
    for (int part = 0; part < parts; ++part) {
      const double a = angle * part / parts;
      add(part == 0 ? piece.from : piece.centre + std::cos(a) * r + std::sin(a) * perpendicular(r), all / parts,
          angle / parts);
    }
  }
  return points;
}

}  // namespace lichtenberg
