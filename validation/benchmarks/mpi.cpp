// Times the assembled system on one or more processes: 324 floating disks around a grounded half-disk, as in the
// dendrite scene. Reports discretization (repeated by each process), assembly of the rows, set-up of the preconditioner
// and solve.
//
//   mpirun -n 2 benchmark_mpi [--sizes 256,512,1024] [--seed 1] [--repeats 5]
//
// Each time is the minimum over the repeats of the slowest process's time.

#include <fmt/format.h>

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
    SplitVector residual{{b.begin(), b.begin() + static_cast<long>(op.cells())},
                         {b.begin() + static_cast<long>(op.cells()), b.end()}};  // zero initial guess
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

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{256, 512, 1024};
  std::uint64_t seed = 1;
  int repeats = 5;
  CLI::App app("Times the assembled field solve on the processes that mpirun starts");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--seed", seed, "of the configuration");
  app.add_option("--repeats", repeats, "counted solves; the fastest is printed");
  CLI11_PARSE(app, argc, argv);

  parallel::start_petsc();
  const LaplaceProblem problem = benchmarks::disks_round_ground(324, seed);
  if (parallel::process_rank() == 0)
    fmt::print(
        "lichtenberg {}, PETSc {}.{}.{}; 324 conductors, R = S/64 cells, seed {}, tolerance 1e-8; ms\n"
        "{:>5} {:>9}  {:<31} {:>9} {:>9} {:>9} {:>9} {:>9} {:>5}\n",
        lichtenberg_version().commit, PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, seed, "S",
        "processes", "preconditioner", "links", "assembly", "set-up", "solve", "all", "iter");
  for (const int cells : sizes)
    for (const auto& [name, options] : preconditioners) {
      for (const auto& [option, value] : options) parallel::check_petsc(PetscOptionsSetValue(nullptr, option, value));
      benchmark(cells, problem, name, repeats);
    }
}
