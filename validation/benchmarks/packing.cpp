// Compares iterations and time of all minimization methods and PETSc's TAO for random packings.
#include <fmt/format.h>
#include <petsctao.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>

#include "solvers/parallel/petsc.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/statics/minimization.hpp"
#include "src/statics/potential_energy.hpp"
#include "src/version.hpp"
#include "validation/benchmarks/decay.hpp"

using namespace lichtenberg;

namespace {

struct Options {
  std::vector<int> sizes{1000, 10000, 100000};
  std::vector<std::string> methods{"lbfgs-newton", "lbfgs", "newton-cg", "fire", "lmvm", "gradient-descent"};
  int dimension = 2, threads = 0;
  double filled = 0.92, tolerance = 1e-8, seconds = 120;
};

Scene random_packing(const Options& options, int count, const std::string& method) {
  // Mean r^3 and r^2 of radii uniform between .4 and .66.
  const double content = options.dimension == 3 ? 4.0 / 3 * M_PI * 0.15785 : M_PI * 0.28653;
  const double side = std::pow(count * content / options.filled, 1.0 / options.dimension);
  return parse_scene(
      fmt::format("[domain]\nsize = [{0}, {0}{1}]\n[effects.soft_repulsion]\n[minimize]\nmethod = \"{2}\"\n"
                  "force_tolerance = {3}\nthreads = {4}\n[[population]]\ncount = {5}\n"
                  "radius = [0.4, 0.66]\noverlapping = true\n",
                  side, options.dimension == 3 ? fmt::format(", {}", side) : "", method, options.tolerance,
                  options.threads, count),
      "packing");
}

class Clock {
 public:
  double wall() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  double cpu() const { return static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC; }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

void print_row(int count, const std::string& method, std::int64_t iterations, std::int64_t evaluations,
               const Clock& clock, double energy, double force, const std::string& note) {
  fmt::print("{:>8} {:<17}{:>10}{:>12}{:>10.2f}{:>10.2f}{:>16.10g}{:>11.2e}  {}\n", count, method, iterations,
             evaluations, clock.wall(), clock.cpu(), energy, force, note);
  std::fflush(stdout);
}

/// Describes a packing that is not at rest at the time limit. The decay rate of the force in the second half gives a
/// lower bound on the time to rest, because the slowest modes remain and the rate decreases.
std::string not_at_rest(benchmarks::Sample half, benchmarks::Sample last, double tolerance) {
  const std::optional<double> end = benchmarks::end_of_decay(half, last, tolerance);
  return end ? fmt::format("not at rest; extrapolated by a rate that falls: later than {:.3g} s", *end) : "not at rest";
}

void run_ours(const Options& options, int count, const std::string& method) {
  const Scene scene = random_packing(options, count, method);
  const Clock clock;
  Minimization minimization(scene);
  double half_time = 0, half_force = 0;
  while (!minimization.at_rest() && clock.wall() < options.seconds && minimization.iterate())
    if (half_time == 0 && clock.wall() > 0.5 * options.seconds)
      half_time = clock.wall(), half_force = minimization.largest_force();
  const double unit = minimization.force_unit();
  print_row(count, method, minimization.iteration(), minimization.evaluations(), clock, minimization.energy(),
            minimization.largest_force() / unit,
            minimization.at_rest()
                ? ""
                : not_at_rest({half_time, half_force / unit}, {clock.wall(), minimization.largest_force() / unit},
                              options.tolerance));
}

/// Potential energy as an objective of PETSc's limited-memory variable metric method.
struct ForTao {
  statics::PotentialEnergy* energy;
  Clock clock;
  std::int64_t evaluations = 0;
  int dimension;
  double goal, seconds, largest = 0;
};

PetscErrorCode evaluate(Tao, ::Vec x, PetscReal* value, ::Vec gradient, void* context) {
  auto& self = *static_cast<ForTao*>(context);
  const PetscScalar* from;
  PetscScalar* to;
  PetscInt size;
  PetscFunctionBegin;
  PetscCall(VecGetSize(x, &size));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArray(gradient, &to));
  const auto n = static_cast<std::size_t>(size);
  *value = self.energy->evaluate({from, n}, {to, n});
  if (!std::isfinite(*value)) *value = 1e30;  // TAO's line search does not accept infinity
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(VecRestoreArray(gradient, &to));
  ++self.evaluations;
  PetscFunctionReturn(0);
}

PetscErrorCode is_at_rest(Tao tao, void* context) {
  auto& self = *static_cast<ForTao*>(context);
  ::Vec gradient;
  const PetscScalar* g;
  PetscInt size;
  PetscFunctionBegin;
  PetscCall(TaoGetGradient(tao, &gradient, nullptr, nullptr));
  PetscCall(VecGetSize(gradient, &size));
  PetscCall(VecGetArrayRead(gradient, &g));
  self.largest = 0;
  for (PetscInt i = 0; i < size; i += self.dimension) {
    double sum = 0;
    for (int k = 0; k < self.dimension; ++k) sum += g[i + k] * g[i + k];
    self.largest = std::max(self.largest, std::sqrt(sum));
  }
  PetscCall(VecRestoreArrayRead(gradient, &g));
  if (self.largest <= self.goal) PetscCall(TaoSetConvergedReason(tao, TAO_CONVERGED_USER));
  if (self.clock.wall() > self.seconds) PetscCall(TaoSetConvergedReason(tao, TAO_DIVERGED_USER));
  PetscFunctionReturn(0);
}

void run_tao(const Options& options, int count) {
  const Scene scene = random_packing(options, count, "lbfgs");
  statics::PotentialEnergy energy(scene, options.threads > 0 ? options.threads : 2);
  std::vector<double> start = energy.model().bodies.position;
  const double unit = Minimization(scene).force_unit();
  ForTao self{
      .energy = &energy, .dimension = options.dimension, .goal = options.tolerance * unit, .seconds = options.seconds};
  ::Vec x;
  Tao tao;
  parallel::check_petsc(
      VecCreateSeqWithArray(PETSC_COMM_SELF, 1, static_cast<PetscInt>(start.size()), start.data(), &x));
  parallel::check_petsc(TaoCreate(PETSC_COMM_SELF, &tao));
  parallel::check_petsc(TaoSetType(tao, TAOLMVM));
  parallel::check_petsc(TaoSetSolution(tao, x));
  parallel::check_petsc(TaoSetObjectiveAndGradient(tao, nullptr, evaluate, &self));
  parallel::check_petsc(TaoSetConvergenceTest(tao, is_at_rest, &self));
  parallel::check_petsc(TaoSetMaximumIterations(tao, 100000000));
  parallel::check_petsc(TaoSetMaximumFunctionEvaluations(tao, 100000000));
  TaoLineSearch search;  // TAO's default line search interpolates infinite values and fails
  parallel::check_petsc(TaoGetLineSearch(tao, &search));
  parallel::check_petsc(TaoLineSearchSetType(search, TAOLINESEARCHARMIJO));
  parallel::check_petsc(TaoSetFromOptions(tao));
  parallel::check_petsc(TaoSolve(tao));
  PetscInt iterations;
  PetscReal value;
  TaoConvergedReason reason;
  parallel::check_petsc(TaoGetSolutionStatus(tao, &iterations, &value, nullptr, nullptr, nullptr, &reason));
  print_row(count, "TAO lmvm", iterations, self.evaluations, self.clock, value, self.largest / unit,
            reason > 0 ? "" : fmt::format("not at rest ({})", TaoConvergedReasons[reason]));
  parallel::check_petsc(TaoDestroy(&tao));
  parallel::check_petsc(VecDestroy(&x));
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "an unknown processor";
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App program("Random particles to rest");
  program.add_option("--sizes", options.sizes, "numbers of particles")->delimiter(',');
  program.add_option("--methods", options.methods, "lmvm is PETSc's")->delimiter(',');
  program.add_option("--dimension", options.dimension, "2 or 3");
  program.add_option("--filled", options.filled, "of the domain");
  program.add_option("--tolerance", options.tolerance, "largest net force, in units of k / R");
  program.add_option("--threads", options.threads, "0: all cores");
  program.add_option("--seconds", options.seconds, "wall time after which a method is stopped");
  CLI11_PARSE(program, argc, argv);
  fmt::print("{}, commit {}; {}D, filled {}, to a largest force of {} k/R\n", processor(), lichtenberg_version().commit,
             options.dimension, options.filled, options.tolerance);
  fmt::print("{:>8} {:<17}{:>10}{:>12}{:>10}{:>10}{:>16}{:>11}\n", "N", "method", "iterations", "evaluations", "wall s",
             "CPU s", "U / k", "F R/k");
  for (const int count : options.sizes)
    for (const std::string& method : options.methods) {
      if (method == "lmvm") {
        parallel::start_petsc();
        run_tao(options, count);
      } else {
        run_ours(options, count, method);
      }
    }
  parallel::finish_petsc();
}
