// Principles of chapter 3: resistance of a pair of conductors and its gradient (D 3.8-3.10), trajectories of decreasing
// resistance (D 3.11), and the potential of minimal dissipated power (D 3.1).
//
// In a fluid of conductivity sigma and permittivity eps, the current from a conductor is sigma/eps times its charge.
// Resistance and capacitance (per metre of depth) are therefore equivalent: R = eps / (sigma C). The force between two
// conductors at given charge is -grad Q^2 / 2C = -(sigma / 2 eps) Q^2 grad R (D 3.10). D 3.8 has wrong dimensions; the
// gradient of D 3.9 is Q^2 / (2 pi eps sqrt(D^2 - 4 R^2)). The M in D 3.11 is superfluous: gamma dr/dt = F.
//
//   minimum_resistance         S = 256
//   minimum_resistance long    S = 256 ... 1024

#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/scene.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace minimum_resistance_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

constexpr double pi = 3.14159265358979323846;

/// Returns two disks of radius 1 at distance d in a box of 16, with the exact potential on its walls.
LaplaceProblem pair_at(double d) {
  const Vec2 middle = {8.03, 7.96}, half = {0.5 * d, 0};
  return in_plane({{middle + half, 1}, {middle - half, 1}, 1}, {16, 16}, 1);
}

/// Returns R sigma between two disks with charges +1 and -1, eps = 1.
double resistance(LaplaceSolver& solver, double d) {
  const LaplaceSolution solution = solver.solve(pair_at(d));
  return solution.group_potential[0] - solution.group_potential[1];
}

/// Tests the resistance and force law against the field solver at a radius of S / 16 cells. Bounds: twice those of
/// two_disks for capacitance and force at these distances and eight cells per radius, scaled with the square of the
/// cell.
void pair_law(Report& report, int cells) {
  report.section(fmt::format("Pair of disks, S = {}: % off theory", cells));
  CutCellSolver solver({.cells = cells, .tolerance = 1e-10});
  const double finer = std::pow(8 * 16.0 / cells, 2);
  for (const double ratio : {1.25, 2.0, 3.0}) {
    const double d = 2 * ratio, step = 0.02 * (d - 2);
    const double r = resistance(solver, d), exact = std::acosh(ratio) / pi;
    const double force = solver.solve(pair_at(d)).body_force[0].x;
    // Slope of the solver's own resistance; the error of a central difference is step^2 R''' / 6R'.
    const double slope = (resistance(solver, d + step) - resistance(solver, d - step)) / (2 * step);
    const std::string label = fmt::format("D/2R = {}", ratio);
    const bool close = ratio < 2;
    report.at_most(label + ", resistance (D 3.9)", 100 * std::abs(r / exact - 1), (close ? 0.3 : 0.04) * finer);
    report.at_most(label + ", force (D 3.8, corrected)", 100 * std::abs(-force * 2 * pi * std::sqrt(d * d - 4) - 1),
                   (close ? 1.2 : 0.2) * finer);
    report.at_most(label + ", force and slope of resistance (D 3.10)", 100 * std::abs(-force / (0.5 * slope) - 1),
                   (close ? 1.2 : 0.2) * finer + 0.05);
  }
}

/// Returns the integral of sqrt(D^2 - 4 R^2) dD. By D 3.11 with D 3.9 it decreases at the rate q^2 depth / (pi eps
/// gamma), with q the charge per metre of depth.
double progress(double d, double radius) {
  const double root = std::sqrt(d * d - 4 * radius * radius);
  return 0.5 * d * root - 2 * radius * radius * std::log((d + root) / (2 * radius));
}

/// Tests scenes/pair.toml. Walls: the pair's field decays like a dipole's, so its images at the box's width L change
/// the force by a fraction of about pi (D/L)^2. Inertia delays the spheres by a relaxation time m / gamma.
void pair_trajectory(Report& report) {
  report.section("scenes/pair.toml");
  const Scene scene = read_scene(source_folder() + "/scenes/pair.toml");
  Simulation simulation(scene);
  const double radius = scene.conductors[0].radius, depth = scene.medium.depth;
  const double drag = 6 * pi * scene.medium.viscosity * radius;
  const double lag = 4.0 / 3 * pi * scene.material.density * std::pow(radius, 3) / drag;
  const double q = scene.conductors[0].charge / depth;
  const double rate = q * q * depth / (pi * scene.medium.permittivity * drag);
  const auto distance = [](const ConductorFrame& frame) { return norm(frame.position[1] - frame.position[0]); };
  const double start = distance(simulation.now());
  const double walls = pi * std::pow(start / scene.domain.size.x, 2);

  std::vector<double> off;
  double before = INFINITY, largest_rise = -INFINITY;
  for (double t = 0.02; t < scene.stop.time; t += 0.02) {
    simulation.advance_to(t);
    const ConductorFrame frame = simulation.now();
    const double d = distance(frame);
    // Relative deviation of the elapsed time.
    off.push_back(100 * std::abs((progress(start, radius) - progress(d, radius)) / rate / (t - lag) - 1));
    const double r = (frame.potential[0] - frame.potential[1]) / q;
    largest_rise = std::max(largest_rise, r / before - 1);
    before = r;
  }
  off.erase(off.begin(), off.begin() + 4);  // the delay reaches the relaxation time only after acceleration
  report.at_most("time to come so close (D 3.11), % off", spread(off), 100 * walls + 0.1);
  report.at_most("largest rise of the resistance from frame to frame", largest_rise, 0);
}

