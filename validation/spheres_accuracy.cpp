// Tests the requested accuracy of spheres in space: random scenes with gaps from 1e-5 R, compared with solutions at 1 %
// of the finest accuracy.
//
//   spheres_accuracy            seconds
//   spheres_accuracy long       twelve times as many scenes, 1e-3 and 1e-4: a minute

#include <array>
#include <map>

#include "solvers/laplace/spheres/spheres.hpp"
#include "solvers/random.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace spheres_accuracy_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

/// Smallest gap between spheres of different potential, in units of the smaller radius.
constexpr std::array gaps = {1e-5, 1e-4, 1e-3, 1e-2, 1e-1};

double pick(Random& random, std::initializer_list<double> values) {
  return values.begin()[static_cast<int>(random.uniform(0, static_cast<double>(values.size())))];
}

bool is_free(const SphereProblem& problem, Vec3 p, double radius, double gap) {
  for (int k = 0; k < 3; ++k)
    if (std::min(p[k], problem.box.lengths[k] - p[k]) < radius * (1 + 0.99 * gap)) return false;
  return std::ranges::all_of(problem.spheres, [&](const Sphere& other) {
    return norm(p - other.centre) >= radius + other.radius + 0.99 * gap * std::min(radius, other.radius);
  });
}

Vec3 direction(Random& random) {
  const Vec3 v{random.normal(), random.normal(), random.normal()};
  return v * (1 / norm(v));
}

/// Adds a sphere at a random position, or at the gap from another one or from a side.
void add_sphere(SphereProblem& problem, Random& random, double gap, double ratio) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const double radius = std::pow(ratio, -random.uniform(0, 1)), kind = random.uniform(0, 1);
    const Vec3 size = problem.box.lengths;
    Vec3 p{random.uniform(0, size.x), random.uniform(0, size.y), random.uniform(0, size.z)};
    if (kind < 0.6 && !problem.spheres.empty()) {
      const Sphere& other = problem.spheres[static_cast<int>(random.uniform(0, problem.spheres.size()))];
      p = other.centre + direction(random) * (radius + other.radius + gap * std::min(radius, other.radius));
    } else if (kind < 0.75) {
      const int axis = static_cast<int>(random.uniform(0, 3));
      const double height = radius * (1 + gap);
      p[axis] = random.uniform(0, 1) < 0.5 ? height : size[axis] - height;
    }
    if (!is_free(problem, p, radius, gap)) continue;
    problem.spheres.push_back({p, radius, static_cast<int>(problem.groups.size())});
    if (random.uniform(0, 1) < 0.25)
      problem.groups.push_back({.floating = false, .potential = pick(random, {500, -100, 70})});
    else
      problem.groups.push_back({.charge = pick(random, {0, 0, 4e3, -4e3, 40})});  // isolated: about 300 V, 3 V
    return;
  }
}

SphereProblem random_problem(std::uint64_t seed, double gap) {
  Random random({.seed = seed, .purpose = RandomPurpose::population});
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {20, 20, pick(random, {20, 20, 60})};
  const double potential = pick(random, {0, 100, -300});
  for (int side = 0; side < 6; ++side)
    if (random.uniform(0, 1) < 0.2) {
      problem.box.sides[side] = Boundary::electrode;
      problem.side_potential[side] = potential;
    }
  problem.groups.push_back({.floating = false, .potential = 70});
  problem.spheres.push_back({{random.uniform(4, 16), random.uniform(4, 16), random.uniform(4, 16)}, 1, 0});
  const double count = pick(random, {1, 2, 4, 7}), ratio = pick(random, {1, 1, 2, 4});
  for (int n = 0; n < count; ++n) add_sphere(problem, random, gap, ratio);
  return problem;
}

struct Errors {
  double potential = 0, charge = 0, force = 0;
  double worst() const { return larger(potential, larger(charge, force)); }
};

/// Returns errors relative to the largest value of each kind; for potentials, relative to the largest difference of any
/// two, including sides.
Errors errors_of(const SphereProblem& problem, const SphereSolution& found, const SphereSolution& exact) {
  double low = INFINITY, high = -INFINITY, charge = 0, force = 0;
  const auto include = [&](double potential) { low = std::min(low, potential), high = std::max(high, potential); };
  for (const double potential : exact.group_potential) include(potential);
  for (int side = 0; side < 6; ++side)
    if (problem.box.sides[side] == Boundary::electrode) include(problem.side_potential[side]);
  Errors errors;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    charge = std::max(charge, std::abs(exact.sphere_charge[i]));
    force = std::max(force, norm(exact.sphere_force[i]));
    const int g = problem.spheres[i].group;
    errors.potential = larger(errors.potential, std::abs(found.group_potential[g] - exact.group_potential[g]));
    errors.charge = larger(errors.charge, std::abs(found.sphere_charge[i] - exact.sphere_charge[i]));
    errors.force = larger(errors.force, norm(found.sphere_force[i] - exact.sphere_force[i]));
  }
  return {errors.potential / (high - low), errors.charge / charge, errors.force / force};
}

/// Ratios of realised to requested error for one gap and one accuracy.
struct Row {
  SampleBySeed potential, charge, force;
  long iterations = 0;

  void add(const Errors& errors, double accuracy, std::uint64_t seed) {
    potential.add(errors.potential / accuracy, seed);
    charge.add(errors.charge / accuracy, seed);
    force.add(errors.force / accuracy, seed);
  }
};

/// Bound on the ratio for forces. If large forces nearly cancel, such as those of two charges and of the gap between
/// them, the requested accuracy applies to each of these. The ratio for their sum then exceeds 1.
constexpr double most_of_forces = 5;

void compare(Report& report, double gap, int scenes, const std::vector<double>& accuracies) {
  std::map<double, Row> rows;
  for (int scene = 1; scene <= scenes; ++scene) {
    const auto seed = static_cast<std::uint64_t>(scene + std::lround(-1e3 * std::log10(gap)));
    const SphereProblem problem = random_problem(seed, gap);
    const SphereSolution exact = SphereSolver({.accuracy = accuracies.back() / 100}).solve(problem);
    for (const double accuracy : accuracies) {
      const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
      rows[accuracy].add(errors_of(problem, found, exact), accuracy, seed);
      rows[accuracy].iterations += found.iterations;
    }
  }
  for (const double accuracy : accuracies) {
    const Row& row = rows[accuracy];
    report.section(fmt::format("gaps of {:g} R, requested error {:g}: {} iterations", gap, accuracy, row.iterations));
    report.at_most("potentials", row.potential.largest, 1, row.potential.note());
    report.at_most("charges", row.charge.largest, 1, row.charge.note());
    report.at_most("forces", row.force.largest, most_of_forces, row.force.note());
  }
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Errors of spheres in space over the requested error");
  for (const double gap : gaps)
    compare(report, gap, all ? 12 : 1, all ? std::vector{1e-2, 1e-3, 1e-4} : std::vector{1e-2});
  return report.exit_status();
}

const lichtenberg::validation::Program program("spheres_accuracy", validate);

}  // namespace spheres_accuracy_validation
