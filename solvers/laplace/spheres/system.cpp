#include "solvers/laplace/spheres/system.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/laplace/spheres/results.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

/// Returns true if the interactions of the spheres are the same for any charges and potentials.
bool same_geometry(const SphereProblem& a, const SphereProblem& b) {
  const auto same_sphere = [](const Sphere& one, const Sphere& other) {
    return one.centre == other.centre && one.radius == other.radius && one.group == other.group &&
           one.relative_permittivity == other.relative_permittivity;
  };
  return a.free_space == b.free_space && a.box.lengths == b.box.lengths && a.box.sides == b.box.sides &&
         std::ranges::equal(a.spheres, b.spheres, same_sphere);
}

}  // namespace

System::System(const SphereProblem& problem, const SphereOptions& options, parallel::Team& team, const System* past,
               double share)
    : problem_(problem),
      mirrors_(problem),
      wall_(problem),
      fields_(past && same_geometry(past->problem_, problem) && past->fields_->accuracy() <= share * options.accuracy
                  ? past->fields_
                  : std::make_shared<const Fields>(problem, mirrors_, options, share,
                                                   past ? past->fields_.get() : nullptr, team)),
      sites_(fields_->sites()),
      start_(starts(sites_)),
      team_(&team),
      constraints_(problem_, start_, first_coupling()) {
  stop_if_requested();
  const bool conductors = std::ranges::all_of(problem.spheres, &Sphere::is_conductor);
  if (!conductors || constraints_.coupling_count() > 0) return;  // The coarse equations exclude dielectrics, couplings
  charges_and_dipoles_ = fields_->charges_and_dipoles(past ? past->charges_and_dipoles_ : nullptr, team);
  if (charges_and_dipoles_) coarse_.emplace(charges_and_dipoles_, sites_, constraints_.on_spheres({}));
}

double System::scale(std::size_t sphere, int l) const {
  const Sphere& one = problem_.spheres[sphere];
  if (one.is_conductor() || l == 0) return 1 / std::sqrt(one.radius);
  const double k = one.relative_permittivity;
  return std::sqrt((k - 1) * l / (((k + 1) * l + 1) * one.radius));
}

template <class T>
void System::apply(const T* x, T* y) const {
  const std::vector<T> a = multipoles(x);
  std::vector<T> local(harmonics_size());
  fields_->add(a.data(), local.data(), *team_);
  for (std::size_t i = 0; i < sites_.size(); ++i)
    for (int l = 0, k = start_[i]; l <= sites_[i].degree; ++l)
      for (const double factor = sites_[i].radius * scale(i, l); k < start_[i] + harmonics(l); ++k)
        y[k] = x[k] + factor * local[k];
  add_close_pairs(x, a.data(), y);
  std::copy(x + first_coupling(), x + size(), y + first_coupling());
}

template void System::apply(const double*, double*) const;
template void System::apply(const Lanes*, Lanes*) const;

/// Adds the corrections of close pairs: their action on the harmonics of their own and nearby spheres, the reaction,
/// and their action on each other.
template <class T>
void System::add_close_pairs(const T* x, const T* multipoles, T* y) const {
  for (std::size_t p = 0; p < fields_->close_pairs().size(); ++p) {
    const ClosePair& pair = fields_->close_pairs()[p];
    const T c = amplitude(x, p);
    T reaction{};
    const auto act = [&](int sphere, const std::vector<double>& potential) {
      const T* a = multipoles + start_[sphere];
      T* to = y + start_[sphere];
      for (std::size_t k = 0; k < potential.size(); ++k) {
        reaction += sites_[sphere].radius * potential[k] * a[k];
        to[k] += std::sqrt(sites_[sphere].radius) * c * potential[k];
      }
    };
    for (const PairCorrection& correction : pair.corrections) act(correction.sphere, correction.potential);
    for (const ClosePair::OtherSphere& other : pair.other_spheres) act(other.sphere, other.potential);
    for (const ClosePair::CorrectionInteraction& other : pair.interactions)
      reaction += other.energy * amplitude(x, other.pair);
    y[harmonics_size() + p] = x[harmonics_size() + p] + reaction / std::sqrt(pair.energy);
  }
}

