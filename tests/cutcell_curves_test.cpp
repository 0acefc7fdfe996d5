// Tests of the cut-cell solver with closed curves: capacitances in closed form, gradients, and equivalent shapes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "tests/curve_references.hpp"
#include "tests/cutcell_problems.hpp"

namespace cutcell_curves_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using lichtenberg::cutcell_problems::options;
using namespace lichtenberg::curve_references;
using doctest::Approx;

/// Root mean square of the relative errors of the capacitance at 16 positions of the curves in the cells.
double error(const std::function<Pair(Vec2)>& pair_at, int cells) {
  double sum = 0;
  for (int k = 0; k < 16; ++k) {
    const Pair pair = pair_at(Vec2{0.5, 0.5} + Vec2{std::fmod(0.618034 * k, 1), std::fmod(0.414214 * k, 1)} / cells);
    const double charge = CutCellSolver(options(cells)).solve(between(pair)).body_charge[0];
    sum += std::pow(charge / pair.capacitance - 1, 2);
  }
  return std::sqrt(sum / 16);
}

TEST_CASE("confocal ellipses: capacitance of second order at least") {
  const auto pair = [](Vec2 centre) { return confocal_ellipses(centre, 0.25, 0.12, 0.4); };
  const double coarse = error(pair, 48), fine = error(pair, 144);
  CHECK(std::log(coarse / fine) / std::log(3) > 2);
  CHECK(fine < 6e-6);  // The links have the curvature of the surface; 1 / cut has 1e-4
}

void check_square_line(double angle) {
  const auto pair = [&](Vec2 centre) { return concentric_rhombi(centre, pi / 4, angle); };
  CHECK(pair({0.5, 0.5}).capacitance == Approx(squares()).epsilon(1e-10));
  const double coarse = error(pair, 48), fine = error(pair, 144);
  CHECK(std::log(coarse / fine) / std::log(3) == Approx(4.0 / 3).epsilon(0.15));
  CHECK(fine < 2e-3);
}

TEST_CASE("square coaxial line: Bowman's capacitance, order 4/3") {
  CHECK(squares() == Approx(10.2340926).epsilon(1e-8));
  check_square_line(pi / 4 + 0.3);
}

TEST_CASE("square coaxial line along the cells: order 4/3" * doctest::test_suite("long")) { check_square_line(pi / 4); }

TEST_CASE("rhombi: order 2 pi / (2 pi - angle) of the corner" * doctest::test_suite("long")) {
  // Corners of 60 degrees
  const auto pair = [](Vec2 centre) { return concentric_rhombi(centre, pi / 6, 0.2); };
  const double coarse = error(pair, 48), fine = error(pair, 144);
  CHECK(std::log(coarse / fine) / std::log(3) == Approx(1.2).epsilon(0.15));
  CHECK(fine < 6e-3);
}

/// Floating ellipse with a charge of 0.7 in a uniform field. Its closed-form potential is imposed on the sides, in
/// elliptic coordinates u, v with x + i y = c cosh(u + i v): V = (A cos v + B sin v) e^-u - E.r - q (u - u0) / 2 pi.
struct EllipseInField {
  Vec2 centre{0.5, 0.5};
  double a = 0.22, b = 0.09, angle = 0.5, charge = 0.7;
  Vec2 field{1.3, -0.4};

  Vec2 field_in_axes() const {
    const Vec2 axis{std::cos(angle), std::sin(angle)};
    return {dot(field, axis), cross(axis, field)};
  }
  double potential(Vec2 p) const {
    const double c = std::sqrt(a * a - b * b), u0 = std::atanh(b / a);
    const std::complex<double> z = std::complex(p.x - centre.x, p.y - centre.y) * std::polar(1.0, -angle);
    const std::complex<double> w = std::acosh(z / c);
    const auto [along, across] = field_in_axes();
    const double induced = (along * a * std::cos(w.imag()) + across * b * std::sin(w.imag())) * std::exp(u0 - w.real());
    return induced - dot(field, p - centre) - charge / (2 * pi) * (w.real() - u0);
  }
  /// Torque p x E of the induced dipole moment p.
  double torque() const { return pi * (a * a - b * b) * field_in_axes().x * field_in_axes().y; }
  LaplaceSolution solve(int cells) const {
    LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
    for (Side& side : problem.sides) side = {Side::Kind::electrode, 0, [this](Vec2 p) { return potential(p); }};
    const ClosedCurve ellipse = make_ellipse(centre, {a, b}, angle, false);
    problem.bodies = {{Freeform{&ellipse}, 0}};
    problem.groups = {{true, charge, 0}};
    return CutCellSolver(options(cells)).solve(problem);
  }
};

