// Compares the realised error with the requested accuracy. References: the spectral solver at 1e-12, the cases in
// data/reference-disks and, for bars and rings, much finer grids.
//
//   accuracy         seconds
//   accuracy long    fifty times as many random scenes, and finer accuracies on grids; minutes

#include <chrono>
#include <random>

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "validation/program.hpp"
#include "validation/reference_cases.hpp"

namespace accuracy_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

class Random {
 public:
  explicit Random(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  double operator()(double from, double to) {
    return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  bool chance(double p) { return (*this)(0, 1) < p; }

 private:
  std::mt19937_64 engine_;
};

/// Returns a box with random sides and, in some cases, a half-disk at the bottom's potential.
LaplaceProblem random_box(Random& random) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, random.chance(0.7) ? 1.0 : 0.5};
  const bool electrodes = random.chance(0.6);
  for (Side& side : problem.sides)
    if (electrodes && random.chance(0.4)) side = {Side::Kind::electrode, random.chance(0.5) ? 0.0 : random(-1, 1), {}};
  if (random.chance(0.5)) {
    const Side& below = problem.sides[bottom];
    problem.bodies.push_back({Disk{{0.5, 0}, random(0.02, 0.1)}, 0});
    problem.groups.push_back({false, 0, below.kind == Side::Kind::electrode ? below.potential : 0});
  }
  return problem;
}

/// Returns a position for a disk with a distance of at least `least_gap` to all bodies and sides. Every other attempt
/// has exactly that gap from a neighbour.
std::optional<Vec2> random_centre(Random& random, const LaplaceProblem& problem, double radius, double least_gap) {
  const Vec2 size = problem.size;
  const double margin = radius + least_gap;
  for (int attempt = 0; attempt < 2000; ++attempt) {
    Vec2 p{random(margin, size.x - margin), random(margin, size.y - margin)};
    if (!problem.bodies.empty() && random.chance(0.5)) {
      const Body& neighbour = problem.bodies[static_cast<std::size_t>(random(0, 1) * problem.bodies.size())];
      const Disk& disk = std::get<Disk>(neighbour.shape);
      const double angle = random(0, 2 * M_PI), distance = disk.radius + radius + least_gap * (1 + 1e-7);
      p = disk.centre + distance * Vec2{std::cos(angle), std::sin(angle)};
    }
    const bool inside = p.x >= margin && p.y >= margin && p.x <= size.x - margin && p.y <= size.y - margin;
    const auto clear = [&](const Body& body) { return gap(Disk{p, radius}, body.shape) >= least_gap; };
    if (inside && std::ranges::all_of(problem.bodies, clear)) return p;
  }
  return {};
}

/// Returns 2 to 60 disks, equal or with radii from 1 to 3 units, gaps from 0.01 radius; some float, some are fixed,
/// some form groups.
LaplaceProblem random_problem(int seed) {
  Random random(seed);
  LaplaceProblem problem = random_box(random);
  const int count = 2 + static_cast<int>(std::pow(10, random(0, 1.76)));
  const double largest = std::min(random(0.03, 0.1), 0.3 * std::sqrt(problem.size.x * problem.size.y / count));
  const double smallest = random.chance(0.5) ? largest : largest / 3;
  const double least_gap = smallest * std::pow(10, random(-2, 0));
  for (int k = 0; k < count; ++k) {
    const double radius = random(smallest, largest);
    const std::optional<Vec2> centre = random_centre(random, problem, radius, least_gap);
    if (!centre) break;
    const bool joins = problem.groups.size() > 1 && random.chance(0.2), held = random.chance(0.15);
    if (!joins) problem.groups.push_back({!held, held ? 0 : random(-1, 1), held ? random(-1, 1) : 0});
    problem.bodies.push_back({Disk{*centre, radius}, static_cast<int>(problem.groups.size()) - 1});
  }
  if (problem.has_ground()) return problem;
  double total = 0;
  for (const Group& group : problem.groups) total += group.charge;
  for (Group& group : problem.groups) group.charge -= total / static_cast<double>(problem.groups.size());
  return problem;
}

struct Trial {
  std::string name;
  LaplaceProblem problem{.permittivity = 1};
  LaplaceSolution reference;
};

