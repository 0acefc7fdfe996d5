#pragma once

// Narrow gaps: between disks of different and equal potential, to an electrode, touching, overlapping.

#include <complex>

#include "solvers/error.hpp"
#include "validation/hard_cases/common.hpp"

namespace lichtenberg::validation {

constexpr double gaps_over_radius[] = {1, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6};

/// Position (cells) and direction (rad) of a pair of disks relative to the grid.
struct Placing {
  Vec2 centre;
  double angle;
};
/// Draws `count` random positions within a cell of `middle`, and random directions.
inline std::vector<Placing> placings(Vec2 middle, int count) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> fraction(0, 1);
  std::vector<Placing> result;
  for (int k = 0; k < count; ++k) {
    const Vec2 centre = middle + Vec2{fraction(random), fraction(random)};
    result.push_back({centre, pi * fraction(random)});
  }
  return result;
}

/// Makes a pair of equal disks with the given gap at a position.
inline theory::DiskPair pair_at(const Placing& at, double radius, double gap) {
  const Vec2 half = (radius + 0.5 * gap) * Vec2{std::cos(at.angle), std::sin(at.angle)};
  return {{at.centre - half, radius}, {at.centre + half, radius}, 1};
}

/// Tests the multipole method for the capacitance C of a pair of disks in the plane (D 6.37). Its tolerance is 1e-12;
/// sums over the pair's terms amplify it about a hundredfold. The gap has the rounding error of the centres, half of
/// which enters C ~ gap^(-1/2).
inline void spectral_pair(Report& report, double gap_over_radius) {
  const double radius = 8;
  const theory::DiskPair pair = pair_at({{40.3, 40.6}, 0.3}, radius, gap_over_radius * radius);
  LaplaceProblem problem = box({80, 80}, {});
  add(problem, pair.positive, {.charge = 1});
  add(problem, pair.negative, {.floating = false});
  MultipoleSolver solver({.tolerance = 1e-12, .unbounded = true});
  const LaplaceSolution solution = solver.solve(problem);
  const double error = 1 / solution.group_potential[0] / theory::capacitance(pair) - 1;
  const double rounding = 40 * 2.2e-16 / (gap_over_radius * radius);
  report.at_most(fmt::format("gap / R = {:g}: spectral against D 6.37, C", gap_over_radius), std::abs(error),
                 1e-10 + rounding, cost(solution));
}

/// Tests the cut-cell method for a pair of disks of different potential in the plane: R = 8 cells, exact potential on
/// the sides of the box.
inline void different_potentials(Report& report, double gap_over_radius, int positions) {
  const double radius = 8, gap = gap_over_radius * radius, side = 80;
  std::vector<double> capacitance, force;
  int iterations = 0;
  for (const Placing& at : placings({40, 40}, positions)) {
    const theory::DiskPair pair = pair_at(at, radius, gap);
    const LaplaceProblem problem = in_plane(pair, {side, side}, 1);
    const LaplaceSolution solution = cut_cell(problem);
    const double difference = solution.group_potential[0] - problem.groups[1].potential;
    const Vec2 exact = theory::force(pair, 1);
    capacitance.push_back(100 * (1 / difference / theory::capacitance(pair) - 1));
    force.push_back(100 * norm(solution.body_force[0] - exact) / norm(exact));
    iterations = std::max(iterations, solution.iterations);
  }
  const std::string name = fmt::format("gap / R = {:g}, different potentials", gap_over_radius);
  const Quality bound = expected(radius, gap);
  report.at_most(name + ": C, %", spread(capacitance), bound.potential, most_of(iterations));
  report.at_most(name + ": force, %", spread(force), bound.force);
}

/// Tests the cut-cell method for a pair of disks at equal potential in a grounded box, R = 8 cells, in comparison with
/// the multipole method. The disks form one group, or two floating groups of equal charge. The field in the gap is
/// negligible, and the pair resembles one smooth body except at the notch, where the field vanishes. The bound is
/// therefore that of the gap to the walls, more than 2 R.
inline void equal_potentials(Report& report, double gap_over_radius, int positions, bool one_group) {
  const double radius = 8, gap = gap_over_radius * radius;
  std::vector<double> potential;
  int iterations = 0;
  for (const Placing& at : placings({48, 48}, positions)) {
    const theory::DiskPair pair = pair_at(at, radius, gap);
    LaplaceProblem problem = grounded_box({96, 96});
    add(problem, pair.positive, {.charge = 1});
    add(problem, pair.negative, {.charge = 1});
    if (one_group) {
      problem.bodies[1].group = 0;
      problem.groups = {{.charge = 2}};
    }
    const LaplaceSolution solution = cut_cell(problem);
    potential.push_back(potential_error(problem, solution, spectral(problem)).worst);
    iterations = std::max(iterations, solution.iterations);
  }
  report.at_most(
      fmt::format("gap / R = {:g}, {}: potential, %", gap_over_radius, one_group ? "one group" : "equal charges"),
      spread(potential), expected(radius, 2 * radius).potential, most_of(iterations));
}

