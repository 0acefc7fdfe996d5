#pragma once

#include <array>
#include <numbers>
#include <random>

#include "solvers/laplace/multipole/solver.hpp"

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

/// Disks with charges of both signs in a box that isn't square; groups of one.
inline LaplaceProblem crowd(int count, Vec2 size, double radius, double least_gap) {
  std::mt19937_64 generator(11);
  const auto random = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  LaplaceProblem problem;
  problem.size = size;
  while (static_cast<int>(problem.bodies.size()) < count) {
    const double margin = radius + least_gap;
    const Disk disk{{random(margin, size.x - margin), random(margin, size.y - margin)}, radius};
    bool free = true;
    for (const Body& body : problem.bodies) free = free && gap(disk, body.shape) > least_gap;
    if (!free) continue;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, random(-1, 1), 0});
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
