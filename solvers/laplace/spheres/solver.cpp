#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/krylov.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg::laplace {

using namespace spheres;

struct SphereSolver::Implementation {
  SphereOptions options;
  std::unique_ptr<parallel::Team> own_team;  ///< Null if the team belongs to the caller
  parallel::Team* team = nullptr;
  std::unique_ptr<System> system;  ///< System of the last solve
  std::vector<double> x;
  History history;
  SphereSolution solution;
};

namespace {

/// Returns the tolerance for the norm of the residual of x = sqrt(R) a. A charge q on the smallest sphere (R) has x = q
/// / sqrt(R). An error in the dipole of the largest sphere (R') causes a field error there larger by sqrt(R' / R).
/// Narrow gaps tighten the tolerance further. It is bounded below by about fifty roundings or the requested value. The
/// factor 0.2 is empirical: with 0.3 the error of the forces doubles (docs/measurements/negative-results.json).
double tolerance_for(const System& system, double accuracy) {
  const double requested_tolerance = 0.2 * accuracy;
  if (system.sites().empty()) return requested_tolerance;
  const auto [smallest, largest] = std::ranges::minmax(system.sites(), {}, &Site::radius);
  const double weighed = system.fields().narrowness() * std::sqrt(smallest.radius / largest.radius);
  return std::max(requested_tolerance * weighed, std::min(requested_tolerance, 1e-14));
}

}  // namespace

SphereSolver::SphereSolver(SphereOptions options, parallel::Team& team)
    : implementation_(std::make_unique<Implementation>()) {
  if (!(options.accuracy >= 1e-12 && options.accuracy <= 0.1))
    throw InputError(fmt::format("accuracy = {}: the solver of spheres takes 1e-12 to 0.1", options.accuracy));
  if (options.degree < 0 || options.degree > largest_degree)
    throw InputError(fmt::format("degree = {}: the solver of spheres takes 1 to {}, or 0 to choose it by the accuracy",
                                 options.degree, largest_degree));
  implementation_->options = options;
  implementation_->team = &team;
}

SphereSolver::SphereSolver(SphereOptions options, std::unique_ptr<parallel::Team> team) : SphereSolver(options, *team) {
  implementation_->own_team = std::move(team);
}

SphereSolver::~SphereSolver() = default;
SphereSolver::SphereSolver(SphereSolver&&) noexcept = default;

SphereSolution SphereSolver::solve(const SphereProblem& problem) {
  problem.check();
  Implementation& my = *implementation_;
  SphereSolution solution;
  Timings seconds;
  std::unique_ptr<System> system;
  std::vector<double> x;
  KrylovResult krylov;
  {
    const Stopwatch watch(seconds.setup);
    system = std::make_unique<System>(problem, my.options, *my.team, my.system.get());
  }
  {
    const Stopwatch watch(seconds.solve);
    const double tolerance = tolerance_for(*system, my.options.accuracy);
    if (!my.history.empty() && my.history.front().sites.size() != system->sites().size()) my.history.clear();
    x = system->start(my.history, tolerance);
    krylov = solve_krylov(*system, tolerance, x);
    system->enforce_charges(x.data());
  }
  {
    const Stopwatch watch(seconds.forces);
    solution = system->results(x, krylov.product);
  }
  my.history.push_front(system->past(x, solution.group_potential));
  if (my.history.size() > longest_history) my.history.pop_back();
  for (const Site& site : system->sites()) solution.degree = std::max(solution.degree, site.degree);
  solution.unknowns = system->size();
  solution.iterations = krylov.iterations;
  solution.residual = krylov.residual;
  solution.seconds = seconds;
  my.system = std::move(system);
  my.x = std::move(x);
  my.solution = solution;
  return solution;
}

SphereForecast SphereSolver::forecast(const SphereProblem& problem) const {
  problem.check();
  const System system(problem, implementation_->options, *implementation_->team, nullptr);
  SphereForecast forecast{.unknowns = system.size()};
  if (system.sites().empty()) return forecast;
  const auto [least, largest] = std::ranges::minmax(system.sites(), {}, &Site::degree);
  forecast.least_degree = least.degree, forecast.largest_degree = largest.degree;
  return forecast;
}

std::vector<PointField> SphereSolver::field(std::span<const Vec3> points) const {
  const Implementation& my = *implementation_;
  if (!my.system) throw Failure("the field of spheres is not available before a solve");
  const System& system = *my.system;
  if (!system.fields().reflections().empty())
    throw Failure("the field at points is not available near a sphere that is much larger than its neighbour");
  std::vector<PointField> result(points.size());
  std::vector<Vec3> outside_points;
  std::vector<std::size_t> outside;
  const double unit = system.sites().empty() ? 1 : 1e-3 * system.sites()[0].radius;
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (std::size_t i = 0; i < system.sites().size() && result[p].sphere < 0; ++i)
      if (norm(points[p] - system.sites()[i].centre) < system.sites()[i].radius) result[p].sphere = static_cast<int>(i);
    if (result[p].sphere >= 0) {
      result[p].potential = my.solution.group_potential[system.problem().spheres[result[p].sphere].group];
      continue;
    }
    outside.push_back(p);
    outside_points.push_back(points[p]);
  }
  std::vector<double> local(4 * outside_points.size());
  system.fields().add_at(outside_points, unit, system.multipoles(my.x.data()).data(), local.data(), *my.team);
  for (std::size_t k = 0; k < outside.size(); ++k) {
    const double* b = local.data() + 4 * k;
    PointField& at_point = result[outside[k]];
    at_point.potential = b[0] + system.wall().at(points[outside[k]]);
    at_point.field = Vec3{b[at(1, 1)], b[at(1, -1)], b[at(1, 0)]} * (-1 / unit) - system.wall().slope;
    const std::vector<ClosePair>& pairs = system.fields().close_pairs();
    for (std::size_t p = 0; p < pairs.size(); ++p)
      for (const PairCorrection& correction : pairs[p].corrections)
        add_correction(correction, system.sites()[correction.sphere], system.amplitude(my.x.data(), p),
                       points[outside[k]], at_point.potential, at_point.field);
  }
  return result;
}

std::vector<double> SphereSolver::capacitance_matrix(const SphereProblem& problem) {
  SphereProblem unit = problem;
  unit.side_potential.fill(0);
  unit.uniform_field = {};
  unit.couplings.clear();
  for (Group& group : unit.groups) group = {.floating = false};
  unit.check();
  const Implementation& my = *implementation_;
  const System system(unit, my.options, *my.team, my.system.get());
  std::vector<double> matrix = unit_charges(system, tolerance_for(system, my.options.accuracy));
  for (double& charge : matrix) charge *= 4 * std::numbers::pi * problem.permittivity;
  return matrix;
}

void SphereSolver::forget() {
  implementation_->system.reset();
  implementation_->x.clear();
  implementation_->history.clear();
}

}  // namespace lichtenberg::laplace
