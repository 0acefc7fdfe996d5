// Tests of closed curves: polygons, ellipses and splines of straight and circular pieces.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/geometry/closed_curve.hpp"
#include "solvers/geometry/shape.hpp"
#include "tests/message.hpp"

namespace geometry_curves_test {

using namespace lichtenberg;
using doctest::Approx;
using std::numbers::pi;

const std::vector<Vec2> square = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};

std::string refusal(const std::vector<Vec2>& points, double corner_radius = 0) {
  return message_of<InputError>([&] { make_polygon(points, corner_radius, false); });
}

TEST_CASE("polygon: area, perimeter, distances and corners are exact") {
  for (const bool clockwise : {false, true}) {
    std::vector<Vec2> points = square;
    if (clockwise) std::reverse(points.begin(), points.end());
    const ClosedCurve curve = make_polygon(points, 0, false);
    CHECK(curve.area() == Approx(4).epsilon(1e-15));
    CHECK(curve.perimeter() == Approx(8).epsilon(1e-15));
    CHECK(curve.signed_distance({1, 0.5}) == Approx(-0.5).epsilon(1e-15));
    CHECK(curve.signed_distance({5, 6}) == Approx(5).epsilon(1e-15));  // 3, 4, 5 from a corner
    CHECK(gap(Disk{{5, 6}, 2}, Freeform{&curve}) == Approx(3).epsilon(1e-15));
    CHECK(curve.largest_rotation(0.1) == Approx(pi / 2).epsilon(1e-12));
    CHECK(curve.first_crossing({-3, 1}, 0, true).distance == 3);
    CHECK(curve.first_crossing({1, 5}, 1, false).distance == 3);
    CHECK(std::isinf(curve.first_crossing({1, 5}, 1, true).distance));
  }
}

