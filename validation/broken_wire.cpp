// Forces on D's broken wire (D 4.8-4.13: 25 spheres between electrodes, one gap, a transverse field) by the field
// solver for each position of the gap. Compares their mean with symmetry requirements and with the source's
// assumptions.
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

/// Returns scenes/broken-wire.toml with `left` spheres at the left electrode's potential and the whole gap after them.
/// The other spheres touch each other.
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

/// Returns the mean transverse force (N) on each sphere over the n + 1 positions of the gap.
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
  // A straight wire is its own mirror image, so the transverse force is bilinear in the two voltages. Reversal of the
  // wire and of all signs leaves it unchanged. The remainder is the solver's tolerance, relative to the largest stress:
  // that of 18 kV across the gap, about a hundred times the transverse force. Each added or subtracted force
  // contributes this error times its factor.
  const double rounding = 1e3 * tolerance;
  report.at_most("odd about the middle, fraction of the largest", largest(odd) / largest(force), 2 * rounding);
  report.at_most("twice as large in twice the transverse field", largest(in_field) / largest(force), 3 * rounding);
  report.at_most("half as large at half the voltage (D 4.8)", largest(in_voltage) / largest(force), 3 * rounding);
  std::vector<double> off_line;
  for (int i = 0; i < n; ++i) off_line.push_back(force[i] - product / square * (n + 1 - 2 * (i + 1)));
  report.at_most("off D 4.10's straight line, fraction of the largest", largest(off_line) / largest(force), {});
  // The slope of 4.10 is C V E / 2(N + 1).
  const double field = -2e3 / height, capacitance = product / square * 2 * (n + 1) / (18e3 * field);
  const double free = 4 * std::numbers::pi * permittivity * radius;
  report.at_most("C of a sphere in 4.10, over 4 pi eps R", capacitance / free, {});
  // Equal gaps with equal shares of the voltage, as in the runs of scenes/broken-wire.toml.
  const theory::BrokenWire disks = {n, radius, length, 18e3, permittivity, capacitance};
  const theory::DiskPair pair = {{{0, 0}, radius}, {{2 * radius + disks.mean_gap(), 0}, radius}, permittivity};
  const double tension = depth * norm(theory::force(pair, 18e3 / (n + 1) * theory::capacitance(pair)));
  const double b = theory::shape_coefficient(disks, -field, tension);
  report.at_most("tension of 26 equal gaps, 18 kV / 26 each, N", tension, {});
  report.at_most("its B at 2 kV, 1/m^2", b, {});
  report.at_most("its largest displacement at 2 kV, mm", 1e3 * theory::largest_displacement(disks, b), {});
}

/// Compares the force across the gap with that of two isolated disks. The rest of the wire and the electrodes change
/// it.
void tensions(Report& report, int cells) {
  report.section("tension across the gap in the middle, N");
  laplace::CutCellSolver solver({.cells = cells, .tolerance = tolerance});
  const auto solution = solver.solve(wire(12, 18e3, 0));
  double tension = 0;  // on all spheres left of the gap; the half-disk is fixed
  for (int i = 0; i < 12; ++i) tension += depth * solution.body_force[i].x;
  const theory::DiskPair pair = {{{0, 0}, radius}, {{2 * radius + whole_gap, 0}, radius}, permittivity};
  const double alone = depth * norm(theory::force(pair, 18e3 * theory::capacitance(pair)));
  const theory::BrokenWire spheres = {n,    radius,       length,
                                      18e3, permittivity, 4 * std::numbers::pi * permittivity * radius};
  report.at_most("on the left half", tension, {});
  report.at_most("two disks alone", alone, {});
  report.at_most("D 4.13, spheres, the whole gap", theory::tension(spheres, whole_gap), {});
  report.at_most("close spheres at 18 kV", theory::close_spheres_attraction(radius, permittivity, whole_gap, 18e3), {});
}

}  // namespace

int validate(int argc, char** argv) {
  const int cells = long_run_requested(argc, argv) ? 672 : 168;
  Report report("The broken wire: forces from the field, averaged over the positions of the gap");
  transverse_forces(report, cells);
  tensions(report, cells);
  return report.exit_status();
}

const lichtenberg::validation::Program program("broken_wire", validate);

}  // namespace broken_wire_validation
