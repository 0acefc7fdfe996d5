#include "solvers/laplace/multipole/solver.hpp"

#include <algorithm>
#include <chrono>
#include <numbers>
#include <sstream>

#include "solvers/error.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/krylov.hpp"
#include "solvers/laplace/multipole/potential.hpp"
#include "solvers/laplace/multipole/results.hpp"
#include "solvers/laplace/multipole/system.hpp"

namespace lichtenberg::laplace {

using multipole::Cells;
using multipole::Complex;
using multipole::FarField;
using multipole::Gmres;
using multipole::Setting;
using multipole::SolutionData;
using multipole::System;
using multipole::Truncation;

namespace {

/// Bounds of the tolerance; below the lower one rounding stops GMRES.
constexpr double finest_tolerance = 1e-13, coarsest_tolerance = 0.1;

/// Error shares of the parts of the method, for wide gaps.
struct ErrorShares {
  Truncation truncation;    ///< Neglected multipoles
  double interactions = 0;  ///< Neglected terms of interactions between disks
};

ErrorShares error_shares(const MultipoleOptions& options) {
  const double tolerance = options.tolerance;
  if (!options.results_only) return {{tolerance, false}, 0.1 * tolerance};
  return {{tolerance, true}, 0.2 * tolerance};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void check(const MultipoleOptions& options) {
  if (!(options.tolerance >= finest_tolerance && options.tolerance <= coarsest_tolerance))
    throw InputError("the multipole method's tolerance must be between 1e-13 and 0.1");
  if (options.cells < 1) throw InputError("the multipole method's field must have at least one cell");
}

void check(const LaplaceProblem& problem, bool unbounded) {
  problem.check();
  refuse_couplings(problem, "the multipole method");
  refuse_link_models(problem, "the multipole method");
  for (const Side& side : problem.sides) {
    if (side.profile) throw InputError("the multipole method needs sides of constant potential, not a profile");
    if (unbounded && side.kind == Side::Kind::electrode)
      throw InputError("an unbounded problem has no electrode sides: all sides must be insulating");
  }
}

/// Estimates the sum of the neglected multipoles of the worst disk over the largest coefficient. The sum is
/// extrapolated as a geometric series from the last multipoles, with the ratio of their second half.
double multipoles_left_out(const SolutionData& solved) {
  constexpr double largest_ratio = 0.999;
  double worst = 0, largest = 0;
  for (const Complex& a : solved.coefficients) largest = std::max(largest, std::abs(a));
  for (int i = 0; i < solved.setting->arrangement.disks; ++i) {
    const Complex* a = &solved.coefficients[solved.setting->layout.start[i]];
    const int order = solved.setting->layout.order(i), half = order / 2;
    if (half < 2) continue;
    // By symmetry every second coefficient may vanish, so pairs are compared.
    const double last = std::max(std::abs(a[order]), std::abs(a[order - 1]));
    const double middle = std::max(std::abs(a[half]), std::abs(a[half - 1]));
    if (last == 0) continue;
    const double ratio = middle > last ? std::pow(last / middle, 1.0 / (order - half)) : 1.0;
    worst = std::max(worst, last / (1 - std::min(ratio, largest_ratio)));
  }
  return largest > 0 ? worst / largest : 0.0;
}

/// Estimates the effect of the neglected multipoles on the largest force. The last multipoles contribute p (p - 1)
/// conj(a_(p-1)) a_p, the first neglected ones p (p + 1) conj(a_p) a_(p+1). The ratio is two steps of the decay times
/// (p + 1) / (p - 1), which matters for low orders.
double forces_left_out(const SolutionData& solved, const LaplaceSolution& solution) {
  const multipole::Setting& setting = *solved.setting;
  std::vector<Complex> shorter = solved.coefficients;
  for (int i = 0; i < setting.arrangement.disks; ++i)
    if (setting.layout.order(i) > 0) shorter[setting.layout.start[i + 1] - 1] = 0;
  LaplaceSolution without;
  evaluate_bodies(setting, shorter, without);
  double worst = 0;
  for (int i = 0; i < setting.arrangement.disks; ++i) {
    if (!has_force(setting.problem, i)) continue;
    const double decay = setting.arrangement.decay[i], order = setting.layout.order(i);
    const double next_over_last = order > 1 ? (order + 1) / (order - 1) * decay * decay : 0;
    worst = std::max(worst, next_over_last * norm(solution.body_force[i] - without.body_force[i]));
  }
  return worst;
}

}  // namespace

struct MultipoleSolver::Implementation {
  MultipoleOptions options;
  SolutionData last;  ///< Last solution; without a setting until a problem has been solved

