#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Straight or circular piece of a closed curve. It runs from `from` to `to` (m), with the conductor on its left, and
/// is monotone in x and in y.
struct CurvePiece {
  Vec2 from, to;
  Vec2 centre;  ///< Centre (m) of the circle of a circular piece
  /// Radius (m) of a circular piece: positive if the conductor is inside the circle, negative if it is outside. 0: a
  /// straight piece.
  double radius = 0;
};

/// Returns the length (m) of a piece.
double length(const CurvePiece& piece);
/// Returns the angle (rad) by which a piece rotates its direction to the left, negative to the right.
double rotation(const CurvePiece& piece);
/// Returns the unit vector out of the conductor at a point of the piece.
Vec2 outward(const CurvePiece& piece, Vec2 at);

/// Surface of a conductor of the plane: a closed curve of straight and circular pieces that does not cross itself. The
/// conductor is inside the curve or, if `hollow`, outside. All lengths are in m. Queries take a time proportional to
/// the logarithm of the number of pieces.
class ClosedCurve {
 public:
  /// Makes a curve from its pieces, each of which starts where the one before ends, the first where the last ends. They
  /// run counterclockwise, with the conductor on their left. `hollow`: the conductor is outside instead, and the
  /// constructor reverses the curve.
  explicit ClosedCurve(std::vector<CurvePiece> pieces, bool hollow = false);

  /// Point of the curve with its piece, or a crossing with a line.
  struct Point {
    Vec2 at;
    double distance = 0;  ///< Distance from the point in question (m), infinite if there is none
    int piece = -1;
  };

  std::span<const CurvePiece> pieces() const { return pieces_; }
  bool hollow() const { return hollow_; }
  Vec2 low() const { return nodes_[0].low; }    ///< Lower left corner of the bounding rectangle
  Vec2 high() const { return nodes_[0].high; }  ///< Upper right corner of the bounding rectangle
  double perimeter() const { return perimeter_; }
  Vec2 centroid() const { return centroid_; }  ///< Centroid of the area inside the curve
  double area() const { return area_; }        ///< Area inside the curve (m^2), also of a hollow conductor

  /// Returns true if the conductor covers p.
  bool covers(Vec2 p) const;
  /// Returns the nearest point of the curve and its distance (m).
  Point nearest(Vec2 p) const;
  /// Returns the distance (m) of p from the curve, negative inside the conductor.
  double signed_distance(Vec2 p) const { return covers(p) ? -nearest(p).distance : nearest(p).distance; }
  /// Returns the first crossing of the curve with the ray from p along an axis (0: x, 1: y), in the positive or
  /// negative direction. `slack`: length (m) by which the crossing may be behind p, for a p that rounding placed on the
  /// wrong side.
  Point first_crossing(Vec2 p, int axis, bool positive, double slack = 0) const;
  /// Writes the sorted x (m) of all crossings with the line of this y into `x`.
  void crossings(double y, std::vector<double>& x) const;

  /// Returns the largest angle (rad) by which the direction of the surface rotates around the conductor within a part
  /// of this length (m), at most pi. It is the exterior angle of a corner, or length / radius of a wide arc.
  double largest_rotation(double length) const;
  /// Length (m) of the parts of the surface where the conductor is thin: the longest connected part, and all parts.
  struct ThinParts {
    double longest = 0, all = 0;
  };
  /// Finds the parts of the surface where the conductor (or the opening, if the conductor is hollow) is thinner than
  /// `width` (m). The thickness is measured across the surface.
  ThinParts thin_parts(double width) const;
  /// Returns points of the curve with straight lines between them that deviate by at most `tolerance` (m).
  std::vector<Vec2> polygon(double tolerance) const;

 private:
  /// Bounding rectangle of the pieces `first` to `end`, in a binary tree. The first half of them is the next node.
  struct Node {
    Vec2 low, high;
    int first = 0, end = 0, second_half = 0;
  };
  int add_node(int first, int end);
  void search(int node, Vec2 p, Point& best) const;
  template <class Visit>
  void for_crossings(int axis, double at, const Visit& visit) const;

  std::vector<CurvePiece> pieces_;
  bool hollow_;
  std::vector<Node> nodes_;
  double perimeter_ = 0, area_ = 0;
  Vec2 centroid_;
};

/// Makes a polygon from its corners (m), in either direction; the last corner is joined to the first. Corners are
/// rounded by circles of `corner_radius` (m) if it is positive. Throws InputError if it is
/// open (fewer than three corners), crosses or touches itself, or if a side has no length or is too short for the
/// circles. The message continues "the polygon".
ClosedCurve make_polygon(std::span<const Vec2> corners, double corner_radius, bool hollow);

/// Makes an ellipse with two semi-axes (m), of which the first is at an `angle` (rad) from x. Circular pieces
/// deviate from it by at most 1e-8 of its size.
ClosedCurve make_ellipse(Vec2 centre, Vec2 semi_axes, double angle, bool hollow);

/// Makes a smooth curve through the points (m): a periodic cubic spline over the lengths of the chords. Circular pieces
/// deviate from it by at most 1e-8 of its size. Throws InputError as make_polygon does.
ClosedCurve make_spline(std::span<const Vec2> points, bool hollow);

}  // namespace lichtenberg