void System::precondition(double* x) const {
  if (coarse_) coarse_->apply(start_, x, *team_);
  project(x);
}

std::vector<double> System::wall_at_sites() const {
  std::vector<double> wall;
  for (const Site& site : sites_) wall.push_back(wall_.at(site.centre));
  return wall;
}

SolveTarget System::target(const std::vector<ChargeConstraint>& constraints) const {
  SolveTarget target{.sites = sites_, .constraints = constraints, .group = {}, .fixed = {}, .wall = wall_at_sites()};
  for (const Sphere& sphere : problem_.spheres) {
    const Group& group = problem_.groups[sphere.group];
    target.group.push_back(sphere.group);
    target.fixed.push_back(group.floating ? NAN : group.potential);
  }
  return target;
}

PastSolution System::past(const std::vector<double>& x, const std::vector<double>& group_potential) const {
  PastSolution past{
      sites_, {x.begin(), x.begin() + harmonics_size()}, {}, wall_at_sites(), constraints_.differences(x.data())};
  for (const Sphere& sphere : problem_.spheres) past.potential.push_back(group_potential[sphere.group]);
  return past;
}

std::vector<double> System::start(const History& history, double noise) const {
  std::vector<double> x(size()), difference(constraints_.coupling_count());
  const auto knows_couplings = [&](const PastSolution& past) { return past.difference.size() == difference.size(); };
  std::vector<double> share;
  if (!history.empty()) {
    const bool known = knows_couplings(history.front());
    share = history_coefficients(
        history, target(constraints_.on_spheres(known ? history.front().difference : difference)), noise);
  }
  for (std::size_t k = 0; k < share.size(); ++k) {
    const PastSolution& past = history[k];
    const std::vector<int> past_start = starts(past.sites);
    for (std::size_t i = 0; i < sites_.size(); ++i)
      for (int h = 0; h < harmonics(std::min(past.sites[i].degree, sites_[i].degree)); ++h)
        x[start_[i] + h] += share[k] * past.x[past_start[i] + h];
    if (knows_couplings(past))
      for (std::size_t c = 0; c < difference.size(); ++c) difference[c] += share[k] * past.difference[c];
  }
  constraints_.set_differences(difference, x.data());
  project(x.data());
  constraints_.add(x.data());
  return x;
}

std::vector<double> System::right_hand_side() const {
  std::vector<double> f(size());
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const Group& group = problem_.groups[problem_.spheres[i].group];
    const double root = std::sqrt(sites_[i].radius), slope = sites_[i].radius * sites_[i].radius * scale(i, 1);
    f[start_[i]] = root * ((group.floating ? 0 : group.potential) - wall_.at(sites_[i].centre));
    f[start_[i] + at(1, 1)] = -slope * wall_.slope.x;
    f[start_[i] + at(1, -1)] = -slope * wall_.slope.y;
    f[start_[i] + at(1, 0)] = -slope * wall_.slope.z;
  }
  constraints_.add_fixed_potentials(f.data());
  return f;
}

template <class T>
std::vector<T> System::multipoles(const T* x) const {
  std::vector<T> result(harmonics_size());
  for (std::size_t i = 0; i < sites_.size(); ++i)
    for (int l = 0, k = start_[i]; l <= sites_[i].degree; ++l)
      for (const double factor = scale(i, l); k < start_[i] + harmonics(l); ++k) result[k] = factor * x[k];
  return result;
}

template std::vector<double> System::multipoles(const double*) const;

std::vector<double> System::unit_potential(int group) const {
  std::vector<double> f(size());
  for (std::size_t i = 0; i < sites_.size(); ++i)
    if (problem_.spheres[i].group == group) f[start_[i]] = std::sqrt(sites_[i].radius);
  return f;
}