/// Tests the cut-cell method for a disk of R = 8 cells near an electrode side. The exact field is that of the disk and
/// its mirror image, at twice the gap.
inline void near_electrode(Report& report, double gap, int positions) {
  const double radius = 8;
  std::vector<double> capacitance, force;
  int iterations = 0;
  for (const Placing& at : placings({40, 0}, positions)) {
    const Disk disk{{at.centre.x, radius + gap}, radius}, image{{at.centre.x, -radius - gap}, radius};
    const theory::DiskPair pair{disk, image, 1};
    LaplaceProblem problem = in_plane(pair, {80, 80}, 1);
    problem.bodies.resize(1);
    problem.groups.resize(1);
    problem.sides[bottom].profile = nullptr;
    const LaplaceSolution solution = cut_cell(problem);
    const Vec2 exact = theory::force(pair, 1);
    capacitance.push_back(100 * (theory::positive_potential(pair, 1) / solution.group_potential[0] - 1));
    force.push_back(100 * norm(solution.body_force[0] - exact) / norm(exact));
    iterations = std::max(iterations, solution.iterations);
  }
  const std::string name = fmt::format("electrode {:g} cells away", gap);
  const Quality bound = expected(radius, 2 * gap);
  report.at_most(name + ": C, %", spread(capacitance), bound.potential, most_of(iterations));
  report.at_most(name + ": force, %", spread(force), bound.force);
}

/// Tests the cut-cell method for a disk of R = 8 cells inside a dish of R = 48 cells at 0 V, nearly touching its rim.
/// The exact capacitance is that of eccentric cylinders: C = 2 pi / acosh u with u = (R1^2 + R2^2 - d^2) / 2 R1 R2. The
/// form u - 1 = gap (2 (R2 - R1) - gap) / 2 R1 R2 avoids cancellation.
inline void near_rim(Report& report, double gap, int positions) {
  const double radius = 8, rim = 48;
  const double u_minus_1 = gap * (2 * (rim - radius) - gap) / (2 * radius * rim);
  const double exact = pi / std::asinh(std::sqrt(0.5 * u_minus_1));
  std::vector<double> capacitance;
  int iterations = 0;
  for (const Placing& at : placings({56, 56}, positions)) {
    LaplaceProblem problem = box({112, 112}, {});
    const Vec2 towards{std::cos(at.angle), std::sin(at.angle)};
    problem.bodies = {{Disk{at.centre + (rim - radius - gap) * towards, radius}, 0}, {Ring{at.centre, rim}, 1}};
    problem.groups = {{.charge = 1}, {.floating = false}};
    const LaplaceSolution solution = cut_cell(problem);
    capacitance.push_back(100 * (1 / solution.group_potential[0] / exact - 1));
    iterations = std::max(iterations, solution.iterations);
  }
  report.at_most(fmt::format("rim of a dish {:g} cells away: C, %", gap), spread(capacitance),
                 expected(radius, gap).potential, most_of(iterations));
}

/// Tests the cut-cell method for a disk of R = 8 cells near the long face of a bar at 0 V, oblique to the grid. The
/// sides of the box have the exact potential of the disk in front of the plane of the face; V = 0 behind it and on the
/// bar.
inline void near_bar(Report& report, double gap, int positions) {
  const double radius = 8, width = 20;
  std::vector<double> capacitance;
  int iterations = 0;
  for (const Placing& at : placings({48, 48}, positions)) {
    const Vec2 n{std::cos(at.angle), std::sin(at.angle)}, along{-n.y, n.x};
    const theory::DiskPair pair{{at.centre + (radius + gap) * n, radius}, {at.centre - (radius + gap) * n, radius}, 1};
    LaplaceProblem problem = in_plane(pair, {96, 96}, 1);
    const auto profile = [pair, n, at](Vec2 p) {
      return dot(p - at.centre, n) > 0 ? theory::potential(pair, 1, p) : 0.0;
    };
    for (Side& side : problem.sides) side.profile = profile;
    const Vec2 middle = at.centre - 0.5 * width * n;
    problem.bodies[1].shape = Bar{middle - 100.0 * along, middle + 100.0 * along, width};
    problem.groups[1].potential = 0;
    const LaplaceSolution solution = cut_cell(problem);
    capacitance.push_back(100 * (theory::positive_potential(pair, 1) / solution.group_potential[0] - 1));
    iterations = std::max(iterations, solution.iterations);
  }
  report.at_most(fmt::format("bar {:g} cells away: C, %", gap), spread(capacitance),
                 expected(radius, 2 * gap).potential, most_of(iterations));
}