  LaplaceSolution solve(const LaplaceProblem& problem);
  void make_far_field(SolutionData& next);
  LaplaceSolution results(const System& system, const Eigen::VectorXd& x, SolutionData& next) const;
  double iterate(const System& system, Gmres& gmres, SolutionData& next, LaplaceSolution& solution) const;
  double estimate(const SolutionData& solved, double difference, const LaplaceSolution& solution) const;
  const SolutionData& solved() const;
};

/// Makes the far field, or takes over the last one with its kernel if it fits.
void MultipoleSolver::Implementation::make_far_field(SolutionData& next) {
  const Cells& cells = next.setting->arrangement.cells;
  const double terms = std::log(error_shares(options).interactions) / std::log(cells.separation);
  const int order = static_cast<int>(std::ceil(terms)) + 1;
  if (last.far && last.far->fits(next.setting->mirrors, cells, order))
    next.far = std::move(last.far);
  else
    next.far = std::make_unique<FarField>(next.setting->mirrors, next.setting->lattice, cells, order);
}

/// Computes potentials, charges and forces from the unknowns x, and sets the data of `next` that follow from x.
LaplaceSolution MultipoleSolver::Implementation::results(const System& system, const Eigen::VectorXd& x,
                                                         SolutionData& next) const {
  next.coefficients = system.coefficients(x);
  next.extra = system.extra(x);
  const System::Potentials potentials = system.potentials(x, next.coefficients);
  next.level = potentials.level;
  LaplaceSolution solution;
  next.group_potential = solution.group_potential = potentials.group;
  evaluate_bodies(*next.setting, next.coefficients, solution);
  return solution;
}

/// Iterates until the results of two iterates differ by at most the tolerance, where the residual of the second one is
/// ten times smaller. Computes the results of the second one, and returns the difference. If errors decrease with the
/// residual, the difference is the error of the first iterate. The second one is ten times better, which is the reserve
/// for parts of the error that decrease more slowly. Relative errors of small charges and forces, and of potentials at
/// narrow gaps, can exceed the residual by orders of magnitude.
double MultipoleSolver::Implementation::iterate(const System& system, Gmres& gmres, SolutionData& next,
                                                LaplaceSolution& solution) const {
  constexpr double fall = 0.1, finest_residual = 1e-15;
  const LaplaceProblem& problem = next.setting->problem;
  double goal = fall * options.tolerance;
  if (!gmres.reduce_to(goal)) {
    std::ostringstream message;
    message << "the multipole method's iteration stopped at a relative residual of " << gmres.residual() << " after "
            << gmres.iterations() << " steps, short of " << goal;
    throw Failure(message.str());
  }
  solution = results(system, gmres.solution(), next);
  double difference = 0;
  bool continues = true;  // false if rounding limits the residual
  while (continues && gmres.residual() > finest_residual) {
    goal = std::max(fall * std::min(goal, gmres.residual()), finest_residual);
    continues = gmres.reduce_to(goal);
    const LaplaceSolution before = std::exchange(solution, results(system, gmres.solution(), next));
    difference = largest_error(problem, before, solution, scales_of(problem, solution));
    if (difference <= options.tolerance) break;
  }
  return difference;
}

/// Estimates the error from the difference of two iterates and the neglected multipoles.
double MultipoleSolver::Implementation::estimate(const SolutionData& solved, double difference,
                                                 const LaplaceSolution& solution) const {
  const double left_out =
      options.results_only
          ? scales_of(solved.setting->problem, solution).error_of_force(5 * forces_left_out(solved, solution))
          : multipoles_left_out(solved);
  return std::max(difference, left_out);
}

LaplaceSolution MultipoleSolver::Implementation::solve(const LaplaceProblem& problem) {
  auto start = std::chrono::steady_clock::now();
  const ErrorShares shares = error_shares(options);
  SolutionData next;
  next.setting = std::make_unique<Setting>(problem, options.unbounded, shares.truncation);
  make_far_field(next);
  const System system(*next.setting, *next.far, next.setting->arrangement.narrowness * shares.interactions);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.size());
  if (last.setting) x = system.first_guess(last.setting->layout, last.coefficients, last.extra);
  last = {};
  const double setup = seconds_since(start);

  start = std::chrono::steady_clock::now();
  Gmres gmres(system, std::move(x));
  LaplaceSolution solution;
  const double difference = iterate(system, gmres, next, solution);
  solution.unknowns = system.size();
  solution.iterations = gmres.iterations();
  solution.seconds.setup = setup;
  solution.seconds.solve = seconds_since(start);

  start = std::chrono::steady_clock::now();
  evaluate_sides(*next.setting, next.coefficients, solution);
  solution.residual = estimate(next, difference, solution);
  solution.seconds.forces = seconds_since(start);
  last = std::move(next);
  return solution;
}

const SolutionData& MultipoleSolver::Implementation::solved() const {
  if (!last.setting) throw Failure("the multipole method has no field yet: nothing has been solved");
  return last;
}

MultipoleSolver::MultipoleSolver(MultipoleOptions options) : implementation_(std::make_unique<Implementation>()) {
  check(options);
  implementation_->options = options;
}
MultipoleSolver::~MultipoleSolver() = default;

LaplaceSolution MultipoleSolver::solve(const LaplaceProblem& problem) {
  check(problem, implementation_->options.unbounded);
  return implementation_->solve(problem);
}

double MultipoleSolver::potential(Vec2 p) const {
  return potential_at(multipole::to_complex(p), implementation_->solved(), 0.01 * implementation_->options.tolerance)
      .value;
}

Field MultipoleSolver::field() const {
  const SolutionData& solved = implementation_->solved();
  const MultipoleOptions& options = implementation_->options;
  const Vec2 size = solved.setting->problem.size;
  Field field;
  field.h = std::max(size.x, size.y) / options.cells;
  field.nx = static_cast<int>(std::lround(size.x / field.h));
  field.ny = static_cast<int>(std::lround(size.y / field.h));
  for (int j = 0; j < field.ny; ++j)
    for (int i = 0; i < field.nx; ++i) {
      const auto [value, body] =
          potential_at({(i + 0.5) * field.h, (j + 0.5) * field.h}, solved, 0.01 * options.tolerance);
      field.value.push_back(value);
      field.body.push_back(body);
    }
  return field;
}

long multipole_unknowns(const LaplaceProblem& problem, const MultipoleOptions& options) {
  check(options);
  check(problem, options.unbounded);
  const multipole::Mirrors mirrors = options.unbounded ? multipole::Mirrors() : multipole::Mirrors(problem);
  const multipole::Unknowns unknowns(problem, mirrors, {problem, mirrors, error_shares(options).truncation});
  return unknowns.multipoles + unknowns.others;
}

void MultipoleSolver::forget() { implementation_->last = {}; }

}  // namespace lichtenberg::laplace
