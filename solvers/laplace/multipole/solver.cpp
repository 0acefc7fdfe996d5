#include "solvers/laplace/multipole/solver.hpp"

#include <algorithm>
#include <chrono>
#include <numbers>

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
using multipole::KrylovResult;
using multipole::Setting;
using multipole::SolutionData;
using multipole::System;
using multipole::Truncation;

namespace {

/// Bounds of the tolerance; below the lower one rounding stops GMRES. Least relative residual requested of GMRES.
constexpr double finest_tolerance = 1e-13, coarsest_tolerance = 0.1, finest_residual = 1e-15;
/// Error shares of the parts of the method, for wide gaps.
struct ErrorShares {
  Truncation truncation;    ///< Neglected multipoles
  double interactions = 0;  ///< Neglected terms of interactions between disks
  double krylov = 0;        ///< Residual of GMRES
};

ErrorShares error_shares(const MultipoleOptions& options) {
  const double tolerance = options.tolerance;
  if (!options.results_only) return {{tolerance, false}, 0.1 * tolerance, 0.01 * tolerance};
  return {{tolerance, true}, 0.2 * tolerance, 0.003 * tolerance};
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

/// Estimates the error of the field and the results. Errors of potentials and forces are up to ten times GMRES's
/// residual (empirical, for gaps down to 1e-4 R).
double estimate_with_reserve(const SolutionData& solved, const KrylovResult& krylov) {
  return std::max(10 * krylov.residual, multipoles_left_out(solved));
}

/// Estimates the error of charges, potentials and forces only. GMRES's residual is relative to the smaller of their
/// scales; empirical factors make the estimate an upper bound in most cases. Charges that are all 0 are
/// given, and exact. Returns 0 if everything has the same potential.
double estimate_of_results(const SolutionData& solved, const KrylovResult& krylov, const LaplaceSolution& solution) {
  const LaplaceProblem& problem = solved.setting->problem;
  const Scales scales = scales_of(problem, solution);
  if (scales.potential == 0) return 0;
  double unit = scales.potential;
  if (std::ranges::any_of(solution.body_charge, [](double charge) { return charge != 0; })) {
    const double least = small_share * problem.permittivity * scales.potential;
    unit = std::min(unit, std::max(scales.charge, least) / (2 * std::numbers::pi * problem.permittivity));
  }
  return std::max(50 * krylov.residual * krylov.scale / unit,
                  scales.error_of_force(5 * forces_left_out(solved, solution)));
}

}  // namespace

struct MultipoleSolver::Implementation {
  MultipoleOptions options;
  SolutionData last;  ///< Last solution; without a setting until a problem has been solved

  LaplaceSolution solve(const LaplaceProblem& problem);
  void make_far_field(SolutionData& next);
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

LaplaceSolution MultipoleSolver::Implementation::solve(const LaplaceProblem& problem) {
  auto start = std::chrono::steady_clock::now();
  const ErrorShares shares = error_shares(options);
  SolutionData next;
  next.setting = std::make_unique<Setting>(problem, options.unbounded, shares.truncation);
  make_far_field(next);
  const double narrowness = next.setting->arrangement.narrowness;
  const System system(*next.setting, *next.far, narrowness * shares.interactions);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.size());
  if (last.setting) x = system.first_guess(last.setting->layout, last.coefficients, last.extra);
  last = {};
  LaplaceSolution solution;
  solution.unknowns = system.size();
  solution.seconds.setup = seconds_since(start);

  start = std::chrono::steady_clock::now();
  const double residual = std::max(narrowness * shares.krylov, finest_residual);
  const KrylovResult krylov = solve_krylov(system, system.right_hand_side(), residual, x);
  solution.iterations = krylov.iterations;
  solution.seconds.solve = seconds_since(start);

  start = std::chrono::steady_clock::now();
  next.coefficients = system.coefficients(x);
  next.extra = system.extra(x);
  const System::Potentials potentials = system.potentials(x, next.coefficients);
  next.level = potentials.level;
  next.group_potential = solution.group_potential = potentials.group;
  evaluate_bodies(*next.setting, next.coefficients, solution);
  evaluate_sides(*next.setting, next.coefficients, solution);
  solution.residual =
      options.results_only ? estimate_of_results(next, krylov, solution) : estimate_with_reserve(next, krylov);
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
