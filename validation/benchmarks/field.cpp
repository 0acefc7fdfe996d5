// Measures a field solve: 324 floating disks around a grounded half-disk, as in the dendrite scene. For the multigrid
// solver, cold and in a moving scene, reports set-up and solve times on one or more threads. Reports its work in
// residual evaluations to a tight tolerance and to the discretization error. On one core, also measures the same system
// with PETSc's other preconditioners, the dissertation's scheme, and the device algorithms on this processor.
//
//   benchmark_field [--sizes 256,512,1024] [--threads 1,2] [--seed 1] [--repeats 5] [--multigrid-only]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "validation/benchmarks/decay.hpp"
#include "validation/benchmarks/machine.hpp"
#include "validation/benchmarks/scene.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr int conductors = 324;

struct Cost {
  double setup, solve;
  int iterations;
  double work = 0;

  double total() const { return setup + solve; }
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

Cost median(const std::vector<LaplaceSolution>& solutions) {
  std::vector<double> setup, solve;
  for (const LaplaceSolution& s : solutions) {
    setup.push_back(s.seconds.setup);
    solve.push_back(s.seconds.solve + s.seconds.forces);
  }
  return {median(setup), median(solve), solutions.back().iterations, solutions.back().work};
}

Cost cold(LaplaceSolver& solver, const LaplaceProblem& problem, int repeats) {
  std::vector<LaplaceSolution> solutions;
  for (int k = 0; k <= repeats; ++k) {
    solver.forget();
    LaplaceSolution solution = solver.solve(problem);
    if (k > 0) solutions.push_back(std::move(solution));  // the first call allocates
  }
  return median(solutions);
}

/// Moves each disk by 0.1 cell of S = 512, in its own direction.
void move(LaplaceProblem& problem) {
  for (std::size_t body = 1; body < problem.bodies.size(); ++body) {
    const double angle = 2.4 * static_cast<double>(body);
    std::get<Disk>(problem.bodies[body].shape).centre += 0.1 * Vec2{std::cos(angle), std::sin(angle)};
  }
}

Cost moving(LaplaceSolver& solver, LaplaceProblem problem, int repeats) {
  std::vector<LaplaceSolution> solutions;
  for (int k = 0; k < repeats + 4; ++k) {
    move(problem);
    LaplaceSolution solution = solver.solve(problem);
    if (k >= 4) solutions.push_back(std::move(solution));  // the first ones fill the history
  }
  return median(solutions);
}

void set_preconditioner(const std::vector<std::pair<const char*, const char*>>& options) {
  parallel::start_petsc();
  for (const char* name :
       {"-field_pc_type", "-field_pc_hypre_boomeramg_coarsen_type", "-field_pc_factor_mat_solver_type",
        "-field_pc_hypre_boomeramg_interp_type", "-field_pc_hypre_boomeramg_agg_nl"})
    parallel::check_petsc(PetscOptionsClearValue(nullptr, name));
  for (const auto& [name, value] : options) parallel::check_petsc(PetscOptionsSetValue(nullptr, name, value));
}

void print(int cells, const std::string& method, Cost cost, double reference) {
  fmt::print("{:5d}  {:<48} {:9.1f} {:9.1f} {:6d} {:>6} {:8.1f}\n", cells, method, 1e3 * cost.setup, 1e3 * cost.solve,
             cost.iterations, cost.work > 0 ? fmt::format("{:.1f}", cost.work) : "", cost.total() / reference);
  std::fflush(stdout);
}

/// Describes when the error history of the dissertation's scheme reaches `wanted`. `one`: seconds per potential solve.
std::string solves_to_the_end(const std::vector<double>& error, double wanted, double one, double reference) {
  const auto reached = std::find_if(error.begin(), error.end(), [&](double e) { return e <= wanted; });
  const double last = static_cast<double>(error.size()), middle = std::floor(last / 2);
  std::optional<double> all;
  if (reached != error.end())
    all = static_cast<double>(reached - error.begin() + 1);
  else
    all = benchmarks::end_of_decay({middle, error[static_cast<std::size_t>(middle) - 1]}, {last, error.back()}, wanted);
  if (!all)
    return fmt::format("not within 1 % in charge after {} potential solves; rms error {:.2g} %, no rate to extrapolate",
                       error.size(), std::sqrt(error.back() / wanted));
  return fmt::format("{} potential solves to 1 % in charge{}, {:.2g} s, {:.0f} times the multigrid's",
                     std::lround(*all),
                     reached == error.end() ? fmt::format(" (extrapolated from {})", error.size()) : "", *all * one,
                     *all * one / reference);
}

/// Times the dissertation's outer iteration for `seconds`; a complete run needs thousands of potential solves.
/// Extrapolates by decay.hpp the number of solves to rms charge errors of 1 % of the largest charge. If the error
/// decreases too slowly, the row states the present error instead.
void dissertation(int cells, const LaplaceProblem& problem, double eta, double seconds, double reference) {
  RelaxationOptions options;
  options.sites = cells;
  options.eta = eta;
  options.tolerance = 1e-12;  // never reached; the number of solves ends the iteration
  const auto run = [&](int solves, std::vector<double>& error) {
    options.largest_iterations = solves;
    RelaxationSolver solver(options);
    const auto start = std::chrono::steady_clock::now();
    try {
      solver.solve(problem);
    } catch (const Failure&) {
    }
    error = solver.error_history();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / solves;
  };
  std::vector<double> error;
  const double one = run(2, error);
  const int solves = std::clamp(static_cast<int>(seconds / one), 4, 4000);
  run(solves, error);
  double largest = 0;
  for (const Group& group : problem.groups) largest = std::max(largest, std::abs(group.charge));
  const double wanted = 0.5 * conductors * std::pow(0.01 * largest, 2);
  const std::string step = eta > 0 ? fmt::format("eta {}", eta) : "eta chosen a step";
  print(cells, "dissertation, " + step + ": a potential solve", {0, one, 1}, reference);
  fmt::print("{:5d}  dissertation, {}: {}\n", cells, step, solves_to_the_end(error, wanted, one, reference));
}

/// Returns the rms difference of two solutions' group potentials.
double difference(const LaplaceSolution& a, const LaplaceSolution& b) {
  double sum = 0;
  for (std::size_t g = 0; g < a.group_potential.size(); ++g)
    sum += std::pow(a.group_potential[g] - b.group_potential[g], 2);
  return std::sqrt(sum / static_cast<double>(a.group_potential.size()));
}

/// Returns the last solution of a moving scene, or the cold solution of the scene at rest.
LaplaceSolution last_solution(int cells, LaplaceProblem problem, double tolerance, bool in_motion) {
  CutCellSolver solver({.cells = cells, .tolerance = tolerance});
  if (!in_motion) return solver.solve(problem);
  LaplaceSolution solution;
  for (int k = 0; k < 6; ++k) {
    move(problem);
    solution = solver.solve(problem);
  }
  return solution;
}

/// Prints the loosest tolerance at which the algebraic error of the potentials is smaller than the discretization
/// error. The latter is Richardson's estimate from S and 2S (second order: 4/3 of the difference).
void print_to_discretization_error(int cells, const LaplaceProblem& problem, bool in_motion) {
  const LaplaceSolution exact = last_solution(cells, problem, 1e-10, in_motion);
  const double error = 4.0 / 3.0 * difference(exact, last_solution(2 * cells, problem, 1e-10, in_motion));
  for (double tolerance = 0.5; tolerance > 1e-8; tolerance /= 2) {
    const LaplaceSolution solution = last_solution(cells, problem, tolerance, in_motion);
    const double left = difference(exact, solution);
    if (left > error) continue;
    fmt::print(
        "{:5d}  to the discretization error ({:.2g}, rms of potentials of {:.2g}), {}: {} iterations (tolerance "
        "{:.2g}), work {:.1f}\n",
        cells, error, difference(exact, {.group_potential = std::vector<double>(exact.group_potential.size())}),
        in_motion ? "moving scene" : "cold", solution.iterations, tolerance, solution.work);
    return;
  }
}

/// Prints the costs. Returns the time of a cold solve with the first number of threads.
double benchmark_multigrid(int cells, const LaplaceProblem& problem, int repeats, const std::vector<int>& threads) {
  std::vector<std::pair<Cost, Cost>> costs;
  for (const int count : threads) {
    CutCellSolver solver({.cells = cells, .threads = count});
    const Cost at_rest = cold(solver, problem, repeats);
    solver.set_tolerance(1e-5);
    costs.emplace_back(at_rest, moving(solver, problem, repeats));
    const double total = costs.front().first.total();
    const std::string with = fmt::format(", {} thread{}", count, count > 1 ? "s" : "");
    print(cells, "multigrid + CG, cold, 1e-8" + with, costs.back().first, total);
    print(cells, "multigrid + CG, moving scene, 1e-5" + with, costs.back().second, total);
  }
  for (std::size_t k = 1; k < threads.size(); ++k)
    fmt::print("{:5d}  {} threads are {:.2f} times as fast as {} cold, {:.2f} times in the moving scene\n", cells,
               threads[k], costs[0].first.total() / costs[k].first.total(), threads[0],
               costs[0].second.total() / costs[k].second.total());
  for (const bool in_motion : {false, true}) print_to_discretization_error(cells, problem, in_motion);
  return costs.front().first.total();
}

void benchmark_others(int cells, const LaplaceProblem& problem, int repeats, double seconds, double total) {
  CutCellOptions options;
  options.cells = cells;
  const std::unique_ptr<device::DeviceSolver> as_on_device = device::make_host_solver(options);
  print(cells, "as on a device, cold, 1e-8, 1 thread", cold(*as_on_device, problem, repeats), total);
  as_on_device->set_tolerance(1e-5);
  print(cells, "as on a device, moving scene, 1e-5, 1 thread", moving(*as_on_device, problem, repeats), total);
  const std::vector<std::pair<std::string, std::vector<std::pair<const char*, const char*>>>> others{
      {"assembled, GAMG + CG", {{"-field_pc_type", "gamg"}}},
      {"assembled, BoomerAMG (HMIS, ext+i, agg 1) + CG",
       {{"-field_pc_type", "hypre"},
        {"-field_pc_hypre_boomeramg_coarsen_type", "HMIS"},
        {"-field_pc_hypre_boomeramg_interp_type", "ext+i"},
        {"-field_pc_hypre_boomeramg_agg_nl", "1"}}},
      {"assembled, CHOLMOD", {{"-field_pc_type", "cholesky"}, {"-field_pc_factor_mat_solver_type", "cholmod"}}}};
  options.linear_solver = CutCellOptions::LinearSolver::assembled;
  for (const auto& [name, petsc] : others) {
    set_preconditioner(petsc);
    CutCellSolver solver(options);
    print(cells, name, cold(solver, problem, std::min(repeats, 3)), total);
  }

  // Step of D 6.30: constant as in the dissertation (its eta at eps = 1), and chosen in each iteration.
  for (const double eta : {0.01, 0.0}) dissertation(cells, problem, eta, seconds, total);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{256, 512, 1024};
  std::uint64_t seed = 1;
  int repeats = 5;
  double seconds = 20;
  std::vector<int> threads{1, 2};
  bool multigrid_only = false;
  CLI::App app("Times field solves: set-up and solve apart, several sizes, beside other solvers");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--threads", threads, "of the multigrid solver")->delimiter(',');
  app.add_flag("--multigrid-only", multigrid_only, "leave out the other methods");
  app.add_option("--seed", seed, "of the configuration");
  app.add_option("--repeats", repeats, "counted solves; the median is printed");
  app.add_option("--seconds", seconds, "the dissertation's scheme may take for a size");
  CLI11_PARSE(app, argc, argv);

  const LaplaceProblem problem = benchmarks::disks_round_ground(conductors, seed);
  fmt::print("{}, PETSc {}.{}.{}; {} conductors, R = S/64 cells, seed {}\n", benchmarks::machine(), PETSC_VERSION_MAJOR,
             PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, conductors, seed);
  fmt::print("{:>5}  {:<48} {:>9} {:>9} {:>6} {:>6} {:>8}\n", "S", "method", "setup ms", "solve ms", "iter", "work",
             "ratio");
  set_preconditioner({});
  for (const int cells : sizes) {
    const double total = benchmark_multigrid(cells, problem, repeats, threads);
    if (!multigrid_only) benchmark_others(cells, problem, repeats, seconds, total);
  }
}
