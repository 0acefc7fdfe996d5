// Random scenes with a requested accuracy: checks the error of every potential, charge and force. In the plane, cut
// cells and multipoles are compared with multipoles at 1e-13. In space, spheres are compared with spheres at 1e-11.
// Each seed gives a scene of 1, 2, 3, 10 or 30 bodies: all neutral, all charged, or some at fixed potentials.
//
//   accuracy_asked               the first 10 seeds of each method: seconds
//   accuracy_asked long          500 in the plane and 500 in space
//   accuracy_asked FROM TO       seeds FROM to TO of these

#include <array>
#include <cstdlib>
#include <map>

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "solvers/random.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace accuracy_asked_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

constexpr std::array counts = {1, 2, 3, 10, 30};
constexpr double permittivity = 4.16e-11;  // F/m

double pick(Random& random, std::initializer_list<double> values) {
  return values.begin()[static_cast<int>(random.uniform(0, static_cast<double>(values.size())))];
}

double logarithmic(Random& random, double low, double high) { return low * std::pow(high / low, random.uniform(0, 1)); }

/// Groups of a scene: all neutral, all charged, or some of them at fixed potentials.
enum class Kind { neutral, charged, mixed };

/// Returns a random group. `unit`: scale of the charges.
Group random_group(Random& random, Kind kind, double unit) {
  if (kind == Kind::neutral) return {.charge = 0};
  const double charge = unit * random.uniform(-1, 1);
  if (kind == Kind::charged) return {.charge = charge};
  if (random.uniform(0, 1) < 0.3) return {.floating = false, .potential = pick(random, {0, 0, 50, -400})};
  return {.charge = random.uniform(0, 1) < 0.5 ? charge : 0};
}

/// Makes the total charge zero, as a scene without ground requires.
void neutralize(std::vector<Group>& groups) {
  double total = 0;
  for (const Group& group : groups) total += group.charge;
  for (Group& group : groups) group.charge -= total / static_cast<double>(groups.size());
}

/// Box of `dimension` axes. Its bodies of radii `radius` are at least `gap` apart from each other and from the sides.
struct Packing {
  int dimension;
  std::array<double, 3> size{};
  double gap = 0;
  std::vector<std::array<double, 3>> centres{};
  std::vector<double> radii{};

  double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) const {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  bool is_free(const std::array<double, 3>& p, double radius) const {
    for (int k = 0; k < dimension; ++k)
      if (std::min(p[k], size[k] - p[k]) < radius + gap) return false;
    for (std::size_t i = 0; i < radii.size(); ++i)
      if (distance(p, centres[i]) < radius + radii[i] + gap) return false;
    return true;
  }

  /// Adds a body at a random position, or at the gap from another one.
  void add(Random& random, double radius) {
    for (int attempt = 0; attempt < 10000; ++attempt) {
      std::array<double, 3> p{};
      for (int k = 0; k < dimension; ++k) p[k] = random.uniform(0, size[k]);
      if (!radii.empty() && random.uniform(0, 1) < 0.3) {
        const auto other = static_cast<std::size_t>(random.uniform(0, static_cast<double>(radii.size())));
        const double away = distance(p, centres[other]), wanted = radius + radii[other] + 1.001 * gap;
        for (int k = 0; k < dimension; ++k) p[k] = centres[other][k] + (p[k] - centres[other][k]) * (wanted / away);
      }
      if (!is_free(p, radius)) continue;
      centres.push_back(p);
      radii.push_back(radius);
      return;
    }
  }
};

/// Returns a box with `count` bodies.
Packing random_packing(Random& random, int dimension, int count) {
  const double radius = logarithmic(random, 3e-4, 1e-3), ratio = pick(random, {1, 1, 1.4, 3});
  Packing packing{.dimension = dimension};
  const double side = radius * logarithmic(random, 10 + 1.5 * count, 60 + 1.5 * count);
  for (int k = 0; k < dimension; ++k) packing.size[k] = side;
  if (random.uniform(0, 1) < 0.3) packing.size[dimension - 1] = side / 2;
  packing.gap = radius / ratio * logarithmic(random, 0.03, 1);
  for (int n = 0; n < count; ++n) packing.add(random, radius / random.uniform(1, ratio));
  return packing;
}

/// Puts bodies of fixed groups last, as electrodes are. Returns the number of the other bodies.
template <class Body>
int free_first(std::vector<Body>& bodies, const std::vector<Group>& groups) {
  const auto held =
      std::ranges::stable_partition(bodies, [&](const Body& body) { return groups[body.group].floating; });
  return static_cast<int>(bodies.size() - held.size());
}

Random random_of(int seed, int dimension) {
  return Random({.seed = static_cast<std::uint64_t>(10 * seed + dimension), .purpose = RandomPurpose::population});
}

int count_of(int seed) { return counts[seed % counts.size()]; }
Kind kind_of(int seed) { return static_cast<Kind>(seed / counts.size() % 3); }

LaplaceProblem random_plane(int seed) {
  Random random = random_of(seed, 2);
  const Packing packing = random_packing(random, 2, count_of(seed));
  LaplaceProblem problem{.size = {packing.size[0], packing.size[1]}, .permittivity = permittivity};
  const double potential = logarithmic(random, 5, 2000), held = pick(random, {0, 0.3, 1});
  for (int side = 0; side < 4; ++side)
    if (side < 2 || random.uniform(0, 1) < held)
      problem.sides[side] = {Side::Kind::electrode, pick(random, {0, potential, -potential}), {}};
  if (kind_of(seed) == Kind::charged && random.uniform(0, 1) < 0.3) problem.sides = {};
  if (kind_of(seed) == Kind::neutral) problem.sides[left].potential = potential + problem.sides[right].potential;
  const double unit = permittivity * logarithmic(random, 10, 1000);
  for (std::size_t i = 0; i < packing.radii.size(); ++i) {
    if (i == 0 || random.uniform(0, 1) > 0.1) problem.groups.push_back(random_group(random, kind_of(seed), unit));
    problem.bodies.push_back({Disk{{packing.centres[i][0], packing.centres[i][1]}, packing.radii[i]},
                              static_cast<int>(problem.groups.size()) - 1});
  }
  if (!problem.has_ground()) neutralize(problem.groups);
  problem.movable = free_first(problem.bodies, problem.groups);
  return problem;
}

