// Measures a field solve on a CUDA device: 324 and 20000 floating disks around a grounded half-disk. Reports the times
// of set-up and solve, cold (1e-8) and in a moving scene (1e-5). Reports the memory throughput of the parts of an
// iteration and of a device copy. Reports the differences of potentials, charges and forces from the CPU solver.
//
//   benchmark_device [--sizes 512,1024,2048,4096] [--conductors 324,20000] [--compare 1024] [--assembled 1024]
//   [--host] [--devices 0,1]
//
// With several devices the differences are those from the first device, before the comparison with the CPU.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <random>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/version.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// Returns disks on a jittered lattice in a box of 1 x 1 around a grounded half-disk. Gaps are at least a quarter of
/// the radius. The radius is 1/64 for at most 400 disks, 1/546 for at most 20000, otherwise 0.27 of the pitch.
LaplaceProblem scene(int conductors, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  const int a_side = static_cast<int>(std::ceil(std::sqrt(1.1 * conductors)));
  const double pitch = 1.0 / a_side;
  const double radius = conductors <= 400 ? 1.0 / 64 : conductors <= 20000 ? 1.0 / 546 : 0.27 * pitch;
  const double shift = 0.5 * (pitch - 2.25 * radius);  // largest shift from the middle of a lattice cell
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.bodies = {{Disk{{0.5, 0}, 2 * radius}, 0}};
  problem.groups = {{false, 0, 0}};
  for (int j = 0; j < a_side; ++j)
    for (int i = 0; i < a_side; ++i) {
      const Disk disk{{(i + 0.5) * pitch + uniform(-shift, shift), (j + 0.5) * pitch + uniform(-shift, shift)}, radius};
      const double charge = uniform(0, 1);
      if (gap(disk, problem.bodies[0].shape) < 0.25 * radius) continue;
      if (static_cast<int>(problem.bodies.size()) > conductors) continue;
      problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
      problem.groups.push_back({true, charge, 0});
    }
  return problem;
}

/// Moves each disk by 0.1 cell in its own direction, which rotates with `step`, so that displacements stay small.
void move(LaplaceProblem& problem, int cells, int step) {
  for (std::size_t body = 1; body < problem.bodies.size(); ++body) {
    const double angle = 2.4 * static_cast<double>(body) + 0.7 * step;
    std::get<Disk>(problem.bodies[body].shape).centre += 0.1 / cells * Vec2{std::cos(angle), std::sin(angle)};
  }
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void print(int cells, std::size_t conductors, const char* what, const std::vector<LaplaceSolution>& solutions) {
  std::vector<double> setup, solve, forces;
  for (const LaplaceSolution& s : solutions) {
    setup.push_back(1e3 * s.seconds.setup);
    solve.push_back(1e3 * s.seconds.solve);
    forces.push_back(1e3 * s.seconds.forces);
  }
  fmt::print("{:5d} {:6d}  {:<22} {:9.2f} {:9.2f} {:9.2f} {:6d} {:10d}\n", cells, conductors, what, median(setup),
             median(solve), median(forces), solutions.back().iterations, solutions.back().unknowns);
  std::fflush(stdout);
}

struct Difference {
  double potential = 0, charge = 0, force = 0, energy = 0;
};

/// Returns the largest differences, relative to the largest value of `a`.
Difference difference(const LaplaceSolution& a, const LaplaceSolution& b) {
  const auto relative = [](const auto& x, const auto& y, auto magnitude) {
    double worst = 0, largest = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      worst = std::max(worst, magnitude(x[k] - y[k]));
      largest = std::max(largest, magnitude(x[k]));
    }
    return worst / largest;
  };
  const auto absolute = [](double x) { return std::abs(x); };
  return {relative(a.group_potential, b.group_potential, absolute), relative(a.body_charge, b.body_charge, absolute),
          relative(a.body_force, b.body_force, [](Vec2 v) { return norm(v); }), std::abs(a.energy / b.energy - 1)};
}

void compare(const CutCellOptions& options, LaplaceSolver& device, const LaplaceProblem& problem) {
  CutCellOptions on_cpu = options;
  on_cpu.device = CutCellOptions::Device::cpu;
  CutCellSolver cpu(on_cpu);
  device.forget();
  const LaplaceSolution a = cpu.solve(problem), b = device.solve(problem), c = [&] {
    device.forget();
    return device.solve(problem);
  }();
  const Difference d = difference(a, b);
  const bool same = b.group_potential == c.group_potential && b.body_charge == c.body_charge && b.energy == c.energy;
  fmt::print(
      "{:5d} {:6d}  to the CPU's solution: potential {:.1e}, charge {:.1e}, force {:.1e}, energy {:.1e}; CPU {} "
      "iterations, {:.1f} + {:.1f} ms; solved again: {}\n",
      options.cells, problem.bodies.size() - 1, d.potential, d.charge, d.force, d.energy, a.iterations,
      1e3 * a.seconds.setup, 1e3 * a.seconds.solve, same ? "the same bits" : "OTHER BITS");
  std::fflush(stdout);
}

/// Solves the same system as an AIJ matrix with PETSc's algebraic multigrid.
void benchmark_assembled(int cells, const LaplaceProblem& problem) {
  CutCellOptions options;
  options.cells = cells;
  options.linear_solver = CutCellOptions::LinearSolver::assembled;
  options.device = CutCellOptions::Device::cuda;
  CutCellSolver solver(options);
  std::vector<LaplaceSolution> solutions;
  for (int k = 0; k < 3; ++k) {
    solver.forget();
    LaplaceSolution solution = solver.solve(problem);
    if (k > 0) solutions.push_back(std::move(solution));
  }
  print(cells, problem.bodies.size() - 1, "assembled, cold, 1e-8", solutions);
}

