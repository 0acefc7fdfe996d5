#pragma once

// Cases of the grid: surfaces through cell centres, disks much smaller and much larger than a cell, a conductor that
// moves across cells.

#include "validation/hard_cases/common.hpp"

namespace lichtenberg::validation {

/// Tests surfaces through cell centres: 64 disks centred on cell centres with R = 5 cells, so that 12 cell centres
/// (3-4-5 triangles) are exactly on each surface. A small displacement of the lattice makes cuts of this length or
/// covers the centres. All gaps are wider than 2 R.
inline void surfaces_through_centres(Report& report) {
  for (const double shift : {0.0, 1e-12, -1e-12, 1e-9, 1e-6}) {
    std::mt19937_64 random(1);
    LaplaceProblem problem = box({128, 128}, {bottom});
    add_lattice(problem, 8, 8, 5, 0, random);
    for (Body& body : problem.bodies) std::get<Disk>(body.shape).centre += Vec2{0.5 + shift, 0.5 + shift};
    const std::string name = shift == 0 ? "centres on surfaces" : fmt::format("cut lengths of {:g} cells", shift);
    compare(report, name, problem, expected(5, 6));
  }
}

/// Tests a charged disk much smaller than a cell in a grounded box. Its potential is Q / 2 pi ln(L / R), so an error of
/// the potential is equivalent to a change of ln R by 2 pi times the error.
/// Derivation of the bound: the error comes from the disk's cell and its four neighbours for any R. The flux q_k =
/// dtheta_k / 2 pi goes to neighbour k at distance r_k. The neighbours' potentials follow from the lattice Green
/// function without the disk's cell; its values are 0, 1/4, 1/pi, 1 - 2/pi at (0,0), (1,0), (1,1), (2,0). They are 1/4
/// for the sum of the fluxes, 0.571 and 0.376 for differences of opposite fluxes and of the two axes. They should be
/// logarithmic, (ln r + gamma + 3/2 ln 2) / 2 pi. The sum q_k ln r_k + 2 pi q H q + gamma + 3/2 ln 2 is 0.046 in the
/// middle of the cell, 0.125 in its corners and at most 0.177, close to the corners.
inline void smaller_than_a_cell(Report& report, int positions) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (const double radius : {0.3, 0.1, 0.01}) {
    std::vector<double> radius_error;
    int iterations = 0;
    for (int k = 0; k < positions; ++k) {
      LaplaceProblem problem = grounded_box({64, 64});
      add(problem, {{30 + fraction(random), 32 + fraction(random)}, radius}, {.charge = 1});
      const LaplaceSolution solution = cut_cell(problem), exact = spectral(problem);
      radius_error.push_back(200 * pi * (solution.group_potential[0] - exact.group_potential[0]));
      iterations = std::max(iterations, solution.iterations);
    }
    report.at_most(fmt::format("R = {:g} cell: acts like a radius off by, %", radius), spread(radius_error), 18,
                   most_of(iterations));
  }
}

/// Tests a disk much larger than a cell: R = 400 cells in a box of 1024 cells, slightly off the middle.
inline void larger_than_all_else(Report& report) {
  LaplaceProblem problem = grounded_box({1024, 1024});
  add(problem, {{520.3, 508.7}, 400}, {.charge = 1});
  compare(report, "R = 400 cells", problem, expected(400, 100));
}

/// Tests the variation of the force on a disk that moves along an electrode, with the exact potential on the other
/// walls. `ratio`: d / 2R for the distance d from its mirror image. The exact force is constant, so changes are due to
/// the grid. Bounds are those of the program two_disks at R = 8, scaled with h^2, times sqrt(2). The errors of two
/// disks are independent there, but here the image moves in step with the disk.
inline void moving_along_electrode(Report& report, double radius, double ratio, double bound) {
  const double side = 16 * std::ceil((2 * ratio + 6) * radius / 16);
  CutCellSolver solver({.cells = static_cast<int>(side)});
  std::vector<double> along, potential;
  int iterations = 0;
  for (int k = 0; k < 80; ++k) {
    const double x = 0.5 * side + 0.037 * k;
    const Disk disk{{x, ratio * radius}, radius}, image{{x, -ratio * radius}, radius};
    const theory::DiskPair pair{disk, image, 1};
    LaplaceProblem problem = in_plane(pair, {side, side}, 1);
    problem.bodies.resize(1);
    problem.groups.resize(1);
    problem.sides[bottom].profile = nullptr;
    const LaplaceSolution solution = solver.solve(problem);
    along.push_back(100 * solution.body_force[0].y / theory::force(pair, 1).y);
    potential.push_back(100 * solution.group_potential[0] / theory::positive_potential(pair, 1));
    if (k > 0) iterations = std::max(iterations, solution.iterations);
  }
  const std::string name = fmt::format("moving, R = {:g}, gap {:.2g} R", radius, 2 * (ratio - 1));
  report.at_most(name + ": force, rms about its mean, %", spread(along).jitter, bound, most_of(iterations));
  report.at_most(name + ": potential, rms about its mean, %", spread(potential).jitter, bound);
}

/// Runs all tests of the grid; `is_long`: with more positions.
inline void hard_for_the_grid(Report& report, bool is_long) {
  report.section("The grid");
  surfaces_through_centres(report);
  smaller_than_a_cell(report, is_long ? 200 : 20);
  larger_than_all_else(report);
  for (const double radius : {4.0, 8.0, 16.0}) {
    const double scale = std::sqrt(2) * (8 / radius) * (8 / radius);
    moving_along_electrode(report, radius, 2, 0.02 * scale);
    moving_along_electrode(report, radius, 1.25, 0.06 * scale);
    moving_along_electrode(report, radius, 1.05, 1.5 * scale);
  }
}

}  // namespace lichtenberg::validation