/// Computes Green's function outside two touching or overlapping equal disks of one potential, with the pole at
/// infinity; it is zero on the disks. `z`: position relative to the pair's middle, with the centres at (-offset, 0) and
/// (offset, 0), offset <= radius.
/// The function follows from a conformal map. Touching disks: 1/z maps the outside to a strip, whose tanh is the
/// outside of the unit disk. Overlapping disks: mapping the intersections of the circles to 0 and infinity gives a
/// wedge, and a power gives the half-plane.
inline double joined_disks_green(std::complex<double> z, double radius, double offset) {
  const double half_chord = std::sqrt(std::max(0.0, radius * radius - offset * offset));
  if (half_chord == 0) return -std::log(std::abs(std::tanh(0.5 * pi * radius / std::complex(z.imag(), z.real()))));
  const double wedge = 2 * std::atan(half_chord / offset);
  const std::complex<double> c(0, half_chord), w = std::pow((z - c) / (z + c), pi / wedge);
  return -std::log(std::abs((w - 1.0) / (w + 1.0)));
}

/// Tests the cut-cell method for two touching or overlapping disks of one group in the plane. The potential on the
/// walls is -Q g / 2 pi with Green's function g. The disks must be at 0; their error is in percent of the potential at
/// the walls.
/// Touching disks are as smooth as disks at equal potential. Of overlapping disks, cells inside both belong to the
/// first one. A link from such a cell ends at the first disk's surface even if the second one's is farther out. The
/// difference is at most half a cell on average, on half of the outline. This first-order error is h / 4R of the radius
/// in Q / 2 pi ln(radius).
inline void joined_disks(Report& report, double offset_over_radius, int positions) {
  const double radius = 8, offset = offset_over_radius * radius;
  std::vector<double> potential;
  int iterations = 0;
  for (const Placing& at : placings({48, 48}, positions)) {
    const std::complex<double> axis = std::polar(1.0, at.angle);
    const Vec2 half = offset * Vec2{axis.real(), axis.imag()};
    const auto green = [=](Vec2 p) {
      const Vec2 r = p - at.centre;
      return joined_disks_green(std::complex(r.x, r.y) / axis, radius, offset);
    };
    LaplaceProblem problem = box({96, 96}, {});
    problem.sides.fill({.kind = Side::Kind::electrode, .profile = [=](Vec2 p) { return -green(p) / (2 * pi); }});
    problem.bodies = {{Disk{at.centre - half, radius}, 0}, {Disk{at.centre + half, radius}, 0}};
    problem.groups = {{.charge = 1}};
    const LaplaceSolution solution = cut_cell(problem);
    potential.push_back(100 * solution.group_potential[0] / (green({48, 0}) / (2 * pi)));
    iterations = std::max(iterations, solution.iterations);
  }
  const bool touching = offset_over_radius == 1;
  const double first_order = 100 * 0.25 / radius / std::log(48 / radius);
  report.at_most(fmt::format("{}, one group: potential, %",
                             touching ? "touching" : fmt::format("overlapping, d / 2R = {}", offset_over_radius)),
                 spread(potential), touching ? expected(radius, 2 * radius).potential : first_order,
                 most_of(iterations));
}

/// Tests overlapping disks of different groups, for which no solution exists. The cut-cell solver returns finite
/// numbers with nearly equal potentials. Links along the common surface are 1e-6 cell long at least and thus have a
/// conductance of up to 1e6; the remaining potential difference is 1e-5 of the pair's potential. The multipole solver
/// throws InputError.
inline void overlapping_groups(Report& report) {
  LaplaceProblem problem = grounded_box({96, 96});
  add(problem, {{42.3, 48.1}, 8}, {.charge = 1});
  add(problem, {{54.2, 49.7}, 8}, {.charge = -0.5});
  const LaplaceSolution solution = cut_cell(problem);
  const double difference = std::abs(solution.group_potential[0] - solution.group_potential[1]);
  report.at_most("overlapping, two groups: cut-cell's difference, relative", difference / solution.group_potential[0],
                 1e-5, cost(solution));
  bool refused = false;
  try {
    spectral(problem);
  } catch (const InputError&) {
    refused = true;
  }
  report.at_least("overlapping, two groups: refused by the spectral solver", refused, 1);
}

/// Runs all tests of narrow gaps; `is_long`: with more positions.
inline void narrow_gaps(Report& report, bool is_long) {
  const int positions = is_long ? 20 : 5;
  report.section("Gaps, R = 8 cells");
  for (const double gap : gaps_over_radius) {
    spectral_pair(report, gap);
    different_potentials(report, gap, positions);
    equal_potentials(report, gap, positions, true);
    equal_potentials(report, gap, positions, false);
  }
  for (const double gap : {1.0, 0.1, 1e-3, 1e-6}) near_electrode(report, gap, positions);
  for (const double gap : {1.0, 0.1, 1e-3, 1e-6}) {
    near_rim(report, gap, positions);
    near_bar(report, gap, positions);
  }
  for (const double offset : {1.0, 0.9, 0.5, 0.1}) joined_disks(report, offset, positions);
  overlapping_groups(report);
}

}  // namespace lichtenberg::validation
