// Measures the field of conducting spheres: time, iterations and memory of solves in a flat dish, in free space and in
// a moving scene.
//
//   benchmark_spheres [--spheres N] [--accuracy A] [--dish | --cloud] [--steps N] [--threads N] [--check]

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <ctime>

#include "solvers/laplace/spheres/spheres.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// Returns a random number in [0, 1), identical on all machines.
double uniform(std::uint64_t& state) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return static_cast<double>(state >> 11) * 0x1p-53;
}

bool is_free(const std::vector<Sphere>& spheres, Vec3 p, double radius, double gap) {
  for (const Sphere& other : spheres)
    if (norm(p - other.centre) < radius + other.radius + gap) return false;
  return true;
}

/// Returns steel spheres on the bottom of a dish of castor oil, 5.12 cm square for 324 spheres, 5 mm deep, with one
/// grounded side.
SphereProblem dish(int count, double gap) {
  SphereProblem problem{.permittivity = 4.7 * 8.8541878128e-12};
  const double radius = 0.8e-3, side = 5.12e-2 * std::sqrt(count / 324.0);
  problem.box.lengths = {side, side, 5e-3};
  problem.box.sides[0] = Boundary::electrode;
  std::uint64_t state = 1;
  while (static_cast<int>(problem.spheres.size()) < count) {
    const double margin = radius * (1 + gap);
    const Vec3 p{margin + (side - 2 * margin) * uniform(state), margin + (side - 2 * margin) * uniform(state), radius};
    if (is_free(problem.spheres, p, radius, gap * radius))
      problem.spheres.push_back({p, radius, static_cast<int>(problem.spheres.size())});
  }
  for (int i = 0; i < count; ++i) problem.groups.push_back({.charge = 1e-9 * (uniform(state) - 0.3)});
  return problem;
}

SphereProblem cloud(int count, double gap) {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  const double side = std::cbrt(count * 4.19 / 0.1);
  std::uint64_t state = 1;
  while (static_cast<int>(problem.spheres.size()) < count) {
    const Vec3 p{side * uniform(state), side * uniform(state), side * uniform(state)};
    if (is_free(problem.spheres, p, 1, gap))
      problem.spheres.push_back({p, 1, static_cast<int>(problem.spheres.size())});
  }
  for (int i = 0; i < count; ++i) problem.groups.push_back({.charge = uniform(state) - 0.5});
  return problem;
}

/// Returns the largest differences of potentials and forces, relative to the largest value.
std::array<double, 2> difference(const SphereSolution& a, const SphereSolution& b) {
  double potential = 0, force = 0, largest_potential = 0, largest_force = 0;
  for (std::size_t i = 0; i < a.group_potential.size(); ++i) {
    potential = std::max(potential, std::abs(a.group_potential[i] - b.group_potential[i]));
    largest_potential = std::max(largest_potential, std::abs(b.group_potential[i]));
  }
  for (std::size_t i = 0; i < a.sphere_force.size(); ++i) {
    force = std::max(force, norm(a.sphere_force[i] - b.sphere_force[i]));
    largest_force = std::max(largest_force, norm(b.sphere_force[i]));
  }
  return {potential / largest_potential, force / largest_force};
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  int count = 324, steps = 5, threads = 1;
  double accuracy = 1e-3, gap = 0.1, checked = 0;
  bool in_cloud = false;
  CLI::App app("field of conducting spheres");
  app.add_option("--spheres", count);
  app.add_option("--accuracy", accuracy);
  app.add_option("--gap", gap, "smallest, in radii");
  app.add_option("--steps", steps, "of a moving scene");
  app.add_option("--threads", threads);
  app.add_option("--check", checked, "accuracy of a solve to compare with");
  app.add_flag("--cloud", in_cloud, "free space instead of a dish");
  CLI11_PARSE(app, argc, argv);
  SphereProblem problem = in_cloud ? cloud(count, gap) : dish(count, gap);
  parallel::Team team(threads);
  SphereSolver solver({.accuracy = accuracy}, team);
  std::uint64_t state = 7;
  fmt::print("{:>6} {:>6} {:>9} {:>6} {:>8} {:>8} {:>8} {:>8}\n", "step", "degree", "unknowns", "iter", "setup",
             "solve", "results", "cpu s");
  for (int step = 0; step <= steps; ++step) {
    const double before = processor_seconds();
    const SphereSolution s = solver.solve(problem);
    fmt::print("{:>6} {:>6} {:>9} {:>6} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f}", step, s.degree, s.unknowns, s.iterations,
               s.seconds.setup, s.seconds.solve, s.seconds.forces, processor_seconds() - before);
    if (checked > 0) {
      const auto [potential, force] = difference(s, SphereSolver({.accuracy = checked}, team).solve(problem));
      fmt::print("   errors: potentials {:.1e}, forces {:.1e}", potential, force);
    }
    fmt::print("\n");
    for (Sphere& sphere : problem.spheres) {
      const double reach = 0.01 * gap * sphere.radius;
      sphere.centre += Vec3{uniform(state) - 0.5, uniform(state) - 0.5, 0} * (2 * reach);
    }
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("memory {:.2f} GiB\n", static_cast<double>(usage.ru_maxrss) / (1 << 20));
  return 0;
}
