#include "solvers/laplace/relaxation/solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::laplace {
namespace {

constexpr int electrode_site = -2;

class LapTimer {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

int whole_cells(double length, double spacing) {
  const double cells = length / spacing;
  if (std::abs(cells - std::round(cells)) > 1e-6)
    throw InputError("the box must be a whole number of lattice spacings wide and high, but one side has " +
                     std::to_string(cells) + " of them; change the number of sites or the box");
  return static_cast<int>(std::lround(cells));
}

/// Smallest rectangle around a shape that can contain sites, in the box [0, size].
struct Extent {
  Vec2 low, high;
};
Extent extent(const Disk& disk, Vec2) {
  const Vec2 r = {disk.radius, disk.radius};
  return {disk.centre - r, disk.centre + r};
}
Extent extent(const Bar& bar, Vec2) {
  const Vec2 half = {0.5 * bar.width, 0.5 * bar.width};
  return {Vec2{std::min(bar.from.x, bar.to.x), std::min(bar.from.y, bar.to.y)} - half,
          Vec2{std::max(bar.from.x, bar.to.x), std::max(bar.from.y, bar.to.y)} + half};
}
Extent extent(const Ring&, Vec2 size) { return {{0, 0}, size}; }
Extent extent(const Freeform&, Vec2) { return {}; }  // refused before

/// The nx x ny points origin + (i, j) h.
struct Points {
  Vec2 origin;
  double h;
  int nx, ny;
};

/// Assigns `body` to every point inside the shape that is still fluid.
template <class S>
void paint(const S& shape, int body, Vec2 size, const Points& points, std::vector<int>& owner) {
  const auto [origin, h, nx, ny] = points;
  const Extent box = extent(shape, size);
  const int i0 = std::max(0, static_cast<int>(std::floor((box.low.x - origin.x) / h)));
  const int j0 = std::max(0, static_cast<int>(std::floor((box.low.y - origin.y) / h)));
  const int i1 = std::min(nx - 1, static_cast<int>(std::ceil((box.high.x - origin.x) / h)));
  const int j1 = std::min(ny - 1, static_cast<int>(std::ceil((box.high.y - origin.y) / h)));
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      int& site = owner[j * nx + i];
      if (site == Lattice::fluid && signed_distance(shape, {origin.x + i * h, origin.y + j * h}) <= 0) site = body;
    }
}

std::vector<int> paint_bodies(const LaplaceProblem& problem, const Points& points) {
  std::vector<int> owner(static_cast<std::size_t>(points.nx) * points.ny, Lattice::fluid);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b)
    std::visit([&](const auto& shape) { paint(shape, static_cast<int>(b), problem.size, points, owner); },
               problem.bodies[b].shape);
  return owner;
}

bool is_electrode(const Side& side) { return side.kind == Side::Kind::electrode; }

}  // namespace

double over_relaxation(int sites) { return 2 / (1 + std::numbers::pi / sites); }

double sweeps_per_decade(int sites) { return -1 / std::log10(1 - 4 * std::numbers::pi / (sites + 1)); }

RelaxationSolver::RelaxationSolver(RelaxationOptions options) : options_(options) {
  // 4 pi / (S + 1) of D 6.9 must be below one.
  if (options.sites < 16) throw InputError("the relaxation needs at least 16 sites along the longer side");
  if (options.surface_points < 8) throw InputError("the relaxation needs at least 8 surface points a body");
  if (!(options.eta >= 0) || !(options.sweeps_factor > 0) || !(options.tolerance > 0) || options.largest_iterations < 1)
    throw InputError(
        "the relaxation's eta must not be negative, and its sweeps, tolerance and iterations must be positive");
}

void RelaxationSolver::forget() {
  lattice_ = Lattice();
  body_potential_.clear();
}

