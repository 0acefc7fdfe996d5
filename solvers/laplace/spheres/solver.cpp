#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "solvers/laplace/spheres/krylov.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg::laplace {

using namespace spheres;

namespace {

/// Measured data about errors of forces, for the next solve. SphereSolver::forget() resets them, so that a resumed run
/// measures the same values again.
struct ForceControl {
  double share = 1;               ///< Factor of the tolerance that the forces of the last solve needed
  double harmonics = 1;           ///< Factor of the accuracy of the degrees that the forces of the last solve needed
  double least_share = 1e-3;      ///< Smaller factors are not tried; rounding raises it
  double least_harmonics = 1e-4;  ///< Likewise; a factor whose degrees are refused raises it
};

}  // namespace

struct SphereSolver::Implementation {
  SphereOptions options;
  std::unique_ptr<parallel::Team> own_team;  ///< Null if the team belongs to the caller
  parallel::Team* team = nullptr;
  std::unique_ptr<System> system;  ///< System of the last solve
  std::vector<double> x;
  History history;
  SphereSolution solution;
  ForceControl forces;
};

namespace {

/// Share of the accuracy that the residual of the iteration may use. It is empirical: with 0.3 the error of the forces
/// doubles (docs/measurements/negative-results.json).
constexpr double residual_share = 0.2;
/// Share of the accuracy for the error of forces due to the residual. The truncation of harmonics may use
/// truncation_share (system.hpp). After few iterations the smallest eigenvalue is too large, hence not the whole rest.
constexpr double force_share = 0.2;
/// Smallest tolerance of the iteration: about fifty roundings.
constexpr double finest_residual = 1e-14;

/// Returns the tolerance for the norm of the residual of x = sqrt(R) a. A charge q on the smallest sphere (R) has x = q
/// / sqrt(R). An error in the dipole of the largest sphere (R') causes a field error there larger by sqrt(R' / R).
/// Narrow gaps tighten the tolerance further. It is bounded below by about fifty roundings or the requested value.
double tolerance_for(const System& system, double accuracy) {
  const double requested_tolerance = residual_share * accuracy;
  if (system.sites().empty()) return requested_tolerance;
  const auto [smallest, largest] = std::ranges::minmax(system.sites(), {}, &Site::radius);
  const double weighed = system.fields().narrowness() * std::sqrt(smallest.radius / largest.radius);
  return std::max(requested_tolerance * weighed, std::min(requested_tolerance, finest_residual));
}

/// Estimates the error of the forces due to the residual, over the largest force on a movable sphere. An error e of x =
/// sqrt(R) a changes a sphere's response by up to e / sqrt(R), and its force by 4 pi eps |x| |e| / R. The error is at
/// most the preconditioned residual over the smallest eigenvalue. It spreads between spheres, so that the sphere with
/// the largest residual counts for all. The largest force counts as at least the rounding of measures of accuracy
/// (scales_of).
double force_error(const System& system, const std::vector<double>& x, const std::vector<double>& product,
                   const SphereSolution& solution, double eigenvalue) {
  const SphereProblem& problem = system.problem();
  std::vector<double> residual = system.right_hand_side();
  for (std::size_t k = 0; k < residual.size(); ++k) residual[k] -= product[k];
  system.precondition(residual.data());
  const std::vector<int> start = starts(system.sites());
  const int spheres = static_cast<int>(problem.spheres.size()),
            movable = problem.movable < 0 ? spheres : problem.movable;
  double strongest = 0, error = 0;  // Squares
  for (int i = 0; i < spheres; ++i) {
    double strength = 0, left = 0;
    for (int k = start[i]; k < start[i + 1]; ++k) strength += x[k] * x[k], left += residual[k] * residual[k];
    if (i < movable) strongest = std::max(strongest, strength / problem.spheres[i].radius);
    error = std::max(error, left / problem.spheres[i].radius);
  }
  if (strongest == 0) return 0;
  const Scales scales = scales_of(problem, solution);
  return 4 * std::numbers::pi * problem.permittivity * std::sqrt(strongest * error) /
         (eigenvalue * std::max(scales.force, scales.force_rounding));
}

/// Returns the norm of the harmonics of degree l of one sphere.
double norm_of_degree(const double* multipoles, int l) {
  double squares = 0;
  for (int k = harmonics(l - 1); k < harmonics(l); ++k) squares += multipoles[k] * multipoles[k];
  return std::sqrt(squares);
}

/// Multipoles without those that have the proportions of close-pair corrections.
struct SmoothMultipoles {
  std::vector<double> values;
  std::vector<char> corrected;  ///< Per sphere: true if it has a correction
};

SmoothMultipoles without_corrections(const System& system, const std::vector<double>& x, std::vector<double> all) {
  SmoothMultipoles smooth{std::move(all), std::vector<char>(system.sites().size())};
  const std::vector<int> start = starts(system.sites());
  const std::vector<ClosePair>& pairs = system.fields().close_pairs();
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (const PairCorrection& correction : pairs[p].corrections) {
      const int sphere = correction.sphere, degree = system.sites()[sphere].degree;
      std::vector<double> harmonic(harmonics(degree));
      regular_harmonics(correction.axis, degree, harmonic.data());
      const double scale = correction.sign * system.amplitude(x.data(), p);
      for (int l = 0; l <= degree; ++l)
        for (int k = harmonics(l - 1); k < harmonics(l); ++k)
          smooth.values[start[sphere] + k] -= scale * correction.multipoles[l] * harmonic[k];
      smooth.corrected[sphere] = 1;
    }
  return smooth;
}

/// Estimates the error of the forces due to the truncation of harmonics, over the largest force on a movable sphere. A
/// force over 4 pi eps is a sum over l of about l a_(l-1) a_l. Harmonics s that no close-pair correction continues are
/// omitted beyond the degree p. Near touching conductors they fall like exp(-sqrt(2 beta l)), to e at l = p. From one
/// degree to the next they then fall by exp(ln(e) / (2p)), and at a gap by more. Terms p s_(p-1) s_p fall by its
/// square, terms p a_(p-1) s_p with a correction's slowly falling a by the factor itself. The later terms are a
/// geometric series. Spheres that reflect small ones omit none; dielectrics are not estimated.
double truncation_error(const System& system, const std::vector<double>& x, const SphereSolution& solution) {
  const SphereProblem& problem = system.problem();
  const std::vector<double> all = system.multipoles(x.data());
  const auto [smooth, corrected] = without_corrections(system, x, all);
  const std::vector<int> start = starts(system.sites());
  std::vector<char> reflects(system.sites().size());
  for (const Reflection& reflection : system.fields().reflections()) reflects[reflection.large] = 1;
  const int spheres = static_cast<int>(problem.spheres.size()),
            movable = problem.movable < 0 ? spheres : problem.movable;
  double worst = 0;
  for (int i = 0; i < movable; ++i) {
    if (reflects[i] || !problem.spheres[i].is_conductor()) continue;
    const int p = system.sites()[i].degree;
    const double *a = &all[start[i]], *s = &smooth[start[i]];
    const double falls = std::pow(system.fields().last_harmonics(), (corrected[i] ? 0.5 : 1) / p);
    const double last =
        norm_of_degree(a, p - 1) * norm_of_degree(s, p) + norm_of_degree(s, p - 1) * norm_of_degree(a, p);
    worst = std::max(worst, (corrected[i] ? 1 : 0.5) * p * last * falls / (1 - falls));
  }
  const Scales scales = scales_of(problem, solution);
  const double unit = 4 * std::numbers::pi * problem.permittivity;
  return unit * worst / std::max(scales.force, scales.force_rounding);
}

/// Tests whether the forces need higher degrees. Sets the factor of the accuracy that the degrees need, in proportion
/// to the error.
bool has_too_few_harmonics(const System& system, double accuracy, const std::vector<double>& x,
                           const SphereSolution& solution, ForceControl& forces) {
  // Empirical reserve: the error is only about proportional to the accuracy of the degrees, which are whole numbers.
  constexpr double margin = 0.7;
  if (system.fields().has_fixed_degree()) return false;
  const double used = system.fields().accuracy() / accuracy;
  const double excess = truncation_error(system, x, solution) / (truncation_share * accuracy);
  forces.harmonics = excess > 0 ? std::clamp(margin * used / excess, forces.least_harmonics, 1.0) : 1;
  return excess > 1 && forces.harmonics < used;
}

/// Iterates until the residual is small enough for potentials, charges and forces. Forces of distant or neutral spheres
/// are much smaller than the product of their charges, relative to which the iteration stops; they need a smaller
/// tolerance. Computes the solution.
KrylovResult iterate(const System& system, double accuracy, ForceControl& forces, std::vector<double>& x,
                     SphereSolution& solution) {
  constexpr double margin = 0.7;  // Reserve: errors are about proportional to the residual
  const double tolerance = tolerance_for(system, accuracy), finest = std::min(tolerance, finest_residual);
  const auto goal_for = [&] { return std::max(std::clamp(forces.share, forces.least_share, 1.0) * tolerance, finest); };
  double goal = goal_for(), reached = tolerance, eigenvalue = 1;
  std::optional<KrylovResult> found;
  Timings seconds;
  for (int iterations = 0;;) {
    try {
      const Stopwatch watch(seconds.solve);
      found = solve_krylov(system, goal, x);
      system.enforce_charges(x.data());
    } catch (const Failure&) {  // rounding excludes the smaller tolerance, as with large couplings
      forces.least_share = found ? reached / tolerance : std::min(10 * goal / tolerance, 1.0);
      if (found) return *std::move(found);
      if (goal == tolerance) throw;
      goal = tolerance;
      continue;
    }
    reached = goal;
    found->iterations = iterations += found->iterations;
    eigenvalue = std::min(eigenvalue, found->eigenvalue);
    const Stopwatch watch(seconds.forces);
    solution = system.results(x, found->product);
    solution.seconds = seconds;
    const double excess = force_error(system, x, found->product, solution, eigenvalue) / (force_share * accuracy);
    forces.share = excess > 0 ? margin * found->residual / (excess * tolerance) : 1;
    const double next = goal_for();
    if (!(excess > 1) || !(next < goal)) return *std::move(found);
    goal = next;
  }
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
  const auto set_up = [&](double share) {
    const Stopwatch watch(seconds.setup);
    const System* past = system ? system.get() : my.system.get();
    system = std::make_unique<System>(problem, my.options, *my.team, past, share);
  };
  const auto can_set_up = [&](double share) {
    try {
      set_up(share);
      return true;
    } catch (const InputError&) {  // The largest degree does not suffice
    } catch (const Failure&) {     // or that of a correction
    }
    return false;
  };
  const auto solve = [&] {
    {
      const Stopwatch watch(seconds.solve);
      if (!my.history.empty() && my.history.front().sites.size() != system->sites().size()) my.history.clear();
      x = system->start(my.history, tolerance_for(*system, my.options.accuracy));
    }
    const int before = krylov.iterations;
    krylov = iterate(*system, my.options.accuracy, my.forces, x, solution);
    krylov.iterations += before;
    seconds.solve += solution.seconds.solve, seconds.forces += solution.seconds.forces;
    my.history.push_front(system->past(x, solution.group_potential));
  };
  if (my.forces.harmonics == 1 || !can_set_up(my.forces.harmonics)) set_up(1);
  solve();
  if (has_too_few_harmonics(*system, my.options.accuracy, x, solution, my.forces)) {
    if (can_set_up(my.forces.harmonics)) {
      solve();
      my.history.erase(my.history.begin() + 1);
    } else {
      my.forces.harmonics = my.forces.least_harmonics = system->fields().accuracy() / my.options.accuracy;
    }
  }
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
  implementation_->forces = {};
}

}  // namespace lichtenberg::laplace
