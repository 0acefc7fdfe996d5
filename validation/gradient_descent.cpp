// Tests chapter 6's statements on the approximate gradient descent (D 6.30): range of convergence in eta, and rate.
//
// A step maps the missing charges q to (1 - eta C) q (D 6.32 with corrected sign), with C the symmetric positive
// definite capacitance matrix of the floating groups. With eigenvalues lambda of C, the error finally changes by the
// factor
//   max |1 - eta lambda|  per step.
// The descent converges for every start if and only if eta < 2 / lambda_max. The bound eta_c (D 6.35) is 2 q.Cq /
// |Cq|^2, between 2 / lambda_max and 2 / lambda_min: it states whether the next step reduces the error, not whether a
// constant eta converges. Its limit (D 6.36), 2 C_kk / sum_i C_ik^2, applies to a missing charge on conductor k alone
// and is at least 2 / lambda_max for every k.
//
//   gradient_descent         N = 2 and 8 floating disks, S = 64
//   gradient_descent long    N = 2 ... 128, S = 192

#include <Eigen/Core>
#include <random>

#include "solvers/error.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "tests/dense_algebra.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace gradient_descent_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

/// Returns `count` disks at random positions in the unit box with centres at least three radii apart; the bottom side
/// is grounded. Charges make neighbouring potentials different.
LaplaceProblem disks(int count, double radius) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.sides[bottom].kind = Side::Kind::electrode;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(2 * radius, 1 - 2 * radius);
  while (static_cast<int>(problem.bodies.size()) < count) {
    const Disk disk{{coordinate(random), coordinate(random)}, radius};
    const bool free =
        std::ranges::all_of(problem.bodies, [&](const Body& body) { return gap(disk, body.shape) > radius; });
    if (!free) continue;
    const int index = static_cast<int>(problem.bodies.size());
    problem.bodies.push_back({disk, index});
    problem.groups.push_back({.charge = index % 2 == 0 ? 1.0 : -0.5});
  }
  return problem;
}

/// Returns the capacitance matrix of the descent's own lattice and contours. It is symmetric up to the staircase error,
/// which the descent also neglects.
Eigen::MatrixXd lattice_capacitance(const LaplaceProblem& problem, const RelaxationOptions& options) {
  RelaxationSolver solver(options);
  const std::vector<double> c = capacitance_matrix(solver, problem);
  const auto n = static_cast<Eigen::Index>(problem.groups.size());
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(c.data(), n, n);
}

/// Returns the factor of the missing charge per step, averaged over the last of `steps` with a constant eta.
double observed_factor(const LaplaceProblem& problem, RelaxationOptions options, double eta, int steps) {
  options.eta = eta;
  options.tolerance = 1e-14;  // not reached, so that all steps are made
  options.largest_iterations = steps;
  RelaxationSolver solver(options);
  try {
    solver.solve(problem);
  } catch (const Failure&) {
    // The lack of convergence is intended.
  }
  const std::vector<double>& error = solver.error_history();
  constexpr int last = 10;
  return std::pow(error.back() / error[error.size() - 1 - last], 0.5 / last);
}

int steps_to_take(double factor) {
  return factor < 1 ? std::min(200, static_cast<int>(std::log(1e-9) / std::log(factor))) : 200;
}

struct Steps {
  double diverges = 0;  ///< 2 / lambda_max
  double isolated = 0;  ///< minimum of D 6.36
  double slowest = 0;   ///< smallest eigenvalue of C
  double fastest = 0;   ///< largest
};

Steps critical_steps(const Eigen::MatrixXd& c) {
  Steps steps;
  const Eigen::VectorXd lambda = real_parts_of_eigenvalues(c);
  steps.fastest = lambda.maxCoeff();
  steps.slowest = lambda.minCoeff();
  steps.diverges = 2 / steps.fastest;
  steps.isolated = INFINITY;
  for (Eigen::Index k = 0; k < c.cols(); ++k)
    steps.isolated = std::min(steps.isolated, 2 * c(k, k) / c.col(k).squaredNorm());
  return steps;
}

}  // namespace

int validate(int argc, char** argv) {
  const bool is_long = long_run_requested(argc, argv);
  const int sites = is_long ? 192 : 64;
  // Each potential solve has sixteen times the sweeps of the source (4 n10). With the source's number, unconverged
  // potentials change the factors by up to 10 % for insulated sides and few disks.
  const RelaxationOptions options{.sites = sites, .sweeps_factor = 64};
  Report report("Approximate gradient descent of the potentials (D 6.30-6.36)");
  for (const int count : is_long ? std::vector<int>{2, 8, 32, 128} : std::vector<int>{2, 8}) {
    const LaplaceProblem problem = disks(count, is_long ? 0.02 : 0.04);
    const Steps steps = critical_steps(lattice_capacitance(problem, options));
    report.section(
        fmt::format("N = {}: diverges from eta = 2 / lambda_max = {:.4f} on; least of D 6.36 {:.4f}; "
                    "condition number {:.1f}",
                    count, steps.diverges, steps.isolated, steps.fastest / steps.slowest));
    // The factor is that of one eigenvector after the others have decayed: 200 steps, or fewer if the error reaches
    // 1e-9, where unconverged relaxation dominates. The bound allows 1 % for the remaining eigenvectors.
    const double least = steps.isolated / steps.diverges;  // minimum of D 6.36; at least 1 because C is symmetric
    for (const double fraction : {0.5, 0.9, 0.97, 1.03, 1.1, least}) {
      const double eta = fraction * steps.diverges;
      const double expected = std::max(std::abs(1 - eta * steps.fastest), std::abs(1 - eta * steps.slowest));
      const double observed = observed_factor(problem, options, eta, steps_to_take(expected));
      report.at_most(fmt::format("eta = {:.2f} of that: {} a step by {:.4f}, theory {:.4f}; % off", fraction,
                                 observed < 1 ? "falls" : "grows", observed, expected),
                     100 * std::abs(observed / expected - 1), 1);
    }
  }
  return report.exit_status();
}

const lichtenberg::validation::Program program("gradient_descent", validate);

}  // namespace gradient_descent_validation