/// Devices of a benchmark: threads of the CPU with `host`, otherwise CUDA devices with these numbers; none: PETSc's.
struct Devices {
  bool host = false;
  std::vector<int> numbers;

  std::unique_ptr<device::DeviceSolver> make(CutCellOptions options) const {
    if (host) return device::make_host_solver(options, std::max(1, static_cast<int>(numbers.size())));
    for (const int number : numbers) options.cuda_devices |= std::uint64_t{1} << number;
    return device::make_cuda_solver(options);
  }
};

/// Prints the differences of the solution on several devices from that on one.
void compare_with_one(const CutCellOptions& options, const Devices& devices, LaplaceSolver& several,
                      const LaplaceProblem& problem) {
  const LaplaceSolution a = Devices{devices.host}.make(options)->solve(problem), b = several.solve(problem);
  const Difference d = difference(a, b);
  fmt::print(
      "{:5d} {:6d}  to one device: potential {:.1e}, charge {:.1e}, force {:.1e}, energy {:.1e}; {} iterations\n",
      options.cells, problem.bodies.size() - 1, d.potential, d.charge, d.force, d.energy, a.iterations);
}

void benchmark(int cells, int conductors, std::uint64_t seed, int repeats, const Devices& devices, bool with_cpu) {
  CutCellOptions options;
  options.cells = cells;
  LaplaceProblem problem = scene(conductors, seed);
  const auto solver = devices.make(options);
  if (devices.numbers.size() > 1) compare_with_one(options, devices, *solver, problem);
  if (with_cpu) compare(options, *solver, problem);
  std::vector<LaplaceSolution> solutions;
  for (int k = 0; k <= repeats; ++k) {
    solver->forget();
    LaplaceSolution solution = solver->solve(problem);
    if (k > 0) solutions.push_back(std::move(solution));  // the first call allocates
  }
  print(cells, problem.bodies.size() - 1, "cold, 1e-8", solutions);
  solver->set_tolerance(1e-5);
  solutions.clear();
  for (int k = 0; k < repeats + 4; ++k) {
    move(problem, cells, k);
    LaplaceSolution solution = solver->solve(problem);
    if (k >= 4) solutions.push_back(std::move(solution));  // the first ones fill the history
  }
  print(cells, problem.bodies.size() - 1, "moving, 1e-5", solutions);
  const device::Profile profile = solver->profile(repeats);
  const auto rate = [](const device::Profile::Traffic& part) { return 1e-9 * part.bytes / part.seconds; };
  fmt::print(
      "{:5d} {:6d}  operator {:.3f} ms, {:.0f} GB/s; V-cycle {:.3f} ms, {:.0f} GB/s, {} grids, coarsest {} "
      "unknowns; copy {:.3f} ms, {:.0f} GB/s\n",
      cells, problem.bodies.size() - 1, 1e3 * profile.apply_operator.seconds, rate(profile.apply_operator),
      1e3 * profile.cycle.seconds, rate(profile.cycle), profile.levels, profile.coarse_unknowns,
      1e3 * profile.copy.seconds, rate(profile.copy));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{512, 1024, 2048, 4096}, conductors{324};
  std::uint64_t seed = 1;
  int repeats = 5, largest_compared = 1024, largest_assembled = 0;
  Devices devices;
  CLI::App app("Times field solves on a CUDA device and compares them with the CPU's");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--conductors", conductors, "how many floating disks")->delimiter(',');
  app.add_option("--seed", seed, "of the configuration");
  app.add_option("--repeats", repeats, "counted solves; the median is printed");
  app.add_option("--compare", largest_compared, "compare with the CPU's solver up to this size");
  app.add_option("--assembled", largest_assembled, "up to this size also as an AIJ matrix with PETSc's preconditioner");
  app.add_flag("--host", devices.host, "run the device's algorithms on the CPU");
  app.add_option("--devices", devices.numbers, "numbers of CUDA devices that divide each grid")->delimiter(',');
  std::vector<std::string> petsc;
  app.add_option("--petsc", petsc, "options for PETSc, as on its command line")->expected(-1);
  CLI11_PARSE(app, argc, argv);
  parallel::set_petsc_options(petsc);

  try {
    fmt::print("lichtenberg {}, PETSc {}.{}.{}\n", lichtenberg_version().commit, PETSC_VERSION_MAJOR,
               PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR);
    fmt::print("{:>5} {:>6}  {:<22} {:>9} {:>9} {:>9} {:>6} {:>10}\n", "S", "N", "case", "setup ms", "solve ms",
               "forces ms", "iter", "unknowns");
    for (const int n : conductors)
      for (const int cells : sizes) {
        benchmark(cells, n, seed, repeats, devices, cells <= largest_compared);
        if (cells <= largest_assembled) benchmark_assembled(cells, scene(n, seed));
      }
    parallel::finish_petsc();
  } catch (const InputError& error) {
    fmt::print(stderr, "benchmark_device: {}\n", error.what());
    return 2;
  } catch (const Failure& error) {
    fmt::print(stderr, "benchmark_device: {}\n", error.what());
    return 1;
  }
}
