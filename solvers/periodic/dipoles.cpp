#include "solvers/periodic/dipoles.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/periodic/short_range.hpp"

namespace lichtenberg::periodic {
namespace {

using Vector = Eigen::VectorXd;
using View = Eigen::Map<const Vector>;

View view(std::span<const double> v) { return {v.data(), static_cast<Eigen::Index>(v.size())}; }

Vector applied(const DipoleField& field_of, const Vector& dipole) {
  Vector field(dipole.size());
  field_of({dipole.data(), static_cast<std::size_t>(dipole.size())},
           {field.data(), static_cast<std::size_t>(field.size())});
  return field;
}

[[noreturn]] void refuse(const DipoleField& field_of, std::size_t components, double polarizability) {
  throw InputError(
      fmt::format("at a polarizability of {:.6g} the mutual polarization of the dipoles at these positions diverges: "
                  "it must be below {:.6g}",
                  polarizability, largest_polarizability(field_of, static_cast<int>(components / 3))));
}

/// Returns the largest eigenvalue of the symmetric tridiagonal matrix of Lanczos' method so far.
double largest_ritz_value(const std::vector<double>& diagonal, const std::vector<double>& off_diagonal) {
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(view(diagonal), view(std::span(off_diagonal).first(diagonal.size() - 1)),
                                Eigen::EigenvaluesOnly);
  return solver.eigenvalues().maxCoeff();
}

Vector random_direction(Eigen::Index size) {
  std::mt19937 random(1);
  Vector v(size);
  for (double& x : v) x = static_cast<double>(random()) - 0x1p31;
  return v.normalized();
}

void add(Response& to, double factor, const Response& part) {
  for (std::size_t i = 0; i < to.potential.size(); ++i) to.potential[i] += factor * part.potential[i];
  for (std::size_t i = 0; i < to.field.size(); ++i) to.field[i] += factor * part.field[i];
  for (std::size_t i = 0; i < to.force.size(); ++i) to.force[i] += factor * part.force[i];
}

/// Evaluates sums for different charges and dipoles at the same positions.
struct DipoleSystem {
  const Sources& sources;
  std::span<const Pair> pairs;
  parallel::Team& team;

