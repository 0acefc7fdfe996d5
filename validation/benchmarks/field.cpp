// What a field solve costs: 324 floating disks around a grounded half-disk (the dendrite's numbers), set-up and solve
// apart, for the multigrid solver cold and in a moving scene, beside the same system under PETSc's other
// preconditioners and the dissertation's scheme, all in one run on one core.
//
//   benchmark_field [--sizes 256,512,1024] [--seed 1] [--repeats 5]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/petsc.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "src/version.hpp"
#include "validation/benchmarks/scene.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr int conductors = 324;

struct Cost {
  double setup, solve;
  int iterations;
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
  return {median(setup), median(solve), solutions.back().iterations};
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

/// Every disk moves by a tenth of a cell of S = 512 between solves, in its own direction.
Cost moving(LaplaceSolver& solver, LaplaceProblem problem, int repeats) {
  std::vector<LaplaceSolution> solutions;
  for (int k = 0; k < repeats + 4; ++k) {
    for (std::size_t body = 1; body < problem.bodies.size(); ++body) {
      const double angle = 2.4 * static_cast<double>(body);
      std::get<Disk>(problem.bodies[body].shape).centre += 0.1 * Vec2{std::cos(angle), std::sin(angle)};
    }
    LaplaceSolution solution = solver.solve(problem);
    if (k >= 4) solutions.push_back(std::move(solution));  // the first ones fill the history
  }
  return median(solutions);
}

void set_preconditioner(const std::vector<std::pair<const char*, const char*>>& options) {
  start_petsc();
  for (const char* name :
       {"-field_pc_type", "-field_pc_hypre_boomeramg_coarsen_type", "-field_pc_factor_mat_solver_type",
        "-field_pc_hypre_boomeramg_interp_type", "-field_pc_hypre_boomeramg_agg_nl"})
    check_petsc(PetscOptionsClearValue(nullptr, name));
  for (const auto& [name, value] : options) check_petsc(PetscOptionsSetValue(nullptr, name, value));
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

void print(int cells, const std::string& method, Cost cost, double reference) {
  fmt::print("{:5d}  {:<44} {:9.1f} {:9.1f} {:6d} {:8.1f}\n", cells, method, 1e3 * cost.setup, 1e3 * cost.solve,
             cost.iterations, (cost.setup + cost.solve) / reference);
  std::fflush(stdout);
}

/// The dissertation's outer iteration needs thousands of potential solves here. It gets `seconds`; how many more it
/// would take to bring the charges within 1 % of the largest (rms) follows from the rate at which its error falls at
/// the end.
void dissertation(int cells, const LaplaceProblem& problem, double eta, double seconds, double reference) {
  RelaxationOptions options;
  options.sites = cells;
  options.eta = eta;
  options.tolerance = 1e-12;  // never reached: the number of solves is what ends it
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
  const std::size_t last = error.size() - 1, middle = last / 2;
  const double rate = std::log(error[middle] / error[last]) / static_cast<double>(last - middle);
  const auto reached = std::find_if(error.begin(), error.end(), [&](double e) { return e <= wanted; });
  const double all = reached != error.end() ? static_cast<double>(reached - error.begin() + 1)
                                            : std::log(error[last] / wanted) / rate + static_cast<double>(last + 1);
  const std::string step = eta > 0 ? fmt::format("eta {}", eta) : "eta chosen a step";
  print(cells, "dissertation, " + step + ": a potential solve", {0, one, 1}, reference);
  fmt::print(
      "{:5d}  dissertation, {}: {} potential solves to 1 % in charge{}, {:.2g} s, {:.0f} times the multigrid's\n",
      cells, step, std::lround(all), error[last] > wanted ? fmt::format(" (extrapolated from {})", last) : "",
      all * one, all * one / reference);
}

void benchmark(int cells, const LaplaceProblem& problem, int repeats, double seconds) {
  CutCellOptions options;
  options.cells = cells;
  set_preconditioner({});
  CutCellSolver multigrid(options);
  const Cost reference = cold(multigrid, problem, repeats);
  const double total = reference.setup + reference.solve;
  print(cells, "multigrid + CG, cold, 1e-8", reference, total);
  multigrid.set_tolerance(1e-5);
  print(cells, "multigrid + CG, moving scene, 1e-5", moving(multigrid, problem, repeats), total);

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

  // The step of D 6.30 as the dissertation takes it, constant (its eta at eps = 1), and chosen anew each time.
  for (const double eta : {0.01, 0.0}) dissertation(cells, problem, eta, seconds, total);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{256, 512, 1024};
  std::uint64_t seed = 1;
  int repeats = 5;
  double seconds = 20;
  CLI::App app("Times field solves: set-up and solve apart, several sizes, beside other solvers");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--seed", seed, "of the configuration");
  app.add_option("--repeats", repeats, "counted solves; the median is printed");
  app.add_option("--seconds", seconds, "the dissertation's scheme may take for a size");
  CLI11_PARSE(app, argc, argv);

  const LaplaceProblem problem = benchmarks::disks_round_ground(conductors, seed);
  fmt::print("lichtenberg {}, PETSc {}.{}.{}, {}, one core; {} conductors, R = S/64 cells, seed {}\n",
             lichtenberg_version().commit, PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
             processor(), conductors, seed);
  fmt::print("{:>5}  {:<44} {:>9} {:>9} {:>6} {:>8}\n", "S", "method", "setup ms", "solve ms", "iter", "ratio");
  for (const int cells : sizes) benchmark(cells, problem, repeats, seconds);
}
