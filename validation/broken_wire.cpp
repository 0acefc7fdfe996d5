// The forces on D's broken wire (D 4.8-4.13, 25 spheres between electrodes, one gap, a transverse field) from the field
// solver, gap by gap: what the mean over all places of the gap must be by symmetry, and what the source assumes of it.
//
//   broken_wire          S = 168, a second
//   broken_wire long     S = 672

#include <numbers>

#include "solvers/laplace/cutcell/solver.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"
#include "validation/theory/broken_wire.hpp"
#include "validation/theory/two_disks.hpp"

namespace broken_wire_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

constexpr int n = 25;
constexpr double radius = 0.775e-3, length = 40e-3, end = 1e-3, height = 20e-3, depth = 2 * radius;
constexpr double permittivity = 4.7 * 8.8541878128e-12, tolerance = 1e-11;
constexpr double whole_gap = length - 2 * n * radius;

/// scenes/broken-wire.toml with `left` spheres at the left electrode's potential, and all of the gap after them. The
/// rest of the spheres touch.
laplace::LaplaceProblem wire(int left, double voltage, double transverse) {
  using enum laplace::Side::Kind;
  laplace::LaplaceProblem problem;
  problem.size = {length + 2 * end, height};
  problem.permittivity = permittivity;
  problem.sides[laplace::bottom] = {.kind = electrode, .potential = -0.5 * transverse};
  problem.sides[laplace::top] = {.kind = electrode, .potential = 0.5 * transverse};
  problem.groups = {{.floating = false, .potential = 0.5 * voltage}, {.floating = false, .potential = -0.5 * voltage}};
  for (int i = 0; i < n; ++i) {
    const double x = end + radius + 2 * radius * i + (i < left ? 0 : whole_gap);
    problem.bodies.push_back({Disk{{x, 0.5 * height}, radius}, i < left ? 0 : 1});
  }
  problem.bodies.push_back({Disk{{0, 0.5 * height}, end}, 0});
  problem.bodies.push_back({Disk{{length + 2 * end, 0.5 * height}, end}, 1});
  return problem;
}

/// N, across the wire, a sphere: mean over the n + 1 places of the gap.
std::vector<double> mean_forces(int cells, double voltage, double transverse) {
  laplace::CutCellSolver solver({.cells = cells, .tolerance = tolerance});
  std::vector<double> force(n);
  for (int left = 0; left <= n; ++left) {
    const auto solution = solver.solve(wire(left, voltage, transverse));
    for (int i = 0; i < n; ++i) force[i] += depth * solution.body_force[i].y / (n + 1);
  }
  return force;
}

double largest(const std::vector<double>& values) { return spread(values).worst; }

void transverse_forces(Report& report, int cells) {
  report.section(fmt::format("mean transverse force, S = {}", cells));
  const std::vector<double> force = mean_forces(cells, 18e3, 2e3), doubled = mean_forces(cells, 18e3, 4e3),
                            halved = mean_forces(cells, 9e3, 2e3);
  std::vector<double> odd, in_field, in_voltage;
  double product = 0, square = 0;
  for (int i = 0; i < n; ++i) {
    odd.push_back(force[i] + force[n - 1 - i]);
    in_field.push_back(doubled[i] - 2 * force[i]);
    in_voltage.push_back(2 * halved[i] - force[i]);
    const double line = n + 1 - 2 * (i + 1);
    product += force[i] * line;
    square += line * line;
  }
  // A straight wire is its own mirror image, so the force across it is bilinear in the two voltages; turning it round
  // and changing all signs leaves it as it is. What is left is the solver's tolerance, relative to the largest stress:
  // that of 18 kV in the gap, some hundred times the transverse force. Each of the forces that are added or subtracted
  // has that error, times its factor.
  const double rounding = 1e3 * tolerance;
  report.at_most("odd about the middle, fraction of the largest", largest(odd) / largest(force), 2 * rounding);
  report.at_most("twice as large in twice the transverse field", largest(in_field) / largest(force), 3 * rounding);
  report.at_most("half as large at half the voltage (D 4.8)", largest(in_voltage) / largest(force), 3 * rounding);
  std::vector<double> off_line;
  for (int i = 0; i < n; ++i) off_line.push_back(force[i] - product / square * (n + 1 - 2 * (i + 1)));
  report.at_most("off D 4.10's straight line, fraction of the largest", largest(off_line) / largest(force), {});
  // 4.10's slope is C V E / 2(N + 1).
  const double field = -2e3 / height, capacitance = product / square * 2 * (n + 1) / (18e3 * field);
  const double free = 4 * std::numbers::pi * permittivity * radius;
  report.at_most("C of a sphere in 4.10, over 4 pi eps R", capacitance / free, {});
  // Gaps that are all alike, each with its share of the voltage: what the runs of scenes/broken-wire.toml are like.
  const theory::BrokenWire disks = {n, radius, length, 18e3, permittivity, capacitance};
  const theory::DiskPair pair = {{{0, 0}, radius}, {{2 * radius + disks.mean_gap(), 0}, radius}, permittivity};
  const double pull = depth * norm(theory::force(pair, 18e3 / (n + 1) * theory::capacitance(pair)));
  const double b = theory::shape_coefficient(disks, -field, pull);
  report.at_most("tension of 26 equal gaps, 18 kV / 26 each, N", pull, {});
  report.at_most("its B at 2 kV, 1/m^2", b, {});
  report.at_most("its largest displacement at 2 kV, mm", 1e3 * theory::largest_displacement(disks, b), {});
}

/// The force across the gap, beside that of two disks alone: the rest of the wire and the other electrodes change it.
void tensions(Report& report, int cells) {
  report.section("tension across the gap in the middle, N");
  laplace::CutCellSolver solver({.cells = cells, .tolerance = tolerance});
  const auto solution = solver.solve(wire(12, 18e3, 0));
  double pull = 0;  // on all that is left of the gap, the half-disk's side being held
  for (int i = 0; i < 12; ++i) pull += depth * solution.body_force[i].x;
  const theory::DiskPair pair = {{{0, 0}, radius}, {{2 * radius + whole_gap, 0}, radius}, permittivity};
  const double alone = depth * norm(theory::force(pair, 18e3 * theory::capacitance(pair)));
  const theory::BrokenWire spheres = {n,    radius,       length,
                                      18e3, permittivity, 4 * std::numbers::pi * permittivity * radius};
  report.at_most("on the left half", pull, {});
  report.at_most("two disks alone", alone, {});
  report.at_most("D 4.13, spheres, the whole gap", theory::tension(spheres, whole_gap), {});
  report.at_most("close spheres at 18 kV", theory::close_spheres_attraction(radius, permittivity, whole_gap, 18e3), {});
}

}  // namespace

int validate(int argc, char** argv) {
  const int cells = asked_for_long(argc, argv) ? 672 : 168;
  Report report("The broken wire: forces from the field, averaged over the places of the gap");
  transverse_forces(report, cells);
  tensions(report, cells);
  return report.exit_status();
}

const lichtenberg::validation::Program program("broken_wire", validate);

}  // namespace broken_wire_validation