std::vector<double> System::group_charges(const double* x) const {
  std::vector<double> charge(problem_.groups.size());
  for (std::size_t i = 0; i < sites_.size(); ++i)
    charge[problem_.spheres[i].group] += std::sqrt(sites_[i].radius) * x[start_[i]];
  return charge;
}

void System::add_correction_forces(const double* x, const double* multipoles, SphereSolution& solution) const {
  const double scale = 4 * std::numbers::pi * problem_.permittivity;
  std::vector<std::vector<std::pair<const PairCorrection*, double>>> before(
      sites_.size());  // Corrections with amplitudes
  for (std::size_t p = 0; p < fields_->close_pairs().size(); ++p)
    for (const PairCorrection& correction : fields_->close_pairs()[p].corrections) {
      const int degree = sites_[correction.sphere].degree;
      const double c = amplitude(x, p);
      Vec3 force = correction_force(correction, c, degree, multipoles + start_[correction.sphere]);
      for (const auto& [other, amplitude] : before[correction.sphere])
        force += force_between(correction, *other, degree) * (c * amplitude);
      before[correction.sphere].push_back({&correction, c});
      solution.sphere_force[correction.sphere] += force * scale;
    }
}

/// Returns the response -b, including the sides' field. Degrees chosen for the accuracy suffice for forces; a given
/// degree needs the field one degree beyond.
ResponseMultipoles System::response(const std::vector<double>& x, const std::vector<double>& multipoles,
                                    const std::vector<double>& missed) const {
  ResponseMultipoles response;
  if (fields_->has_fixed_degree()) {
    response = {1, fields_->one_degree_beyond(multipoles.data(), *team_)};
    for (double& value : response.values) value = -value;
  } else {
    response.values.resize(harmonics_size());
  }
  const std::vector<int> start = starts(sites_, response.extra_degrees);
  for (std::size_t i = 0; i < sites_.size(); ++i)
    for (int l = 0, k = 0; l <= sites_[i].degree; ++l)
      for (const double factor = sites_[i].radius * scale(i, l); k < harmonics(l); ++k)
        response.values[start[i] + k] = (x[start_[i] + k] - missed[start_[i] + k]) / factor;
  return response;
}

void System::add_reflected_forces(const double* multipoles, SphereSolution& solution) const {
  const double scale = 4 * std::numbers::pi * problem_.permittivity;
  for (const Reflection& reflection : fields_->reflections())
    solution.sphere_force[reflection.large] += force_on_large(reflection, sites_, start_, multipoles) * scale;
}

SphereSolution System::results(const std::vector<double>& x, const std::vector<double>& product) const {
  SphereSolution solution;
  std::vector<double> missed = right_hand_side();
  for (int k = 0; k < size(); ++k) missed[k] = product[k] - missed[k];
  solution.group_potential = constraints_.potentials(missed.data());
  solution.coupling_charge = constraints_.carried(x.data());
  const double neutralized = problem_.neutralized_charge();
  if (!problem_.has_ground() && neutralized == 0) {
    double mean = 0;
    for (const Sphere& sphere : problem_.spheres) mean += solution.group_potential[sphere.group] / sites_.size();
    for (double& value : solution.group_potential) value -= mean;
  }
  const std::vector<double> a = multipoles(x.data());
  add_charges_and_forces(problem_, sites_, a, response(x, a, missed), wall_, solution);
  add_correction_forces(x.data(), a.data(), solution);
  add_reflected_forces(a.data(), solution);
  // The field of the background increases linearly with the position, and the sum over multipoles omits the part whose
  // divergence is not 0: -charge / (3 eps V) times the position.
  const Vec3 lengths = problem_.box.lengths;
  for (std::size_t i = 0; i < sites_.size() && neutralized != 0; ++i)
    solution.sphere_force[i] -=
        neutralized / (3 * problem_.permittivity * lengths.x * lengths.y * lengths.z) * solution.sphere_dipole[i];
  return solution;
}

}  // namespace lichtenberg::laplace::spheres
