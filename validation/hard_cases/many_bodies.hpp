#pragma once

// Cases with many or dense conductors: packings, a group of a thousand, narrow channels, closed rings, numbers from 1
// to 20000. Cases of the box: elongated boxes, insulated boxes, charges of all sizes.

#include "validation/hard_cases/common.hpp"

namespace lichtenberg::validation {

/// Tests a hexagonal packing of disks with 60 % area fraction: 0.9069 (2R/d)^2 = 0.6 at the spacing d = 1.229 * 2R.
/// Displacements are random, up to 0.4 of the remaining gap.
inline void packed(Report& report) {
  const double radius = 8, spacing = 2 * radius * std::sqrt(pi / std::sqrt(12.0) / 0.6);
  const int columns = 12, rows = 14;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  // The box has whole cells; the margins take the difference from the packing's own box.
  LaplaceProblem problem = box({256, 256}, {bottom});
  const Vec2 margin = 0.5 * Vec2{256 - (columns - 0.5) * spacing, 256 - (rows - 1) * spacing * std::sqrt(0.75)};
  const double jitter = 0.4 * (spacing - 2 * radius) / 2;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Vec2 site{(i + 0.5 * (j % 2)) * spacing, j * spacing * std::sqrt(0.75)};
      const double angle = pi * uniform(random);
      add(problem, {margin + site + jitter * Vec2{std::cos(angle), std::sin(angle)}, radius},
          {.charge = uniform(random)});
    }
  compare(report, "60 % of the area", problem, expected(radius, 0.6 * (spacing - 2 * radius)));
}

/// Tests one floating group of 1000 disks, distributed over the box.
inline void thousand_in_one_group(Report& report) {
  std::mt19937_64 random(4);
  LaplaceProblem problem = box({512, 512}, {bottom});
  add_lattice(problem, 40, 25, 4, 1.2, random);
  for (Body& body : problem.bodies) body.group = 0;
  problem.groups = {{.charge = 1}};
  compare(report, "1000 in one group", problem, expected(4, 2.4));
}

/// Tests channels narrower than a cell: between two disks of R = 100 cells at different potentials, and between a disk
/// and an insulating wall.
inline void thin_channels(Report& report) {
  for (const double gap : {0.5, 0.1, 0.01}) {
    LaplaceProblem problem = grounded_box({512, 512});
    const Vec2 half = (100 + 0.5 * gap) * Vec2{0.8, 0.6};
    add(problem, {Vec2{255.3, 256.1} - half, 100}, {.charge = 1});
    add(problem, {Vec2{255.3, 256.1} + half, 100}, {.charge = -1});
    compare(report, fmt::format("channel of {:g} cell", gap), problem, expected(100, gap));
  }
  for (const double gap : {0.5, 0.1, 0.01}) {
    LaplaceProblem problem = box({256, 256}, {bottom});
    add(problem, {{120.7, 100 + gap}, 100}, {.charge = 1});
    compare(report, fmt::format("channel of {:g} cell to a wall", gap), problem, expected(100, gap));
  }
}

/// Makes a ring of sixteen disks (at 0 V, or floating) with another conductor inside and a wall at 1 V outside. A
/// grounded ring shields the inside.
inline LaplaceProblem ring(double gap, bool grounded, bool one_missing) {
  const int members = 16;
  const double radius = 8, circle = (radius + 0.5 * gap) / std::sin(pi / members);
  LaplaceProblem problem = box({128, 128}, {left});
  problem.sides[left].potential = 1;
  const Vec2 middle{64.2, 63.9};
  add(problem, {middle + Vec2{6.3, -11.2}, radius}, {.charge = grounded ? 0.0 : 1.0});
  for (int k = one_missing; k < members; ++k) {
    const double angle = 2 * pi * (k + 0.3) / members;
    add(problem, {middle + circle * Vec2{std::cos(angle), std::sin(angle)}, radius}, {.floating = !grounded});
  }
  return problem;
}

/// Tests closed rings of disks, and a ring with one disk missing.
inline void closed_rings(Report& report) {
  for (const double gap : {0.8, 1e-3, 1e-6}) {
    compare(report, fmt::format("ring with gaps of {:g} cell, at 0 V", gap), ring(gap, true, false), expected(8, 16),
            gap < 0.01 ? 2 * most_iterations : most_iterations);
    compare(report, fmt::format("ring with gaps of {:g} cell, floating", gap), ring(gap, false, false),
            expected(8, gap), gap < 0.01 ? 2 * most_iterations : most_iterations);
  }
  compare(report, "ring with one missing, at 0 V", ring(1e-3, true, true), expected(8, 16));
}

