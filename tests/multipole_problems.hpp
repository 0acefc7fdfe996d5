#pragma once

#include <array>
#include <numbers>

#include "solvers/laplace/multipole/solver.hpp"
#include "tests/random_placement.hpp"

/// Problems for the multipole solver.
namespace lichtenberg::multipole_problems {

using namespace laplace;

constexpr double pi = std::numbers::pi;

inline MultipoleOptions options(double tolerance, bool unbounded = false) {
  MultipoleOptions o;
  o.tolerance = tolerance;
  o.unbounded = unbounded;
  return o;
}

/// Disks with charges of both signs in a rectangular box; each disk is a group.
inline LaplaceProblem random_disks(int count, Vec2 size, double radius, double least_gap) {
  random_placement::Random random(11);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = size;
  while (static_cast<int>(problem.bodies.size()) < count) {
    const double margin = radius + least_gap;
    const Disk disk{{random(margin, size.x - margin), random(margin, size.y - margin)}, radius};
    random_placement::add_if_free(problem, disk, least_gap, random);
  }
  return problem;
}

/// Makes side s of the problem an electrode if bit s of `walls` is set.
inline void set_walls(LaplaceProblem& problem, int walls, const std::array<double, 4>& potential) {
  for (int s = 0; s < 4; ++s)
    if (walls >> s & 1) problem.sides[s] = {Side::Kind::electrode, potential[s], {}};
}

inline void neutralize(LaplaceProblem& problem) {
  double total = 0;
  for (const Group& group : problem.groups) total += group.charge;
  for (Group& group : problem.groups) group.charge -= total / static_cast<double>(problem.groups.size());
}

inline double total_charge(const LaplaceSolution& solution) {
  double sum = 0;
  for (const double q : solution.body_charge) sum += q;
  for (const double q : solution.side_charge) sum += q;
  return sum;
}

}  // namespace lichtenberg::multipole_problems
