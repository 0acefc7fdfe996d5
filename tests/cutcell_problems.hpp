#pragma once

#include <cmath>
#include <numbers>

#include "solvers/laplace/cutcell/solver.hpp"
#include "tests/random_placement.hpp"

/// Problems for the cut-cell solver and its parts.
namespace lichtenberg::cutcell_problems {

using namespace laplace;

constexpr double pi = std::numbers::pi;

/// `count` disks of radius `radius` in a box of side `side`, with gaps of at least `least_gap`, around a grounded
/// half-disk on the bottom. Charges alternate in size and sign.
inline LaplaceProblem random_disks(int count, double side, double radius, double least_gap) {
  random_placement::Random random(7);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {side, side};
  problem.bodies = {{Disk{{0.5 * side, 0}, 2 * radius}, 0}};
  problem.groups = {{false, 0, 0}};
  while (static_cast<int>(problem.bodies.size()) <= count) {
    const Disk disk{{random(radius + 1, side - radius - 1), random(radius + 1, side - radius - 1)}, radius};
    random_placement::add_if_free(problem, disk, least_gap, random);
  }
  return problem;
}

/// Problem of two disks of radius R at distance d along the unit vector e, with charge 1 and potential 0. The walls
/// have the exact bipolar potential of line charges at +-a from the middle, a^2 = d^2/4 - R^2.
inline LaplaceProblem two_disks(double side, Vec2 middle, Vec2 e, double R, double d) {
  const double a = std::sqrt(0.25 * d * d - R * R);
  const Vec2 charged = middle - a * e, grounded = middle + a * e;
  const double offset = std::acosh(0.5 * d / R) / (2 * pi);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {side, side};
  for (Side& s : problem.sides) {
    s.kind = Side::Kind::electrode;
    s.profile = [=](Vec2 p) { return std::log(norm(p - grounded) / norm(p - charged)) / (2 * pi) + offset; };
  }
  problem.bodies = {{Disk{middle - 0.5 * d * e, R}, 0}, {Disk{middle + 0.5 * d * e, R}, 1}};
  problem.groups = {{true, 1, 0}, {false, 0, 0}};
  return problem;
}

inline CutCellOptions options(int cells, double tolerance = 1e-10) {
  CutCellOptions o;
  o.cells = cells;
  o.tolerance = tolerance;
  return o;
}

}  // namespace lichtenberg::cutcell_problems