/// Tests an insulated box without ground, in which potentials are determined up to a constant and charges sum to zero.
inline void insulated_box(Report& report) {
  std::mt19937_64 random(5);
  LaplaceProblem problem = box({128, 128}, {});
  add_lattice(problem, 5, 4, 6, 4, random);
  double total = 0;
  for (const Group& group : problem.groups) total += group.charge;
  for (Group& group : problem.groups) group.charge -= total / 20;
  compare(report, "insulated neutral box", problem, expected(6, 6));
  for (Group& group : problem.groups) group.charge = 0;
  const LaplaceSolution solution = cut_cell(problem);
  double largest = 0;
  for (const double phi : solution.group_potential) largest = std::max(largest, std::abs(phi));
  report.at_most("insulated box without charge: potentials", largest, 0, cost(solution));
}

/// Tests charges of 1e-20 C and 1e+3 C in one scene, then all charges of 1e-20 C. Potentials must be proportional to
/// the charges, within rounding accumulated over about twelve conjugate gradient iterations.
inline void charges_of_all_sizes(Report& report) {
  std::mt19937_64 random(6);
  LaplaceProblem problem = box({128, 128}, {bottom});
  problem.permittivity = 4.7 * 8.8541878128e-12;
  add_lattice(problem, 5, 5, 6, 4, random);
  for (std::size_t g = 0; g < 25; ++g) problem.groups[g].charge = (g % 2 == 0 ? 1e3 : 1e-20) * (g % 3 == 0 ? -1 : 1);
  compare(report, "charges of 1e-20 and 1e+3 C", problem, expected(6, 6));

  for (Group& group : problem.groups) group.charge = std::copysign(1e3, group.charge);
  const LaplaceSolution large = cut_cell(problem);
  for (Group& group : problem.groups) group.charge *= 1e-23;
  const LaplaceSolution small = cut_cell(problem);
  std::vector<double> difference;
  for (std::size_t g = 0; g < 25; ++g)
    difference.push_back((1e23 * small.group_potential[g] - large.group_potential[g]) /
                         largest_potential(problem, large));
  report.at_most("all charges 1e-23 as large: potentials, relative", spread(difference), 1e-10, cost(small));
}

/// Tests one disk, and 20000 disks; `is_long`: also on a large grid.
inline void few_and_many(Report& report, bool is_long) {
  LaplaceProblem one = grounded_box({128, 128});
  add(one, {{40.3, 30.2}, 8}, {.charge = 1});
  compare(report, "N = 1", one, expected(8, 22));

  std::mt19937_64 random(7);
  LaplaceProblem small = box({512, 512}, {bottom});
  add_lattice(small, 160, 125, 1, 0.3, random);
  const LaplaceSolution solution = cut_cell(small);
  report.at_most("N = 20000, R = 1 cell, S = 512: iterations", solution.iterations, 2 * most_iterations,
                 cost(solution));
  report.at_most("N = 20000, R = 1 cell, S = 512: charge balance", charge_imbalance(small, solution), 1e-10);
  if (!is_long) return;
  report.at_most("N = 20000, R = 1 cell, S = 512: potentials, %",
                 potential_error(small, solution, spectral(small, 1e-6)), expected(1, 0.5).potential);
  LaplaceProblem large = box({4096, 4096}, {bottom});
  add_lattice(large, 160, 125, 8, 2.5, random);
  compare(report, "N = 20000, R = 8 cells, S = 4096", large, expected(8, 4), 2 * most_iterations);
}

/// Tests boxes with an aspect ratio of eight in both orientations; electrodes are the short or the long sides.
inline void long_boxes(Report& report) {
  for (const bool upright : {false, true})
    for (const bool short_sides : {false, true}) {
      std::mt19937_64 random(8);
      const bool bottom_and_top = upright == short_sides;
      LaplaceProblem problem = bottom_and_top ? box({512, 64}, {bottom, top}) : box({512, 64}, {left, right});
      if (upright) problem.size = {64, 512};
      problem.sides[bottom_and_top ? top : right].potential = 1;
      add_lattice(problem, upright ? 2 : 16, upright ? 16 : 2, 6, 3, random);
      compare(report,
              fmt::format("{}, {} sides electrodes", upright ? "1 x 8" : "8 x 1", short_sides ? "short" : "long"),
              problem, expected(6, 6));
    }
}

/// Runs all tests of dense systems and boxes; `is_long`: with large systems.
inline void hard_for_many_bodies(Report& report, bool is_long) {
  report.section("Dense systems and boxes");
  packed(report);
  thousand_in_one_group(report);
  thin_channels(report);
  closed_rings(report);
  insulated_box(report);
  charges_of_all_sizes(report);
  few_and_many(report, is_long);
  long_boxes(report);
}

}  // namespace lichtenberg::validation
