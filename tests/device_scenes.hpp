#pragma once

// Scenes for tests of the device's algorithms.

#include "tests/random_placement.hpp"

namespace lichtenberg::laplace::device_scenes {

/// Disks of several sizes in a box of 96 x 64, with gaps of at least `least_gap` and charges of both signs. The first
/// is a grounded half-disk on the bottom.
inline LaplaceProblem random_disks(int count, double least_gap) {
  random_placement::Random random(11);
  LaplaceProblem problem;
  problem.size = {96, 64};
  problem.sides[top].kind = Side::Kind::electrode;
  problem.sides[top].potential = 0.3;
  problem.permittivity = 2;
  problem.bodies = {{Disk{{48, 0}, 7}, 0}};
  problem.groups = {{false, 0, 0.1}};
  while (static_cast<int>(problem.bodies.size()) <= count) {
    const double radius = random(2.5, 4);
    const Disk disk{{random(radius, 96 - radius), random(radius, 64 - radius)}, radius};
    random_placement::add_if_free(problem, disk, least_gap, random);
  }
  return problem;
}

/// Problem without ground whose charges sum to zero.
inline LaplaceProblem insulated() {
  LaplaceProblem problem = random_disks(12, 0.4);
  problem.sides = {};
  double total = 0;
  for (Group& group : problem.groups) {
    group.floating = true;
    total += group.charge;
  }
  problem.groups[0].charge = -total;
  return problem;
}

/// Narrow box whose finest grid is also the coarsest, with few cells.
inline LaplaceProblem narrow_box() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {16, 8};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  problem.bodies = {{Disk{{4.3, 4.1}, 1.9}, 0}, {Disk{{11.2, 4.4}, 2.3}, 1}};
  problem.groups = {{true, 1, 0}, {true, -0.4, 0}};
  return problem;
}

}  // namespace lichtenberg::laplace::device_scenes