TEST_CASE("floating ellipse in a field: potential, force and torque") {
  double before = 0;
  for (const int cells : {64, 128, 256}) {
    double sum = 0;
    for (int k = 0; k < 6; ++k) {
      EllipseInField ellipse;
      ellipse.centre += Vec2{std::fmod(0.618034 * k, 1), std::fmod(0.414214 * k, 1)} / cells;
      const LaplaceSolution found = ellipse.solve(cells);
      const double force = norm(found.body_force[0] - ellipse.charge * ellipse.field) / norm(ellipse.field);
      const double torque = found.body_torque[0] / ellipse.torque() - 1;
      sum += force * force + torque * torque + std::pow(found.group_potential[0], 2);
      CHECK(std::abs(found.group_potential[0]) < 0.2 / cells / cells * 16);
    }
    const double error = std::sqrt(sum / 6);
    if (before > 0) CHECK(std::log2(before / error) > 1.6);
    before = error;
  }
  CHECK(before < 1e-3);
}

TEST_CASE("circle as a closed curve: equals the disk to its tolerance") {
  const ClosedCurve circle = make_ellipse({0.41, 0.57}, {0.13, 0.13}, 0.3, false);
  const ClosedCurve rim = make_ellipse({0.5, 0.5}, {0.48, 0.48}, 0, true);
  LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  problem.groups = {{false, 0, 1}, {false, 0, 0}, {true, 0.3, 0}};
  problem.bodies = {{Disk{{0.41, 0.57}, 0.13}, 0}, {Ring{{0.5, 0.5}, 0.48}, 1}, {Disk{{0.68, 0.4}, 0.08}, 2}};
  const LaplaceSolution round = CutCellSolver(options(96)).solve(problem);
  problem.bodies[0].shape = Freeform{&circle};
  problem.bodies[1].shape = Freeform{&rim};
  const LaplaceSolution curves = CutCellSolver(options(96)).solve(problem);
  for (int k = 0; k < 3; ++k) {
    CHECK(curves.body_charge[k] == Approx(round.body_charge[k]).epsilon(1e-9));
    CHECK(norm(curves.body_force[k] - round.body_force[k]) < 1e-6 * norm(round.body_force[k]));
  }
  CHECK(curves.group_potential[2] == Approx(round.group_potential[2]).epsilon(1e-9));
}

TEST_CASE("regular polygon: tends to the disk of the same area as 1 / corners^2") {
  const Vec2 centre{0.47, 0.53};
  const auto charge = [&](const Shape& shape) {
    LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
    problem.sides[left].kind = problem.sides[right].kind = Side::Kind::electrode;
    problem.bodies = {{shape, 0}};
    problem.groups = {{false, 0, 1}};
    return CutCellSolver(options(256)).solve(problem).body_charge[0];
  };
  const double disk = charge(Disk{centre, 0.2});
  const auto difference = [&](int n) {
    const double radius = 0.2 * std::sqrt(2 * pi / n / std::sin(2 * pi / n));
    std::vector<Vec2> corners;
    for (int k = 0; k < n; ++k)
      corners.push_back(centre + radius * Vec2{std::cos(0.1 + 2 * pi * k / n), std::sin(0.1 + 2 * pi * k / n)});
    const ClosedCurve polygon = make_polygon(corners, 0, false);
    return std::abs(charge(Freeform{&polygon}) / disk - 1);
  };
  // With the same area the corners' outer parts and the sides' inner parts cancel to second order.
  const double four = difference(4), eight = difference(8), sixteen = difference(16);
  CHECK(eight < four / 4);
  CHECK(sixteen < eight / 4);
  CHECK(difference(64) < 2e-4);
}