std::vector<Trial> random_trials(int count) {
  std::vector<Trial> trials;
  for (int seed = 1; seed <= count; ++seed) {
    Trial trial{"", random_problem(seed), {}};
    trial.reference = MultipoleSolver({.tolerance = 1e-12}).solve(trial.problem);
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<Trial> reference_trials() {
  std::vector<Trial> trials;
  for (const Reference& found : read_all()) {
    Trial trial{found.name, found.problem, {}};
    const json& data = found.data["reference"];
    trial.reference.group_potential.resize(found.problem.groups.size());
    for (std::size_t b = 0; b < found.problem.bodies.size(); ++b) {
      trial.reference.group_potential[found.problem.bodies[b].group] = data["phi_disk"][b];
      trial.reference.body_charge.push_back(data["Q_disk"][b]);
      trial.reference.body_force.push_back({data["force"][b][0], data["force"][b][1]});
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

/// Returns scenes with a bar between two disks at its ends' height, in a dish, in a box, and in a box whose sides cut
/// the rim.
std::vector<Trial> trials_of_other_shapes(int cells) {
  const std::vector<Body> disks = {
      {Disk{{0.3, 0.55}, 0.05}, 0}, {Disk{{0.62, 0.7}, 0.06}, 1}, {Disk{{0.7, 0.4}, 0.04}, 2}};
  const std::vector<Group> groups = {{true, 1, 0}, {true, -0.5, 0}, {true, 0.3, 0}, {false, 0, 0}};
  const Body bar{Bar{{0.45, 0.2}, {0.5, 0.6}, 0.04}, 3}, rim{Ring{{0.5, 0.5}, 0.5}, 3};
  std::vector<Trial> trials;
  for (const auto& [name, others] : {std::pair{"bar", std::vector{bar}}, std::pair{"rim", std::vector{rim}},
                                     std::pair{"bar and rim", std::vector{bar, rim}}}) {
    Trial trial{name, {.permittivity = 1}, {}};
    trial.problem.size = {1, 1};
    trial.problem.bodies = disks;
    trial.problem.bodies.insert(trial.problem.bodies.end(), others.begin(), others.end());
    trial.problem.groups = groups;
    trial.reference = CutCellSolver({.cells = cells, .tolerance = 1e-10}).solve(trial.problem);
    trials.push_back(std::move(trial));
  }
  return trials;
}

/// Adds one row: the worst ratio of realised to requested error of the trials, which must be at most 1.
void check_accuracy(Report& report, const std::string& what, const std::vector<Trial>& trials,
                    AccuracyRequest request) {
  std::vector<double> ratio;
  int refused = 0;
  const auto start = std::chrono::steady_clock::now();
  for (const Trial& trial : trials) {
    try {
      const AccurateSolution found = solve_to_accuracy(trial.problem, request);
      const Scales scales = scales_of(trial.problem, trial.reference);
      ratio.push_back(largest_error(trial.problem, found.solution, trial.reference, scales) / request.accuracy);
    } catch (const InputError&) {
      ++refused;
    }
  }
  if (ratio.empty()) ratio.push_back(INFINITY);  // without solutions the row fails
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.at_most(fmt::format("{} {:g}: {} ({} refused), {:.1f} s", what, request.accuracy, trials.size() - refused,
                             refused, seconds),
                 spread(ratio), 1.0);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Requested accuracy: realised error over requested error");

  const std::vector<Trial> random = random_trials(all ? 400 : 8);
  report.section("random disks, grids of at most 1024 cells a side");
  for (const double accuracy : {1e-2, 1e-3})
    check_accuracy(report, "cut-cell", random, {.accuracy = accuracy, .method = Method::cut_cell, .most_cells = 1024});
  if (all)
    check_accuracy(report, "cut-cell", random, {.accuracy = 1e-4, .method = Method::cut_cell, .most_cells = 3072});
  report.section("random disks, spectral");
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8})
    check_accuracy(report, "multipole", random, {.accuracy = accuracy, .method = Method::multipole});
  report.section("random disks, the cheaper method");
  for (const double accuracy : {1e-2, 1e-3, 1e-4}) check_accuracy(report, "either", random, {.accuracy = accuracy});

  report.section("reference cases (in the plane: grids only, sides at the exact potential)");
  const std::vector<Trial> cases = reference_trials();
  check_accuracy(report, "either", cases, {.accuracy = 1e-2});
  check_accuracy(report, "either", cases, {.accuracy = 1e-3});
  if (all) check_accuracy(report, "either", cases, {.accuracy = 1e-4, .most_cells = 3072});

  report.section(fmt::format("bars and rims, against {} cells", all ? 4096 : 1024));
  const std::vector<Trial> others = trials_of_other_shapes(all ? 4096 : 1024);
  check_accuracy(report, "cut-cell", others, {.accuracy = 1e-2, .most_cells = all ? 1024 : 512});
  if (all) check_accuracy(report, "cut-cell", others, {.accuracy = 3e-3, .most_cells = 1024});
  return report.exit_status();
}

const lichtenberg::validation::Program program("accuracy", validate);

}  // namespace accuracy_validation
