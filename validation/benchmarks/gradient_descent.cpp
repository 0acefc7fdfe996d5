// Compares the cost of one decimal digit for the dissertation's gradient descent (D 6.30) and the direct solve: N = 2
// ... 324 charged disks around a grounded half-disk, one core. A digit is a factor of ten. For the descent it refers to
// the rms missing charge, for the direct solve to the energy norm of the error. The program solvers_agree covers the
// discretization error.
//
//   benchmark_gradient_descent [--cells 512] [--conductors 2,8,32,100,324] [--seconds 20]

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "validation/benchmarks/machine.hpp"
#include "validation/benchmarks/scene.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

double seconds_of(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Digit {
  double iterations = 0, seconds = 0;
};

/// Returns the cost from the second half of a run of about `seconds`. The first steps are faster, because they remove
/// error components that many eigenvectors share.
Digit measure_descent(const LaplaceProblem& problem, int cells, double eta, double seconds) {
  RelaxationOptions options{.sites = cells, .eta = eta, .tolerance = 1e-8};
  std::vector<double> error;
  const auto run = [&](int solves) {
    options.largest_iterations = solves;
    RelaxationSolver solver(options);
    try {
      solver.solve(problem);
    } catch (const Failure&) {
      // The iteration limit ends the run before convergence.
    }
    error = solver.error_history();
  };
  const double one = seconds_of([&] { run(2); }) / 2;
  const double all = seconds_of([&] { run(std::clamp(static_cast<int>(seconds / one), 10, 1000)); });
  const std::size_t last = error.size() - 1, middle = last / 2;
  // E is a sum of squares: two decades of E are one digit.
  const double digits = 0.5 * std::log10(error[middle] / error[last]);
  const double iterations = static_cast<double>(last - middle) / digits;
  return {iterations, iterations * all / static_cast<double>(error.size())};
}

/// Returns the cost between 2 and 10 digits, which excludes common parts (set-up, forces).
Digit measure_direct_solve(const LaplaceProblem& problem, int cells) {
  const auto best = [&](double tolerance) {
    Digit quickest{0, INFINITY};
    for (int k = 0; k < 5; ++k) {
      CutCellSolver solver({.cells = cells, .tolerance = tolerance, .threads = 1});
      const LaplaceSolution solution = solver.solve(problem);
      quickest = {static_cast<double>(solution.iterations), std::min(quickest.seconds, solution.seconds.solve)};
    }
    return quickest;
  };
  const Digit coarse = best(1e-2), fine = best(1e-10);
  return {(fine.iterations - coarse.iterations) / 8, (fine.seconds - coarse.seconds) / 8};
}

void print(int conductors, const char* method, Digit digit, Digit direct) {
  fmt::print("{:6}  {:<44}{:>12.2f}{:>14.2f}{:>10.0f}\n", conductors, method, digit.iterations, 1e3 * digit.seconds,
             digit.seconds / direct.seconds);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int cells = 512;
  std::vector<int> conductors{2, 8, 32, 100, 324};
  double seconds = 20;
  CLI::App app("Cost of a digit: gradient descent of the potentials, compared with the direct solve");
  app.add_option("--cells", cells, "along a side");
  app.add_option("--conductors", conductors, "numbers of them")->delimiter(',');
  app.add_option("--seconds", seconds, "a descent may take");
  CLI11_PARSE(app, argc, argv);

  fmt::print("{}; S = {}, R = S/64 cells\n", benchmarks::machine(), cells);
  fmt::print("{:>6}  {:<44}{:>12}{:>14}{:>10}\n", "N", "method", "iterations", "ms a digit", "ratio");
  for (const int count : conductors) {
    const LaplaceProblem problem = benchmarks::disks_round_ground(count, 1);
    const Digit direct = measure_direct_solve(problem, cells);
    print(count, "direct: multigrid + CG", direct, direct);
    print(count, "descent, eta chosen from eta_c (D 6.35)", measure_descent(problem, cells, 0, seconds), direct);
    print(count, "descent, eta = 0.01 (D 6.5.4)", measure_descent(problem, cells, 0.01, seconds), direct);
  }
}