TEST_CASE("curve through points of an ellipse: equals the ellipse") {
  std::vector<Vec2> points;
  for (int k = 0; k < 80; ++k) {
    const double t = 2 * pi * k / 80;
    points.push_back(Vec2{0.5, 0.5} + Vec2{0.25 * std::cos(t), 0.12 * std::sin(t)});
  }
  const Pair ellipse = confocal_ellipses({0.5, 0.5}, 0.25, 0.12, 0);
  const Pair spline{make_spline(points, false), ellipse.outer, ellipse.capacitance};
  const double a = CutCellSolver(options(128)).solve(between(ellipse)).body_charge[0];
  const double b = CutCellSolver(options(128)).solve(between(spline)).body_charge[0];
  CHECK(b == Approx(a).epsilon(1e-6));  // The spline deviates by 5e-7.
}

TEST_CASE("links of closed curves: gradients equal central differences") {
  const double step = 1e-6;
  for (const double angle : {0.1, 0.9, 2.3}) {
    const auto curves_at = [&](Vec2 centre) {
      return std::array{make_ellipse(centre, {7.3, 4.1}, angle, false), rhombus(centre, 8, 0.7, angle, false),
                        make_ellipse(centre, {0.9, 0.6}, angle, false)};
    };
    const Vec2 centre{16.2, 15.9};
    const auto here = curves_at(centre), right_of = curves_at(centre + Vec2{step, 0}),
               left_of = curves_at(centre - Vec2{step, 0}), above = curves_at(centre + Vec2{0, step}),
               below = curves_at(centre - Vec2{0, step});
    for (std::size_t n = 0; n < here.size(); ++n) {
      int links = 0, agreeing = 0;
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i)
          for (int side = 0; side < 4; ++side) {
            const Vec2 p = cell_centre(i, j), e = direction(side);
            const Outline own = curve_outline(here[n], 1);
            if (!curve_covers(own, p + e) || curve_covers(own, p)) continue;
            const auto value = [&](const auto& curves) {
              return fluid_link(curve_outline(curves[n], 1), p, e, LinkFormula::log_fitted).value;
            };
            const Conductance c = fluid_link(own, p, e, LinkFormula::log_fitted);
            const Vec2 difference{(value(right_of) - value(left_of)) / (2 * step),
                                  (value(above) - value(below)) / (2 * step)};
            ++links;
            agreeing += norm(c.gradient - difference) < 1e-3 * norm(c.gradient);
          }
      CHECK(links >= 8);
      CHECK(agreeing == links);
    }
  }
}

TEST_CASE("gap between a curve and a disk: equals that between disks") {
  // Gaps of half a cell and less, across cells of conductors and a fluid cell
  for (const double cells_in_gap : {0.9, 0.3, 0.02}) {
    const double h = 1.0 / 64;
    const Disk one{{0.4, 0.5}, 0.12}, other{{0.64 + cells_in_gap * h, 0.5}, 0.12};
    const ClosedCurve curve = make_ellipse(one.centre, {one.radius, one.radius}, 0.2, false);
    LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
    problem.sides[bottom].kind = Side::Kind::electrode;
    problem.groups = {{false, 0, 1}, {true, 0, 0}};
    problem.bodies = {{one, 0}, {other, 1}};
    const LaplaceSolution disks = CutCellSolver(options(64)).solve(problem);
    problem.bodies[0].shape = Freeform{&curve};
    const LaplaceSolution mixed = CutCellSolver(options(64)).solve(problem);
    CHECK(mixed.group_potential[1] == Approx(disks.group_potential[1]).epsilon(1e-6));
    CHECK(mixed.body_force[1].x == Approx(disks.body_force[1].x).epsilon(1e-5));
  }
}

TEST_CASE("floating curves smaller than coarse cells: few iterations") {
  std::vector<ClosedCurve> curves;
  for (const double size : {0.6, 1.3, 4.0, 11.0})
    for (const double ratio : {1.0, 0.2, 0.04})
      curves.push_back(make_ellipse({14 + 3 * size, 38 - 14 * ratio}, {size, size * ratio}, 0.5, false));
  std::vector<Vec2> star;
  for (int k = 0; k < 14; ++k)
    star.push_back(Vec2{44, 18} + (k % 2 == 0 ? 13.0 : 2.5) * Vec2{std::cos(pi * k / 7), std::sin(pi * k / 7)});
  curves.push_back(make_polygon(star, 0, false));
  for (const ClosedCurve& curve : curves) {
    LaplaceProblem problem{.size = {64, 64}, .permittivity = 1};
    problem.sides[left] = {Side::Kind::electrode, 0.0, {}};
    problem.sides[right] = {Side::Kind::electrode, 5.0, {}};
    problem.bodies = {{Freeform{&curve}, 0}};
    problem.groups = {{true, 0.2, 0}};
    CutCellOptions o = options(128);
    const LaplaceSolution a = CutCellSolver(o).solve(problem);
    o.linear_solver = CutCellOptions::LinearSolver::assembled;
    const LaplaceSolution b = CutCellSolver(o).solve(problem);
    CHECK(a.group_potential[0] == Approx(b.group_potential[0]).epsilon(1e-8));
    CHECK(a.iterations <= 16);  // Regression value with a margin of 3
  }
}