SphereProblem random_space(int seed) {
  Random random = random_of(seed, 3);
  const Packing packing = random_packing(random, 3, count_of(seed));
  SphereProblem problem{.permittivity = permittivity};
  problem.box.lengths = {packing.size[0], packing.size[1], packing.size[2]};
  const double potential = logarithmic(random, 5, 2000), sides = random.uniform(0, 1);
  problem.free_space = kind_of(seed) != Kind::neutral && sides < 0.3;
  const auto hold = [&](int side, double value) {
    problem.box.sides[side] = Boundary::electrode;
    problem.side_potential[side] = value;
  };
  if (kind_of(seed) == Kind::neutral || sides > 0.6)  // two plates
    hold(0, 0), hold(1, potential);
  else
    for (int side = 0; side < 6; ++side)
      if (random.uniform(0, 1) < 0.3) hold(side, potential);
  const double unit = permittivity * packing.radii[0] * logarithmic(random, 10, 1000);
  for (std::size_t i = 0; i < packing.radii.size(); ++i) {
    if (i == 0 || random.uniform(0, 1) > 0.1) problem.groups.push_back(random_group(random, kind_of(seed), unit));
    problem.spheres.push_back({{packing.centres[i][0], packing.centres[i][1], packing.centres[i][2]},
                               packing.radii[i],
                               static_cast<int>(problem.groups.size()) - 1});
  }
  if (!problem.has_ground()) neutralize(problem.groups);
  problem.movable = free_first(problem.spheres, problem.groups);
  return problem;
}

/// Ratios of realised to requested error, by method and number of bodies.
class Rows {
 public:
  void add(const std::string& method, int seed, double requested, double error) {
    row(method, seed).ratio.add(error / requested, static_cast<std::uint64_t>(seed));
    if (!(error <= requested))
      fmt::print("seed {}: {} with a requested error of {:g} has {:.3g} times that error\n", seed, method, requested,
                 error / requested);
  }
  void add_refusal(const std::string& method, int seed) { ++row(method, seed).refused; }
  /// Prints the rows. Cut cells may refuse an accuracy, because their grids are bounded here.
  void print(Report& report) const {
    for (const auto& [name, row] : rows_) {
      const std::size_t requested = row.ratio.values.size() + static_cast<std::size_t>(row.refused);
      report.at_most(name, spread(row.ratio.values), 1, fmt::format("{}, {} refused", row.ratio.note(), row.refused));
      if (!name.starts_with("cut-cell"))
        report.at_most(name + ", refused of " + std::to_string(requested), row.refused, 0);
    }
  }

 private:
  struct Row {
    SampleBySeed ratio;
    int refused = 0;
  };
  Row& row(const std::string& method, int seed) { return rows_[fmt::format("{}, {} bodies", method, count_of(seed))]; }
  std::map<std::string, Row> rows_;
};

void check_in_plane(Rows& rows, int seed) {
  const LaplaceProblem problem = random_plane(seed);
  const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-13}).solve(problem);
  const Scales scales = scales_of(problem, exact);
  const auto check = [&](const std::string& method, const AccuracyRequest& request) {
    try {
      const LaplaceSolution found = solve_to_accuracy(problem, request).solution;
      rows.add(method, seed, request.accuracy, largest_error(problem, found, exact, scales));
    } catch (const InputError&) {
      rows.add_refusal(method, seed);
    }
  };
  Random random({.seed = static_cast<std::uint64_t>(seed), .purpose = RandomPurpose::exchange});
  const double coarse = pick(random, {3e-2, 1e-2, 1e-2, 3e-3, 1e-3}),
               fine = pick(random, {1e-1, 1e-2, 1e-3, 1e-4, 1e-6});
  check("cut-cell", {.accuracy = coarse, .method = Method::cut_cell, .most_cells = 1536});
  check("multipole", {.accuracy = fine, .method = Method::multipole});
}

void check_in_space(Rows& rows, int seed) {
  const SphereProblem problem = random_space(seed);
  const SphereSolution exact = SphereSolver({.accuracy = 1e-11}).solve(problem);  // narrow gaps do not permit 1e-12
  const Scales scales = scales_of(problem, exact);
  Random random({.seed = static_cast<std::uint64_t>(seed), .purpose = RandomPurpose::exchange});
  const double accuracy = pick(random, {1e-1, 1e-2, 1e-3, 1e-4, 1e-6});
  try {
    const AccurateSpheres found =
        solve_to_accuracy(problem, accuracy, [](double tolerance) { return SphereSolver({.accuracy = tolerance}); });
    rows.add("spheres", seed, accuracy, largest_error(problem, found.solution, exact, scales));
  } catch (const InputError&) {
    rows.add_refusal("spheres", seed);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  const int from = argc > 2 ? std::atoi(argv[1]) : 0, to = argc > 2 ? std::atoi(argv[2]) : all ? 500 : 10;
  Report report("Random scenes: realised error over requested error");
  Rows rows;
  for (int seed = from; seed < to; ++seed) {
    check_in_plane(rows, seed);
    check_in_space(rows, seed);
  }
  report.section("realised over requested error");
  rows.print(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("accuracy_asked", validate);

}  // namespace accuracy_asked_validation
