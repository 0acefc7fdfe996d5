#pragma once

// What the grid makes hard: surfaces through cell centres, disks far smaller and far larger than a cell, a conductor
// that moves across the cells.

#include "validation/hard_cases/common.hpp"

namespace lichtenberg::validation {

/// 64 disks centred on cell centres, R = 5: by 3-4-5, 12 cell centres each lie on the surface to the last bit. The
/// lattice is then displaced: cuts are that long, or the centres covered. Wider gaps than 2 R throughout.
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

/// One charged disk much smaller than a cell in a grounded box. Its potential is Q / 2 pi ln(L / R), so that an error
/// acts like another radius: by 2 pi times it. The disk's own cell and the four round it make that error, whatever R
/// is: flux q_k = dtheta_k / 2 pi goes to neighbour k at distance r_k, the neighbours' potentials follow from the
/// lattice's Green function (0, 1/4, 1/pi, 1 - 2/pi at (0,0), (1,0), (1,1), (2,0), with the own cell taken out: 1/4 for
/// the sum of the fluxes, 0.571 and 0.376 for differences of opposite ones and of the two axes), and should be those of
/// a logarithm, (ln r + gamma + 3/2 ln 2) / 2 pi. The sum q_k ln r_k + 2 pi q H q + gamma + 3/2 ln 2 is 0.046 in the
/// middle of the cell, 0.125 in its corners, 0.177 at most, close beside these.
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

/// R = 400 cells, S = 1024, off the middle by a few cells and a fraction.
inline void larger_than_all_else(Report& report) {
  LaplaceProblem problem = grounded_box({1024, 1024});
  add(problem, {{520.3, 508.7}, 400}, {.charge = 1});
  compare(report, "R = 400 cells", problem, expected(400, 100));
}

/// A disk that moves along an electrode (the exact field on the other walls), its image at d / 2R. The force is
/// constant; what changes is the grid's. The figures are two_disks's at R = 8, h^2 apart from that, times the root of
/// two: there two disks jitter independently, here the image in step with the disk.
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