TEST_CASE("closed curves: identical bits for any number of threads") {
  const Pair pair = concentric_rhombi({0.51, 0.49}, 0.6, 0.2);
  CutCellOptions o = options(256);
  o.threads = 1;
  const LaplaceSolution one = CutCellSolver(o).solve(between(pair));
  o.threads = 3;
  const LaplaceSolution three = CutCellSolver(o).solve(between(pair));
  CHECK(one.body_charge == three.body_charge);
  CHECK(one.energy == three.energy);
}

TEST_CASE("closed curves: mirror images have mirrored forces and equal charges") {
  const auto solve = [](double sign) {
    std::vector<Vec2> corners;
    for (const Vec2 p : {Vec2{-0.2, -0.1}, Vec2{0.15, -0.13}, Vec2{0.2, 0.17}})
      corners.push_back({0.5 + sign * p.x, 0.5 + p.y});
    const ClosedCurve triangle = make_polygon(corners, 0.02, false);
    LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
    problem.sides[bottom].kind = Side::Kind::electrode;
    problem.bodies = {{Freeform{&triangle}, 0}};
    problem.groups = {{false, 0, 1}};
    return CutCellSolver(options(128)).solve(problem);
  };
  const LaplaceSolution one = solve(1), mirrored = solve(-1);
  CHECK(one.body_charge[0] == Approx(mirrored.body_charge[0]).epsilon(1e-9));
  CHECK(one.body_force[0].x == Approx(-mirrored.body_force[0].x).epsilon(1e-6));
  CHECK(one.body_force[0].y == Approx(mirrored.body_force[0].y).epsilon(1e-6));
}

TEST_CASE("ellipse centred on an insulating side: half of the whole one") {
  for (const double angle : {0.0, pi / 2}) {
    LaplaceProblem whole{.size = {1, 1}, .permittivity = 1};
    whole.sides[left].kind = whole.sides[right].kind = Side::Kind::electrode;
    whole.groups = {{false, 0, 1}};
    LaplaceProblem half = whole;
    half.size = {1, 0.5};
    const ClosedCurve in_middle = make_ellipse({0.43, 0.5}, {0.22, 0.11}, angle, false);
    const ClosedCurve on_side = make_ellipse({0.43, 0}, {0.22, 0.11}, angle, false);
    whole.bodies = {{Freeform{&in_middle}, 0}};
    half.bodies = {{Freeform{&on_side}, 0}};
    const LaplaceSolution all = CutCellSolver(options(128)).solve(whole), one = CutCellSolver(options(128)).solve(half);
    CHECK(2 * one.body_charge[0] == Approx(all.body_charge[0]).epsilon(1e-7));
    CHECK(2 * one.body_force[0].x == Approx(all.body_force[0].x).epsilon(1e-5));
  }
}

TEST_CASE("closed curves: device and aperture formula refuse them") {
  const Pair pair = confocal_ellipses({0.5, 0.5}, 0.25, 0.12, 0);
  CHECK_THROWS_AS(device::make_host_solver(options(64))->solve(between(pair)), InputError);
  CutCellOptions o = options(64);
  o.links = LinkFormula::aperture;
  o.linear_solver = CutCellOptions::LinearSolver::assembled;
  CHECK_THROWS_AS(CutCellSolver(o).solve(between(pair)), InputError);
  LaplaceProblem problem = between(pair);
  problem.bodies[0].shape = Freeform{};
  CHECK_THROWS_AS(CutCellSolver(options(64)).solve(problem), InputError);
}

}  // namespace cutcell_curves_test