LaplaceSolution RelaxationSolver::solve(const LaplaceProblem& problem) {
  LaplaceSolution solution;
  LapTimer timer;
  set_up_lattice(problem);
  first_potentials();
  solution.seconds.setup = timer.lap();

  Estimate now;
  do {
    if (solution.iterations == options_.largest_iterations)
      throw Failure("the relaxation did not reach the charges within " + std::to_string(solution.iterations) +
                    " potential solves: the error is " + std::to_string(std::max(now.charge_error, now.leftover)) +
                    " of the largest charge; allow more iterations, a larger tolerance or another eta");
    if (solution.iterations > 0 && is_relaxed(now)) descend(now);
    now = estimate();
    ++solution.iterations;
  } while (now.charge_error > options_.tolerance || now.leftover > options_.tolerance);
  solution.seconds.solve = timer.lap();

  solution.group_potential = group_potential_;
  solution.residual = std::max(now.charge_error, now.leftover);
  solution.unknowns = lattice_.fluid_sites() + std::count_if(problem.groups.begin(), problem.groups.end(),
                                                             [](const Group& group) { return group.floating; });
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    body_potential_[b] = group_potential_[problem.bodies[b].group];
    solution.body_charge.push_back(body_charge(b));
    solution.body_force.push_back(body_force(b));
  }
  for (int side = 0; side < 4; ++side)
    if (is_electrode(problem.sides[side]))
      solution.side_charge[side] = problem.permittivity * lattice_.flux_through(side);
  solution.energy = 0.5 * problem.permittivity * lattice_.dirichlet_integral();
  solution.seconds.forces = timer.lap();
  return solution;
}

void RelaxationSolver::set_up_lattice(const LaplaceProblem& problem) {
  problem.check();
  refuse_couplings(problem, "the relaxation");
  refuse_link_models(problem, "the relaxation");
  refuse_curves(problem, "the relaxation");
  const double h = std::max(problem.size.x, problem.size.y) / options_.sites;
  const int cells_x = whole_cells(problem.size.x, h), cells_y = whole_cells(problem.size.y, h);
  problem_ = problem;
  grounded_ = problem.has_ground();

  site_body_ = paint_bodies(problem, {{0, 0}, h, cells_x + 1, cells_y + 1});
  std::vector<int> sites(problem.bodies.size());
  for (int body : site_body_)
    if (body >= 0) ++sites[body];
  for (std::size_t b = 0; b < sites.size(); ++b)
    if (sites[b] == 0)
      throw InputError("body " + std::to_string(b) +
                       " covers no lattice site: it lies outside the box, inside another "
                       "body, or is smaller than the lattice spacing of " +
                       std::to_string(h) + " m");

  std::array<bool, 4> insulating;
  for (int side = 0; side < 4; ++side) insulating[side] = !is_electrode(problem.sides[side]);
  for (int j = 0; j <= cells_y; ++j)
    for (int i = 0; i <= cells_x; ++i) {
      const bool on_electrode = (i == 0 && !insulating[left]) || (i == cells_x && !insulating[right]) ||
                                (j == 0 && !insulating[bottom]) || (j == cells_y && !insulating[top]);
      int& site = site_body_[j * (cells_x + 1) + i];
      if (on_electrode && site == Lattice::fluid) site = electrode_site;
    }
  lattice_.reset(cells_x, cells_y, h, insulating, site_body_);

  const double offset = std::numbers::sqrt2 * h;
  contours_.clear();
  for (std::size_t b = 0; b < problem.bodies.size(); ++b)
    contours_.push_back(contour(problem, b, offset, options_.surface_points, h));
}