/// Returns `count` neutral conductors in oil between two plates at 18 kV, at least 1.5 radii apart. The scene uses the
/// spectral method, because a grid's energy jumps by 1e-4 if a disk covers another cell centre.
std::string neutral_conductors(int count) {
  std::string text = R"(
[domain]
size = [0.02, 0.02]
left = { potential = 18e3 }
right = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[material]
density = 80.0
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[field]
method = "multipole"
[stop]
stationary = false
)";
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(0.003, 0.017);
  std::vector<Vec2> placed;
  while (static_cast<int>(placed.size()) < count) {
    const Vec2 p{coordinate(random), coordinate(random)};
    if (!std::ranges::all_of(placed, [&](Vec2 other) { return norm(p - other) > 3.5 * 0.775e-3; })) continue;
    placed.push_back(p);
    text += fmt::format("[[conductor]]\nposition = [{}, {}]\nradius = 0.775e-3\n", p.x, p.y);
  }
  return text;
}

double narrowest_gap(const ConductorFrame& frame, double radius) {
  double narrowest = INFINITY;
  for (std::size_t i = 0; i < frame.position.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      narrowest = std::min(narrowest, norm(frame.position[i] - frame.position[j]) - 2 * radius);
  return narrowest;
}

/// Tests the general theorem. At given electrode potentials and without charges of their own, forces on conductors are
/// +grad of the field's energy C V^2 / 2. With drag alone, dC/dt = 2/V^2 sum F^2 / gamma >= 0: the resistance between
/// the electrodes decreases. This holds until surfaces touch and exchange charge, which they keep after the contact
/// opens.
void many_conductors(Report& report) {
  report.section("Twelve neutral conductors between plates");
  const Scene scene = parse_scene(neutral_conductors(12), "neutral.toml");
  const double radius = scene.conductors[0].radius;
  Simulation simulation(scene);
  ConductorFrame before = simulation.now();
  const double start = before.energy;
  double largest_fall = -INFINITY, time = 0;
  while (time < 1) {
    simulation.advance_to(time += 2e-4);
    const ConductorFrame frame = simulation.now();
    if (narrowest_gap(frame, radius) < 0.1 * radius) break;
    largest_fall = std::max(largest_fall, (before.energy - frame.energy) / start);
    before = frame;
  }
  fmt::print("followed for {:.4g} s, until a gap was below a tenth of a radius\n", time);
  report.at_least("resistance at the start, in units of that at the end", before.energy / start, 1 + 1e-3);
  report.at_most("largest rise of the resistance from frame to frame", largest_fall, 0);
}

/// D 3.1: if a neutral conductor's potential is fixed at a deviation delta from its floating value, the power increases
/// by C_gg delta^2 sigma / eps without a linear term. The minimum is where current is conserved.
void least_power(Report& report) {
  report.section("Power of the true potential (D 3.1)");
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.sides[left] = {.kind = Side::Kind::electrode, .potential = 1};
  problem.sides[right] = {.kind = Side::Kind::electrode, .potential = 0};
  problem.bodies = {{Disk{{0.3, 0.4}, 0.1}, 0}, {Disk{{0.62, 0.55}, 0.12}, 1}};
  problem.groups.resize(2);
  CutCellSolver solver({.cells = 128, .tolerance = 1e-12});
  const LaplaceSolution least = solver.solve(problem);
  const std::vector<double> c = capacitance_matrix(solver, problem);
  for (const double delta : {-0.1, -0.01, 0.01, 0.1}) {
    LaplaceProblem held = problem;
    held.groups[0] = {.floating = false, .potential = least.group_potential[0] + delta};
    held.groups[1] = {.floating = false, .potential = least.group_potential[1]};
    const double more = solver.solve(held).energy - least.energy;
    report.at_least(fmt::format("power with a potential {:+} V off, less that of the true one", delta), more, 0);
    // Energies have a relative error of the tolerance squared, charges of the tolerance.
    report.at_most("  against C_gg delta^2 / 2, relative", std::abs(more / (0.5 * c[0] * delta * delta) - 1),
                   1e-10 * least.energy / more + 1e-6);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Minimum resistance, minimum power (D chapter 3)");
  for (const int cells : long_run_requested(argc, argv) ? std::vector<int>{256, 512, 1024} : std::vector<int>{256})
    pair_law(report, cells);
  pair_trajectory(report);
  many_conductors(report);
  least_power(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("minimum_resistance", validate);

}  // namespace minimum_resistance_validation