  Response response(Sum& sum, std::span<const double> charge, std::span<const double> dipole) const {
    Response result;
    sum.evaluate({sources.lengths, sources.position, charge, dipole}, pairs, team, result);
    return result;
  }
};

/// Replaces the interactions between dipoles by those of another sum; their potential at the charges stays.
void replace_between_dipoles(const DipoleSystem& at, Sum& before, Sum& after, std::span<const double> dipole,
                             Response& response) {
  const std::vector<double> none(at.sources.size());
  Response difference = at.response(after, none, dipole);
  add(difference, -1, at.response(before, none, dipole));
  difference.potential = none;
  add(response, 1, difference);
}

/// Returns -mu.e_charges - 1/2 mu T mu + mu^2 / (2 A), with T mu = total field - e_charges. `inducing`: dipoles at
/// equal polarizability A in the same field, mu / w^2.
double polarization_energy(const std::vector<double>& dipole, const std::vector<double>& inducing,
                           const std::vector<double>& charges, const std::vector<double>& total,
                           double polarizability) {
  return -0.5 * view(dipole).dot(view(charges) + view(total) - view(inducing) / polarizability);
}

/// Multiplies vectors by weights; without weights they stay.
void weigh(std::span<double> vectors, const std::vector<double>& weight) {
  for (std::size_t k = 0; k < weight.size(); ++k) vectors[k] *= weight[k];
}
void divide(std::span<double> vectors, const std::vector<double>& weight) {
  for (std::size_t k = 0; k < weight.size(); ++k) vectors[k] /= weight[k];
}

/// Returns the interaction w T w of weighted dipoles.
DipoleField weighted(DipoleField field_of, const std::vector<double>& weight) {
  if (weight.empty()) return field_of;
  return [field_of = std::move(field_of), &weight](std::span<const double> dipole, std::span<double> field) {
    std::vector<double> moments(dipole.begin(), dipole.end());
    weigh(moments, weight);
    field_of(moments, field);
    weigh(field, weight);
  };
}

/// Returns B_1, ..., B_n. C(2n, n - j) / C(2n - 2, n - 1) is (4n - 2) / (n + 1) at j = 1, and its ratio from j to j + 1
/// is (n - j) / (n + 1 + j).
std::vector<double> predictor_weights(int n) {
  std::vector<double> weight;
  double ratio = (4.0 * n - 2) / (n + 1);
  for (int j = 1; j <= n; ++j) {
    weight.push_back((j % 2 == 1 ? j : -j) * ratio);
    ratio *= static_cast<double>(n - j) / (n + 1 + j);
  }
  return weight;
}

}  // namespace

DipoleField field_by(Sum& sum, const Sources& sources, std::span<const Pair> pairs, parallel::Team& team) {
  return [&sum, sources, pairs, &team](std::span<const double> dipole, std::span<double> field) {
    sum.dipole_field({sources.lengths, sources.position, sources.charge, dipole}, pairs, team, field);
  };
}

// Conjugate gradients with the matrix M = 1/A - T, which is positive definite as long as the dipoles have a stable
// state. A direction p with p.Mp <= 0 proves that it is not.
int solve_dipoles(const DipoleField& field_of, std::span<const double> field, double polarizability, double tolerance,
                  std::span<double> dipole) {
  if (!(polarizability >= 0))
    throw InputError(fmt::format("a polarizability is {}: it must not be negative", polarizability));
  Eigen::Map<Vector> mu(dipole.data(), static_cast<Eigen::Index>(dipole.size()));
  const double goal = tolerance * view(field).norm();
  if (polarizability == 0 || goal == 0) mu.setZero();
  if (polarizability == 0 || goal == 0) return 0;

  int applications = 0;
  Vector residual = view(field);
  if (!mu.isZero(0)) residual += applied(field_of, mu) - mu / polarizability, ++applications;
  Vector direction = residual;
  double square = residual.squaredNorm();
  const int most = 3 * static_cast<int>(dipole.size()) + 30;
  while (!(std::sqrt(square) <= goal)) {
    if (applications++ == most)
      throw Failure(
          fmt::format("induced dipoles: the residual field is {:.3g} after {} steps, where {:.3g} is required",
                      std::sqrt(square), most, goal));
    const Vector product = direction / polarizability - applied(field_of, direction);
    const double curvature = direction.dot(product);
    if (!(curvature > 0)) refuse(field_of, dipole.size(), polarizability);
    const double step = square / curvature;
    mu += step * direction;
    residual -= step * product;
    const double before = square;
    square = residual.squaredNorm();
    direction = residual + square / before * direction;
  }
  return applications;
}

// Lanczos' method with full reorthogonalization, until the largest eigenvalue converges.
double largest_polarizability(const DipoleField& field_of, int n, double enough) {
  std::vector<Vector> basis = {random_direction(3 * n)};
  std::vector<double> diagonal, off_diagonal;
  double largest = 0;
  for (int step = 0; step < std::min(3 * n, 200); ++step) {
    Vector next = applied(field_of, basis.back());
    diagonal.push_back(next.dot(basis.back()));
    for (const Vector& v : basis) next -= next.dot(v) * v;
    const double before = largest;
    largest = largest_ritz_value(diagonal, off_diagonal);
    if (largest * enough >= 1) break;
    off_diagonal.push_back(next.norm());
    if (off_diagonal.back() <= 1e-14 * std::abs(largest) || (step > 5 && std::abs(largest - before) <= 1e-9 * largest))
      break;
    basis.push_back(next / off_diagonal.back());
  }
  return largest > 0 ? 1 / largest : INFINITY;
}

InducedDipoles::InducedDipoles(Sum& far, DipoleSum variant, double polarizability, double tolerance,
                               const std::vector<double>& each)
    : far_(far), variant_(variant), polarizability_(polarizability), tolerance_(tolerance) {
  for (const double a : each) weight_.insert(weight_.end(), 3, std::sqrt(a / polarizability));
}

int InducedDipoles::evaluate(const Sources& charges, std::span<const Pair> pairs, parallel::Team& team,
                             std::vector<double>& dipole, Response& response) const {
  require_consistent(charges);
  MinimumImage near;
  const bool far_with_charges = variant_ == DipoleSum::ewald || variant_ == DipoleSum::mixed_consistent;
  Sum& with_charges = far_with_charges ? far_ : near;
  Sum& between = variant_ == DipoleSum::ewald ? far_ : near;
  const DipoleSystem at{charges, pairs, team};

  response = at.response(far_, charges.charge, {});
  const Response alone = far_with_charges ? response : at.response(near, charges.charge, {});
  const std::vector<double> polarizing = variant_ == DipoleSum::minimum_image ? alone.field : response.field;
  dipole.resize(3 * charges.size());
  std::vector<double> driving = polarizing;
  weigh(driving, weight_), divide(dipole, weight_);
  const int applications = solve_dipoles(weighted(field_by(between, charges, pairs, team), weight_), driving,
                                         polarizability_, tolerance_, dipole);
  weigh(dipole, weight_);

  Response polarized = at.response(with_charges, charges.charge, dipole);
  add(polarized, -1, alone);
  if (&with_charges != &between) replace_between_dipoles(at, with_charges, between, dipole, polarized);
  response.field = polarizing;
  add(response, 1, polarized);
  std::vector<double> inducing = dipole;
  divide(inducing, weight_), divide(inducing, weight_);
  if (polarizability_ > 0)
    response.energy += polarization_energy(dipole, inducing, polarizing, response.field, polarizability_);
  return applications;
}

void InducedDipoles::check_stability(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team) const {
  MinimumImage near;
  const DipoleField field_of =
      weighted(field_by(variant_ == DipoleSum::ewald ? far_ : near, sources, pairs, team), weight_);
  const int n = static_cast<int>(sources.size());
  if (largest_polarizability(field_of, n, polarizability_) <= polarizability_)
    refuse(field_of, 3 * sources.size(), polarizability_);
}

std::vector<double> DipolePredictor::predict() const {
  if (history_.empty()) return {};
  std::vector<double> result(history_.front().size());
  const std::vector<double> weight = predictor_weights(static_cast<int>(history_.size()));
  for (std::size_t j = 0; j < history_.size(); ++j)
    for (std::size_t k = 0; k < result.size(); ++k) result[k] += weight[j] * history_[j][k];
  return result;
}

void DipolePredictor::replace(std::vector<double> dipole) {
  if (!history_.empty()) history_.erase(history_.begin());
  keep(std::move(dipole));
}

void DipolePredictor::keep(std::vector<double> dipole) {
  history_.insert(history_.begin(), std::move(dipole));
  if (history_.size() > steps_) history_.pop_back();
}

}  // namespace lichtenberg::periodic
