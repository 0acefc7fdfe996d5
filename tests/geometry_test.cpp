#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "solvers/geometry/box.hpp"
#include "solvers/geometry/circle_cell.hpp"
#include "solvers/geometry/shape.hpp"
#include "solvers/geometry/vec.hpp"

namespace geometry_test {

using namespace lichtenberg;
using doctest::Approx;

TEST_CASE("Vec2: dot product, cross product, norm and perpendicular") {
  const Vec2 a = {3, 4}, b = {-2, 5};
  CHECK(dot(a, b) == 14);    // -6 + 20
  CHECK(cross(a, b) == 23);  // 15 + 8
  CHECK(norm(a) == 5);       // 3, 4, 5
  CHECK(perpendicular(a) == Vec2{-4, 3});
  CHECK(cross(a, perpendicular(a)) == norm2(a));  // +90 degrees: counterclockwise.
}

TEST_CASE("Vec3: dot product, cross product, norm and linear combination") {
  const Vec3 a = {1, 2, 3}, b = {4, 5, -6};
  CHECK(dot(a, b) == -4);                   // 4 + 10 - 18
  CHECK(cross(a, b) == Vec3{-27, 18, -3});  // -12 - 15, 12 + 6, 5 - 8
  CHECK(norm(Vec3{2, 3, 6}) == 7);          // 4 + 9 + 36 = 49
  CHECK(2.0 * a - b / 2.0 + -a == Vec3{-1, -0.5, 6});
}

TEST_CASE("Box::difference: takes nearest images along periodic axes only") {
  Box<3> box{{10, 10, 10}};
  box.sides[0] = box.sides[1] = box.sides[4] = box.sides[5] = Boundary::periodic;  // x and z
  const Vec3 a = {9.5, 9.5, 0.25}, b = {0.5, 0.5, 9.75};
  CHECK(box.difference(a, b) == Vec3{-1, 9, 0.5});
  CHECK(box.difference(b, a) == Vec3{1, -9, -0.5});
  // 3.5 lengths are rounded to the even number of images.
  CHECK(box.difference({35.5, 0, 0}, {0.5, 0, 0}) == Vec3{5 - 10, 0, 0});
  CHECK(Box<3>{}.difference(a, b) == a - b);
}

TEST_CASE("Box::wrap: points re-enter a periodic box and images are counted") {
  Box<2> box{{4, 8}};
  box.sides.fill(Boundary::periodic);
  const auto wrapped = [&](Vec2 p) {
    Image<2> image{};
    box.wrap(p, image);
    return std::tuple(p, image[0], image[1]);
  };
  CHECK(wrapped({5, 7}) == std::tuple(Vec2{1, 7}, 1, 0));
  CHECK(wrapped({-9, -1}) == std::tuple(Vec2{3, 7}, -3, -1));
  CHECK(wrapped({4, 0}) == std::tuple(Vec2{0, 0}, 1, 0));
  CHECK(wrapped({-1e-30, 0}) == std::tuple(Vec2{0, 0}, 0, 0));  // 4 - 1e-30 is 4, which is outside.
  box.sides[2] = box.sides[3] = Boundary::wall;
  CHECK(wrapped({5, -1}) == std::tuple(Vec2{1, -1}, 1, 0));
}

TEST_CASE("signed_distance to a disk: from its surface, negative inside") {
  const Shape disk = Disk{{1, 2}, 0.5};
  CHECK(signed_distance(disk, {4, 6}) == Approx(4.5));  // 5 from the centre.
  CHECK(signed_distance(disk, {1, 2}) == Approx(-0.5));
}

TEST_CASE("signed_distance to a ring: positive inside its circle, negative outside") {
  const Shape ring = Ring{{0, 0}, 2};
  CHECK(signed_distance(ring, {0, 0.5}) == Approx(1.5));
  CHECK(signed_distance(ring, {3, 0}) == Approx(-1));
}

TEST_CASE("signed_distance to a bar: at side, end and corner; negative inside") {
  // Axis from (0, 0) to (4, 0): the bar covers [0, 4] x [-1, 1].
  const Shape bar = Bar{{0, 0}, {4, 0}, 2};
  CHECK(signed_distance(bar, {2, 3}) == Approx(2));
  CHECK(signed_distance(bar, {-1.5, 0.5}) == Approx(1.5));
  CHECK(signed_distance(bar, {7, 5}) == Approx(5));  // 3, 4, 5 from the corner (4, 1).
  CHECK(signed_distance(bar, {2, 0.25}) == Approx(-0.75));
  CHECK(signed_distance(bar, {3.75, 0}) == Approx(-0.25));
}

TEST_CASE("signed_distance to a bar: a common rotation leaves it unchanged") {
  const double angle = 0.7;
  const auto turned = [&](Vec2 p) {
    return Vec2{std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y};
  };
  const Bar bar{{1, 1}, {5, 1}, 0.5};
  const Bar oblique{turned(bar.from), turned(bar.to), bar.width};
  for (const Vec2 p : {Vec2{3, 4}, Vec2{7, 2}, Vec2{0, 1}, Vec2{3, 1.1}})
    CHECK(signed_distance(oblique, turned(p)) == Approx(signed_distance(bar, p)));
}

TEST_CASE("gap of a disk to a disk, bar or ring: between the surfaces") {
  const Disk disk{{0, 0}, 1};
  CHECK(gap(disk, Disk{{3, 4}, 1.5}) == Approx(2.5));        // 5 - 1 - 1.5
  CHECK(gap(disk, Disk{{0.5, 0}, 1}) == Approx(-1.5));       // An overlap of 1.5.
  CHECK(gap(disk, Bar{{-9, 3}, {9, 3}, 1}) == Approx(1.5));  // The surface is at y = 2.5.
  CHECK(gap(disk, Ring{{0.5, 0}, 4}) == Approx(2.5));        // The rim is at x = 4.5 and -3.5: the nearest is 3.5 - 1.
}

TEST_CASE("circle cut by a rectangle: arc and edge normals sum to zero") {
  // The normals of the arc and of the edges' parts inside the circle sum to zero (divergence theorem). The bound is
  // rounding of about ten operations on numbers of order 3.
  for (int k = 0; k < 200; ++k) {
    const Disk disk{{std::cos(1.7 * k), std::sin(2.9 * k)}, 0.1 + 0.01 * k};
    const Vec2 low{-0.6, -0.5}, high{0.7, 0.9};
    const Arc arc = arc_inside(disk, low, high);
    const double left = length_inside(disk, low, {low.x, high.y}), right = length_inside(disk, {high.x, low.y}, high);
    const double bottom = length_inside(disk, low, {high.x, low.y}), top = length_inside(disk, {low.x, high.y}, high);
    CHECK(std::abs(arc.normal.x + right - left) < 1e-13);
    CHECK(std::abs(arc.normal.y + top - bottom) < 1e-13);
  }
}

TEST_CASE("arc_inside, length_inside: arc and chord lengths inside a rectangle") {
  const double pi = std::numbers::pi;
  const Disk disk{{0, 0}, 2};
  CHECK(arc_inside(disk, {-3, -3}, {3, 3}).length == doctest::Approx(4 * pi).epsilon(1e-15));
  CHECK(arc_inside(disk, {0, 0}, {3, 3}).length == doctest::Approx(pi).epsilon(1e-15));
  CHECK(arc_inside(disk, {1, -3}, {3, 3}).length == doctest::Approx(4 * pi / 3).epsilon(1e-15));  // cos 60 = 1/2
  CHECK(arc_inside(disk, {-1, -1}, {1, 1}).length == 0);
  CHECK(length_inside(disk, {-3, 1}, {3, 1}) == doctest::Approx(2 * std::sqrt(3.0)).epsilon(1e-15));
  CHECK(length_inside(disk, {0, 0}, {0, 1}) == doctest::Approx(1).epsilon(1e-15));
  CHECK(length_inside(disk, {-3, 2.5}, {3, 2.5}) == 0);
}

}  // namespace geometry_test
