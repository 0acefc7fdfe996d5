#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "solvers/geometry/closed_curve.hpp"
#include "solvers/laplace/problem.hpp"

/// Capacitances between closed curves of the plane in closed form, per depth and permittivity.
namespace lichtenberg::curve_references {

constexpr double pi = std::numbers::pi;

/// Integral over [a, b] of f(distance from a, distance from b), which may have algebraic singularities at the ends, by
/// the double exponential formula (Takahasi and Mori 1974).
inline double integral(double a, double b, const std::function<double(double, double)>& f) {
  constexpr double step = 1.0 / 64;
  double sum = 0;
  for (int k = -320; k <= 320; ++k) {
    const double g = pi * std::sinh(k * step);
    const double from_a = (b - a) / (1 + std::exp(-g)), from_b = (b - a) / (1 + std::exp(g));
    if (from_a == 0 || from_b == 0) continue;
    sum += (b - a) * pi * std::cosh(k * step) / (2 + std::exp(g) + std::exp(-g)) * f(from_a, from_b);
  }
  return sum * step;
}

/// Capacitance of a quadrilateral P1 P2 P3 P4 between the sides P2 P3 and P4 P1; the other two are insulating. Interior
/// angles at P1, P2 and P3 are in units of pi. `ratio`: length of P2 P3 over that of P1 P2. The map of Schwarz and
/// Christoffel takes 0, 1, x and infinity of a half-plane to the corners; x follows from the ratio. The capacitance is
/// K(1 - 1/x) / K(1/x) with complete elliptic integrals of the parameter.
inline double quadrilateral(double angle_1, double angle_2, double angle_3, double ratio) {
  const auto ratio_for = [&](double beyond) {  // x = 1 + beyond
    const double side_12 = integral(0, 1, [&](double from_0, double from_1) {
      return std::pow(from_0, angle_1 - 1) * std::pow(from_1, angle_2 - 1) * std::pow(beyond + from_1, angle_3 - 1);
    });
    const double side_23 = integral(1, 1 + beyond, [&](double from_1, double from_x) {
      return std::pow(1 + from_1, angle_1 - 1) * std::pow(from_1, angle_2 - 1) * std::pow(from_x, angle_3 - 1);
    });
    return side_23 / side_12;
  };
  double low = 1e-6, high = 1e6;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::sqrt(low * high);
    (ratio_for(middle) < ratio ? low : high) = middle;
  }
  const double parameter = 1 / (1 + low);
  return std::comp_ellint_1(std::sqrt(1 - parameter)) / std::comp_ellint_1(std::sqrt(parameter));
}

/// Capacitance between concentric squares with parallel sides, the outer one twice as large. An eighth is a trapezoid
/// (Bowman 1953).
inline double squares() { return 8 * quadrilateral(0.5, 0.5, 0.25, 2); }

/// Capacitance between concentric rhombi with parallel sides, the outer one twice as large. `half_angle` (rad): half
/// the angle at the corners on the first diagonal. A quarter is a trapezoid.
inline double rhombi(double half_angle) {
  return 4 * quadrilateral(1 - half_angle / pi, half_angle / pi, 0.5 - half_angle / pi, 2 / std::cos(half_angle));
}

/// Two curves, one around the other, and the capacitance between them.
struct Pair {
  ClosedCurve inner, outer;
  double capacitance;
};

/// Confocal ellipses with the semi-axes a and b of the inner one. The capacitance is 2 pi over the difference of the
/// elliptic coordinates u, with b = c sinh u.
inline Pair confocal_ellipses(Vec2 centre, double a, double b, double angle) {
  constexpr double difference = 0.6;
  const double c = std::sqrt(a * a - b * b), u = std::asinh(b / c) + difference;
  return {make_ellipse(centre, {a, b}, angle, false),
          make_ellipse(centre, {c * std::cosh(u), c * std::sinh(u)}, angle, true), 2 * pi / difference};
}

/// Rhombus with a first half diagonal at an `angle` from x.
inline ClosedCurve rhombus(Vec2 centre, double half_diagonal, double half_angle, double angle, bool hollow) {
  std::vector<Vec2> corners;
  for (int k = 0; k < 4; ++k) {
    const double length = k % 2 == 0 ? half_diagonal : half_diagonal * std::tan(half_angle);
    corners.push_back(centre + length * Vec2{std::cos(angle + k * pi / 2), std::sin(angle + k * pi / 2)});
  }
  return make_polygon(corners, 0, hollow);
}

inline Pair concentric_rhombi(Vec2 centre, double half_angle, double angle) {
  return {rhombus(centre, 0.22, half_angle, angle, false), rhombus(centre, 0.44, half_angle, angle, true),
          rhombi(half_angle)};
}

/// Problem in a unit box: the inner curve at 1 V, the outer one at 0 V.
inline laplace::LaplaceProblem between(const Pair& pair) {
  laplace::LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  problem.bodies = {{Freeform{&pair.inner}, 0}, {Freeform{&pair.outer}, 1}};
  problem.groups = {{false, 0, 1}, {false, 0, 0}};
  return problem;
}

}  // namespace lichtenberg::curve_references