TEST_CASE("rounded polygon: circles of the radius replace the corners") {
  const ClosedCurve curve = make_polygon(square, 0.5, false);
  CHECK(curve.area() == Approx(4 - (4 - pi) * 0.25).epsilon(1e-14));
  CHECK(curve.perimeter() == Approx(4 + pi).epsilon(1e-14));
  CHECK(curve.signed_distance({0, 0}) == Approx(0.5 * (std::sqrt(2) - 1)).epsilon(1e-14));
  // A rotation by length / radius within a short part, of the whole corner within a long one
  CHECK(curve.largest_rotation(0.1) == Approx(0.2).epsilon(0.01));
  CHECK(curve.largest_rotation(1) == Approx(pi / 2).epsilon(1e-12));
  // An L with a reentrant corner, which is filled: 3 - 5 convex corners + 1
  const ClosedCurve bent = make_polygon(std::vector<Vec2>{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 0.2, false);
  CHECK(bent.area() == Approx(3 - 4 * (1 - pi / 4) * 0.04).epsilon(1e-14));
  CHECK(bent.centroid().x == Approx(bent.centroid().y).epsilon(1e-8));
  const ClosedCurve sharp = make_polygon(std::vector<Vec2>{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 0, false);
  CHECK(sharp.centroid().x == Approx(2.5 / 3).epsilon(1e-14));  // (2 x 1 + 1 x 0.5) / 3
  CHECK(bent.covers({1.02, 1.02}));
  CHECK_FALSE(bent.covers({1.1, 1.1}));
}

TEST_CASE("hollow curve: conducts outside, distances change their sign") {
  const ClosedCurve curve = make_polygon(square, 0, true);
  CHECK(curve.signed_distance({1, 0.5}) == Approx(0.5).epsilon(1e-15));
  CHECK(curve.signed_distance({5, 6}) == Approx(-5).epsilon(1e-15));
  CHECK(curve.largest_rotation(0.1) == 0);  // its corners point away from the fluid
  const CurvePiece& piece = curve.pieces()[0];
  const Vec2 middle = 0.5 * (piece.from + piece.to);
  CHECK(dot(outward(piece, middle), Vec2{1, 1} - middle) > 0);
}

TEST_CASE("ellipse: equals its equation, at any angle and ratio") {
  for (const double ratio : {1.0, 0.5, 0.03})
    for (const double angle : {0.0, 0.3, -2.0}) {
      const Vec2 centre{0.3, -0.7};
      const ClosedCurve curve = make_ellipse(centre, {2, 2 * ratio}, angle, false);
      const auto at = [&](double t, double scale) {
        const double x = 2 * scale * std::cos(t), y = 2 * scale * ratio * std::sin(t);
        return centre + Vec2{std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y};
      };
      for (int k = 0; k < 500; ++k) {
        const double t = 0.0123 + k * 2 * pi / 500;
        CHECK(curve.nearest(at(t, 1)).distance < 4e-8);  // 1e-8 of the size
        CHECK(curve.covers(at(t, 0.999)));
        CHECK_FALSE(curve.covers(at(t, 1.001)));
      }
      CHECK(norm(curve.centroid() - centre) < 1e-8);
      CHECK(curve.area() == Approx(4 * pi * ratio).epsilon(1e-8 / ratio));
    }
}

TEST_CASE("circle as an ellipse: pieces have its centre and radius") {
  const ClosedCurve curve = make_ellipse({1, 2}, {0.7, 0.7}, 0, false);
  for (const CurvePiece& piece : curve.pieces()) {
    CHECK(piece.radius == Approx(0.7).epsilon(1e-13));
    CHECK(norm(piece.centre - Vec2{1, 2}) < 1e-13);
  }
  CHECK(curve.area() == Approx(0.49 * pi).epsilon(1e-13));
}

TEST_CASE("spline through points of an ellipse: error of fourth order") {
  const auto error = [](int n) {
    std::vector<Vec2> points;
    for (int k = 0; k < n; ++k) points.push_back({std::cos(2 * pi * k / n), 0.6 * std::sin(2 * pi * k / n)});
    const ClosedCurve curve = make_spline(points, false);
    double worst = 0;
    for (int k = 0; k < 1000; ++k)
      worst = std::max(worst, curve.nearest({std::cos(2 * pi * k / 1000), 0.6 * std::sin(2 * pi * k / 1000)}).distance);
    return worst;
  };
  const double coarse = error(20), fine = error(40);
  CHECK(std::log2(coarse / fine) == Approx(4).epsilon(0.1));
  CHECK(fine < 3e-5);
}

TEST_CASE("polygon of a curve: deviates by the tolerance, with few points") {
  const ClosedCurve curve = make_ellipse({0, 0}, {1, 0.4}, 0.2, false);
  const std::vector<Vec2> points = curve.polygon(1e-3);
  CHECK(points.size() < 100);
  for (std::size_t k = 0; k < points.size(); ++k) {
    CHECK(curve.nearest(points[k]).distance < 1e-12);
    CHECK(curve.nearest(0.5 * (points[k] + points[(k + 1) % points.size()])).distance < 2e-3);
  }
}

TEST_CASE("thickness: thin parts of a conductor are found, corners are not") {
  const ClosedCurve plate = make_polygon(std::vector<Vec2>{{0, 0}, {8, 6}, {7.4, 6.8}, {-0.6, 0.8}}, 0, false);
  CHECK(plate.thin_parts(0.9).all < 4.4);  // 1 m thick and 10 m long, oblique
  CHECK(plate.thin_parts(1.1).longest > 10);
  CHECK(plate.thin_parts(1.1).all > 20);
  const ClosedCurve needle = make_polygon(std::vector<Vec2>{{0, 0}, {2, 0}, {2, 2}, {9, 1}, {2, 3}, {0, 3}}, 0, false);
  CHECK(needle.thin_parts(0.3).longest > 3);
  CHECK(make_polygon(square, 0, false).thin_parts(1).all == 0);
  for (const double thickness : {1e-5, 1e-7, 2e-8}) {
    CAPTURE(thickness);
    const std::vector<Vec2> foil = {{0, 0}, {8, 0}, {8, thickness}, {0, thickness}};
    CHECK(make_polygon(foil, 0, false).thin_parts(0.3).all > 15.9);
    CHECK(make_polygon(foil, 0, true).thin_parts(0.3).all > 15.9);
  }
}

TEST_CASE("polygon: open, crossed, folded and overlapping corners are refused") {
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(has(refusal({{0, 0}, {1, 0}}), "is open: it has 2 points"));
  CHECK(has(refusal({{0, 0}, {1, 0}, {0, 1}, {1, 1}}), "crosses itself: the side from point 2 to 3"));
  CHECK(has(refusal({{0, 0}, {1, 0}, {0.5, 0}, {0.5, 1}}), "folds back on itself at point 2"));
  CHECK(has(refusal({{0, 0}, {1, 0}, {2, 0}}), "folds back"));
  CHECK(has(refusal({{0, 0}, {1, 0}, {1, 1}, {0, 0}}), "has equal points 4 and 1"));
  CHECK(has(refusal({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}}), "crosses itself"));  // touches a side
  CHECK(has(refusal(square, 1.1), "too short for its rounded corners"));
  CHECK(refusal(square, 1).empty());
  CHECK_THROWS_AS(make_spline(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}, {1, 1}}, false), InputError);
}

}  // namespace geometry_curves_test
