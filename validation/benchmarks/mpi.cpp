// Times a field solve on one or more processes: 324 floating disks around a grounded half-disk, as in the dendrite
// scene. For the assembled system it reports discretization (repeated by each process), assembly of the rows, set-up of
// the preconditioner and solve. For the multigrid it reports set-up and solve without an earlier solution, and the
// largest memory of a process.
//
//   mpirun -n 2 benchmark_mpi [--sizes 256,512,1024] [--seed 1] [--repeats 5]
//   mpirun -n 2 benchmark_mpi --multigrid --sizes 4096 --conductors 20000 --radius 1
//
// Each time is the minimum over the repeats of the slowest process's time.

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/laplace/cutcell/assembled.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/version.hpp"
#include "validation/benchmarks/scene.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

using Options = std::vector<std::pair<const char*, const char*>>;

const std::vector<std::pair<std::string, Options>> preconditioners{{"GAMG", {{"-field_pc_type", "gamg"}}},
                                                                   {"BoomerAMG (HMIS, ext+i, agg 1)",
                                                                    {{"-field_pc_type", "hypre"},
                                                                     {"-field_pc_hypre_boomeramg_coarsen_type", "HMIS"},
                                                                     {"-field_pc_hypre_boomeramg_interp_type", "ext+i"},
                                                                     {"-field_pc_hypre_boomeramg_agg_nl", "1"}}}};

/// Returns the seconds until the last process has finished `work`.
double seconds(const std::function<void()>& work) {
  MPI_Barrier(PETSC_COMM_WORLD);
  const double start = MPI_Wtime();
  work();
  double own = MPI_Wtime() - start, slowest = own;
  MPI_Allreduce(&own, &slowest, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return slowest;
}

void benchmark(int cells, const LaplaceProblem& problem, const std::string& name, int repeats) {
  constexpr double tolerance = 1e-8;
  double least[4] = {1e9, 1e9, 1e9, 1e9};
  LaplaceSolution solution;
  for (int k = 0; k <= repeats; ++k) {
    Level level(problem, cells, cells);
    CutCellOperator op;
    AssembledSystem system(LinkFormula::log_fitted, tolerance);
    const double discretization = seconds([&] {
      LevelBuilder().build(problem, LinkFormula::log_fitted, level);
      op.build(problem, level);
    });
    const double assembly = seconds([&] { system.assemble_matrix(problem, level); });
    const double preconditioner = seconds([&] { system.set_up_preconditioner(problem); });
    std::vector<double> x(op.size(), 0.0), b(op.size());
    op.right_hand_side(problem, b.data());
    std::vector<double> residual = b;  // zero initial guess
    const double solve = seconds([&] { system.solve(b, x, residual, {tolerance, 0, 0, 0}, solution); });
    if (k == 0) continue;  // the first call allocates and starts threads
    const double now[4] = {discretization, assembly, preconditioner, solve};
    for (int m = 0; m < 4; ++m) least[m] = std::min(least[m], now[m]);
  }
  if (parallel::process_rank() > 0) return;
  fmt::print("{:>5} {:>9}  {:<31} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>5}\n", cells,
             parallel::process_count(), name, 1e3 * least[0], 1e3 * least[1], 1e3 * least[2], 1e3 * least[3],
             1e3 * (least[0] + least[1] + least[2] + least[3]), solution.iterations);
  std::fflush(stdout);
}

/// Memory of this process at its largest so far (MiB).
double largest_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void benchmark_multigrid(int cells, const LaplaceProblem& problem, int threads, int repeats) {
  CutCellSolver solver({.cells = cells, .tolerance = 1e-8, .threads = threads});
  double setup = 1e9, all = 1e9, memory = 0;
  LaplaceSolution solution;
  for (int k = 0; k <= repeats; ++k) {
    solver.forget();
    const double now = seconds([&] { solution = solver.solve(problem); });
    if (k == 0) continue;  // the first call allocates
    all = std::min(all, now);
    setup = std::min(setup, solution.seconds.setup);
  }
  const double own = largest_memory();
  MPI_Allreduce(&own, &memory, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  if (parallel::process_rank() > 0) return;
  fmt::print("{:>5} {:>9}  {:<31} {:>9.1f} {:>9} {:>9} {:>9.1f} {:>9.1f} {:>5} {:>7.0f}\n", cells,
             parallel::process_count(), fmt::format("multigrid, {} thread{}", threads, threads > 1 ? "s" : ""),
             1e3 * setup, "", "", 1e3 * (all - setup), 1e3 * all, solution.iterations, memory);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{256, 512, 1024};
  std::uint64_t seed = 1;
  int repeats = 5, conductors = 324, threads = 1;
  double radius = 8;
  bool multigrid = false;
  CLI::App app("Times a field solve on the processes that mpirun starts");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--seed", seed, "of the configuration");
  app.add_option("--repeats", repeats, "counted solves; the fastest is printed");
  app.add_flag("--multigrid", multigrid, "the multigrid instead of the assembled system");
  app.add_option("--threads", threads, "of a process, with --multigrid");
  app.add_option("--conductors", conductors, "number of disks");
  app.add_option("--radius", radius, "of the disks (S/512)");
  CLI11_PARSE(app, argc, argv);

  parallel::start_petsc();
  const LaplaceProblem problem = benchmarks::disks_round_ground(conductors, seed, radius);
  if (parallel::process_rank() == 0)
    fmt::print(
        "lichtenberg {}, PETSc {}.{}.{}; {} conductors, R = {} S/512, seed {}, tolerance 1e-8; ms\n"
        "{:>5} {:>9}  {:<31} {:>9} {:>9} {:>9} {:>9} {:>9} {:>5} {:>7}\n",
        lichtenberg_version().commit, PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, conductors,
        radius, seed, "S", "processes", "preconditioner", "links", "assembly", "set-up", "solve", "all", "iter", "MiB");
  for (const int cells : sizes) {
    if (multigrid) {
      benchmark_multigrid(cells, problem, threads, repeats);
      continue;
    }
    for (const auto& [name, options] : preconditioners) {
      for (const auto& [option, value] : options) parallel::check_petsc(PetscOptionsSetValue(nullptr, option, value));
      benchmark(cells, problem, name, repeats);
    }
  }
}