void RelaxationSolver::first_potentials() {
  // D 6.21. Groups may have merged or split since the last solve, but bodies keep their numbers: a group starts from
  // the mean of its members.
  body_potential_.resize(problem_.bodies.size(), 0.0);
  group_potential_.assign(problem_.groups.size(), 0.0);
  std::vector<int> members(problem_.groups.size());
  for (std::size_t b = 0; b < problem_.bodies.size(); ++b) {
    group_potential_[problem_.bodies[b].group] += body_potential_[b];
    ++members[problem_.bodies[b].group];
  }
  for (std::size_t g = 0; g < members.size(); ++g) {
    const Group& group = problem_.groups[g];
    group_potential_[g] = group.floating ? group_potential_[g] / members[g] : group.potential;
  }
  // A disk's capacitance in the plane is about ten eps, so this first step is below eta_c.
  eta_ = options_.eta > 0 ? options_.eta : 0.1 / problem_.permittivity;
  last_missing_.clear();
  error_history_.clear();
}

double RelaxationSolver::side_potential(int i, int j) const {
  const double h = lattice_.spacing();
  const Vec2 p = {i == lattice_.cells_x() ? problem_.size.x : i * h, j == lattice_.cells_y() ? problem_.size.y : j * h};
  const bool on[4] = {i == 0, i == lattice_.cells_x(), j == 0, j == lattice_.cells_y()};
  double sum = 0;
  int sides = 0;  // In a corner of two electrodes the mean is used: no relaxed site depends on it, only the
                  // interpolation
  for (int side = 0; side < 4; ++side)
    if (on[side] && is_electrode(problem_.sides[side])) {
      sum += problem_.sides[side].potential_at(p);
      ++sides;
    }
  return sum / sides;
}

/// Writes the present potentials to the sites of bodies and electrode sides.
void RelaxationSolver::set_fixed_sites() {
  const int nx = lattice_.cells_x() + 1;
  for (int j = 0; j <= lattice_.cells_y(); ++j)
    for (int i = 0; i < nx; ++i) {
      const int body = site_body_[j * nx + i];
      if (body >= 0) lattice_.at(i, j) = group_potential_[problem_.bodies[body].group];
      if (body == electrode_site) lattice_.at(i, j) = side_potential(i, j);
    }
}

/// Performs one potential solve and computes the resulting charges (D 6.5.1).
RelaxationSolver::Estimate RelaxationSolver::estimate() {
  set_fixed_sites();
  const int sites = options_.sites;
  lattice_.relax(static_cast<int>(std::ceil(options_.sweeps_factor * sweeps_per_decade(sites))),
                 over_relaxation(sites));

  Estimate result;
  result.group_charge.assign(problem_.groups.size(), 0.0);
  for (std::size_t b = 0; b < problem_.bodies.size(); ++b)
    result.group_charge[problem_.bodies[b].group] += body_charge(b);

  double largest = 0;
  for (std::size_t g = 0; g < problem_.groups.size(); ++g)
    largest = std::max({largest, std::abs(problem_.groups[g].charge), std::abs(result.group_charge[g])});
  for (int side = 0; side < 4; ++side)
    if (is_electrode(problem_.sides[side]))
      largest = std::max(largest, problem_.permittivity * std::abs(lattice_.flux_through(side)));
  if (largest == 0) return result;  // No charge and no potential difference anywhere

  result.leftover = problem_.permittivity * lattice_.leftover() / largest;
  for (double q : missing_charge(result.group_charge))
    result.charge_error = std::max(result.charge_error, std::abs(q) / largest);
  return result;
}

/// Returns q_i = Q_i - Q_i* of the floating groups, 0 for the others (D 6.31). Without ground the part common to all
/// groups is subtracted: a constant added to all potentials cannot change it, so it is an error of the integrals.
std::vector<double> RelaxationSolver::missing_charge(const std::vector<double>& group_charge) const {
  std::vector<double> missing(problem_.groups.size());
  for (std::size_t g = 0; g < missing.size(); ++g)
    if (problem_.groups[g].floating) missing[g] = problem_.groups[g].charge - group_charge[g];
  if (!grounded_ && !missing.empty()) {
    const double mean = std::accumulate(missing.begin(), missing.end(), 0.0) / missing.size();
    for (double& q : missing) q -= mean;
  }
  return missing;
}

/// Returns true if the charge left in the fluid is small compared to the charge error. Until then the charges do not
/// correspond to the potentials, and the lattice is relaxed further at the same potentials. The remaining charge
/// alternates in sign between sites, so that less than a tenth of the bound reaches the charges. Usually 4 n10 sweeps
/// from the last potentials suffice.
bool RelaxationSolver::is_relaxed(const Estimate& estimate) const {
  return estimate.leftover < std::max(10 * estimate.charge_error, options_.tolerance);
}

/// Performs a descent step phi_i += eta q_i (D 6.30). If eta is not given, it is half of eta_c (D 6.35), where the
/// error decreases most, for the q of the previous step. Its C q needs no capacitances: the step changed q by -eta C q
/// (D 6.32, sign corrected).
void RelaxationSolver::descend(const Estimate& estimate) {
  const std::vector<double> missing = missing_charge(estimate.group_charge);
  error_history_.push_back(0.5 * std::inner_product(missing.begin(), missing.end(), missing.begin(), 0.0));
  if (options_.eta == 0 && !last_missing_.empty()) {
    double q_dq = 0, dq_dq = 0;
    for (std::size_t g = 0; g < missing.size(); ++g) {
      const double dq = last_missing_[g] - missing[g];
      q_dq += last_missing_[g] * dq;
      dq_dq += dq * dq;
    }
    if (q_dq > 0) eta_ *= q_dq / dq_dq;
  }
  for (std::size_t g = 0; g < missing.size(); ++g) group_potential_[g] += eta_ * missing[g];
  if (!grounded_) subtract_mean();
  last_missing_ = missing;
}

void RelaxationSolver::subtract_mean() {
  double mean = 0;
  for (const Body& body : problem_.bodies) mean += group_potential_[body.group] / problem_.bodies.size();
  for (double& potential : group_potential_) potential -= mean;
}

/// Computes the charge (C/m) of a body, -eps times the contour integral of dV/dn (D 6.18; D 6.19 has a wrong square and
/// lacks eps).
double RelaxationSolver::body_charge(std::size_t body) const {
  double flux = 0;
  for (const ContourPoint& point : contours_[body]) flux += dot(lattice_.gradient(point.at), point.normal_ds);
  return -problem_.permittivity * flux;
}

/// Computes the force (N/m) on a body as a contour integral. The integrand is the full Maxwell stress, or the stress of
/// the normal field alone (D 6.17, which lacks the factor eps/2 and the normal).
Vec2 RelaxationSolver::body_force(std::size_t body) const {
  Vec2 force;
  for (const auto& [at, normal_ds] : contours_[body]) {
    const Vec2 gradient = lattice_.gradient(at);
    const double flux = dot(gradient, normal_ds);
    if (options_.stress == Stress::maxwell)
      force += flux * gradient - 0.5 * norm2(gradient) * normal_ds;
    else if (const double ds2 = norm2(normal_ds); ds2 > 0)
      force += 0.5 * flux * flux / ds2 * normal_ds;
  }
  return problem_.permittivity * force;
}

Field RelaxationSolver::field() const {
  if (lattice_.cells_x() < 0) throw Failure("relaxation: no field before the first solve");
  const int nx = lattice_.cells_x(), ny = lattice_.cells_y();
  const double h = lattice_.spacing();
  Field field{.nx = nx, .ny = ny, .h = h, .value = {}, .body = paint_bodies(problem_, {{0.5 * h, 0.5 * h}, h, nx, ny})};
  field.value.reserve(field.body.size());
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int body = field.body[j * nx + i];
      const double interpolated =
          0.25 * (lattice_.at(i, j) + lattice_.at(i + 1, j) + lattice_.at(i, j + 1) + lattice_.at(i + 1, j + 1));
      field.value.push_back(body < 0 ? interpolated : group_potential_[problem_.bodies[body].group]);
    }
  return field;
}

}  // namespace lichtenberg::laplace
