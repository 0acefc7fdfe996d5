#include "solvers/laplace/spheres/charges_and_dipoles.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::laplace::spheres {
namespace {

/// Index of each axis among harmonics of degree one.
constexpr std::array<int, 3> axis_at{at(1, 1), at(1, -1), at(1, 0)};

/// Numbers of spheres up to which dipoles, or charges alone, are included. The factorization takes (4 N)^3 / 3 products
/// with dipoles and N^3 / 3 without.
constexpr std::size_t few_spheres = 500, most_spheres = 2000;

/// Returns the matrix that shifts a sphere's charge and dipole to its cell's centre; by reciprocity its transpose
/// shifts local coefficients to the sphere. The factor R of both is omitted.
Eigen::MatrixXd to_cell(const Site& site, Vec3 centre, int degree, double unit) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Identity(harmonics(degree), harmonics(degree));
  const Vec3 displacement = site.centre - centre;
  for (int k = 0; k < 3 && degree > 0; ++k) {
    result(axis_at[k], 0) = displacement[k] / unit;
    result(axis_at[k], axis_at[k]) = site.radius / unit;
  }
  return result;
}

/// Returns the lower half of the inverse of L L', by blocks of columns. Rows above a block do not affect it.
Eigen::MatrixXd lower_half_of_inverse(const Eigen::MatrixXd& lower, parallel::Team& team) {
  constexpr Eigen::Index block = 64;
  const Eigen::Index size = lower.rows();
  Eigen::MatrixXd inverse(size, size);
  team.for_each(static_cast<int>((size + block - 1) / block), [&](int part) {
    const Eigen::Index first = part * block, left = size - first;
    const auto corner = lower.bottomRightCorner(left, left);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(left, std::min(block, left));
    corner.triangularView<Eigen::Lower>().solveInPlace(columns);
    corner.triangularView<Eigen::Lower>().adjoint().solveInPlace(columns);
    inverse.block(first, first, left, columns.cols()) = columns;
  });
  return inverse;
}

}  // namespace

bool ChargesAndDipoles::saves_time(std::size_t spheres) { return spheres <= most_spheres; }

ChargesAndDipoles::ChargesAndDipoles(const Mirrors& mirrors, const Cells& cells, const std::vector<Site>& sites,
                                     const std::vector<NearPair>& pairs, parallel::Team& team)
    : degree_(sites.size() <= few_spheres ? 1 : 0), sites_(sites) {
  const auto count = static_cast<Eigen::Index>(sites.size()), size = count * unknowns_per_sphere();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
  add_near(pairs, matrix);
  add_far(mirrors, cells, team, matrix);
  const Eigen::LLT<Eigen::MatrixXd> factors(matrix);
  positive_ = factors.info() == Eigen::Success;
  if (!positive_) return;
  const Eigen::MatrixXd inverse = lower_half_of_inverse(factors.matrixLLT(), team);
  inverse_ = inverse.cast<float>().selfadjointView<Eigen::Lower>();
  charge_response_.resize(size, count);
  charges_.resize(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    charge_response_.col(i) = inverse_.col(i * unknowns_per_sphere());
    for (Eigen::Index k = 0; k < count; ++k)
      charges_(k, i) = inverse(std::max(i, k) * unknowns_per_sphere(), std::min(i, k) * unknowns_per_sphere());
  }
}

Eigen::VectorXf ChargesAndDipoles::solve(const Eigen::VectorXf& values, parallel::Team& team) const {
  constexpr Eigen::Index block = 64;
  Eigen::VectorXf x(values.size());
  team.for_each(static_cast<int>((values.size() + block - 1) / block), [&](int part) {
    const Eigen::Index first = part * block, size = std::min(block, values.size() - first);
    x.segment(first, size).noalias() = inverse_.middleCols(first, size).transpose() * values;
  });
  return x;
}

void ChargesAndDipoles::add_near(const std::vector<NearPair>& pairs, Eigen::MatrixXd& matrix) const {
  const Coupling coupling(2 * degree_);
  const int n = unknowns_per_sphere();
  std::array<double, harmonics(2)> derivatives;
  std::array<double, harmonics(1)> unit, field;
  for (const NearPair& pair : pairs) {
    const Site &target = sites_[pair.target], &source = sites_[pair.source];
    irregular_harmonics(pair.displacement, 2 * degree_, derivatives.data());
    const double scale = std::sqrt(target.radius / source.radius);
    for (int h = 0; h < n; ++h) {
      unit.fill(0), field.fill(0);
      unit[h] = 1;
      coupling.add(derivatives.data(), {degree_, source.radius, pair.mask, pair.sign}, unit.data(),
                   {degree_, target.radius}, field.data());
      for (int k = 0; k < n; ++k) matrix(pair.target * n + k, pair.source * n + h) += scale * field[k];
    }
  }
}

void ChargesAndDipoles::add_far(const Mirrors& mirrors, const Cells& cells, parallel::Team& team,
                                Eigen::MatrixXd& matrix) const {
  const CellConvolution convolution(mirrors, cells, 2 * degree_);
  const int n = unknowns_per_sphere(), all = harmonics(2 * degree_), cell_count = cells.cells();
  std::vector<Eigen::MatrixXd> moved;
  std::vector<int> cell;
  for (const Site& site : sites_) {
    const auto indices = cells.indices(site.centre);
    cell.push_back(cells.number(indices));
    moved.push_back(to_cell(site, cells.centre(indices), degree_, convolution.unit()));
  }
  std::vector<double> multipoles(static_cast<std::size_t>(all) * cell_count), local(multipoles.size());
  Eigen::MatrixXd field(n * cell_count, n);  // Field of unit multipoles of one cell
  for (int c = 0; c < cell_count; ++c) {
    if (cells.members[c].empty()) continue;
    for (int h = 0; h < n; ++h) {
      double& source = multipoles[static_cast<std::size_t>(h) * cell_count + c];
      source = 1;
      convolution.apply(multipoles, local, team);
      source = 0;
      for (int k = 0; k < n; ++k)
        for (int to = 0; to < cell_count; ++to)
          field(to * n + k, h) = local[static_cast<std::size_t>(k) * cell_count + to];
    }
    for (const int s : cells.members[c])
      for (std::size_t t = 0; t < sites_.size(); ++t)
        matrix.block(static_cast<Eigen::Index>(t) * n, static_cast<Eigen::Index>(s) * n, n, n) +=
            std::sqrt(sites_[t].radius * sites_[s].radius) / convolution.unit() *
            (moved[t].transpose() * field.middleRows(cell[t] * n, n) * moved[s]);
  }
}

bool ChargesAndDipoles::is_usable_for(const std::vector<Site>& sites) const {
  if (sites.size() != sites_.size()) return false;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const double radius = sites_[i].radius;
    if (sites[i].radius != radius || norm2(sites[i].centre - sites_[i].centre) > radius * radius) return false;
  }
  return true;
}

ConstrainedCharges::ConstrainedCharges(std::shared_ptr<const ChargesAndDipoles> equations,
                                       const std::vector<Site>& sites, const std::vector<ChargeConstraint>& constraints)
    : equations_(std::move(equations)), constraint_(sites.size(), -1) {
  for (const Site& site : sites) share_.push_back(std::sqrt(site.radius));
  for (std::size_t g = 0; g < constraints.size(); ++g)
    for (const int i : constraints[g].spheres) constraint_[i] = static_cast<int>(g);
  const auto groups = static_cast<Eigen::Index>(constraints.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(groups, groups);
  for (std::size_t i = 0; i < sites.size(); ++i)
    for (std::size_t k = 0; k < sites.size() && constraint_[i] >= 0; ++k)
      if (constraint_[k] >= 0)
        matrix(constraint_[k], constraint_[i]) +=
            share_[k] * equations_->charges()(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) * share_[i];
  factors_.compute(matrix);
}

void ConstrainedCharges::apply(const std::vector<int>& start, double* values, parallel::Team& team) const {
  const int n = equations_->unknowns_per_sphere();
  const auto count = static_cast<Eigen::Index>(constraint_.size());
  Eigen::VectorXf x(count * n), charge_shift(count);
  for (Eigen::Index i = 0; i < count; ++i)
    x.segment(i * n, n) = Eigen::Map<Eigen::VectorXd>(values + start[i], n).cast<float>();
  x = equations_->solve(x, team);
  if (factors_.cols() > 0) {
    Eigen::VectorXd potential = Eigen::VectorXd::Zero(factors_.cols());
    for (Eigen::Index i = 0; i < count; ++i)
      if (constraint_[i] >= 0) potential[constraint_[i]] += share_[i] * x[i * n];
    factors_.solveInPlace(potential);
    for (Eigen::Index i = 0; i < count; ++i)
      charge_shift[i] = constraint_[i] >= 0 ? static_cast<float>(share_[i] * potential[constraint_[i]]) : 0;
    x -= equations_->solve_charges(charge_shift);
  }
  for (Eigen::Index i = 0; i < count; ++i)
    Eigen::Map<Eigen::VectorXd>(values + start[i], n) = x.segment(i * n, n).cast<double>();
}

}  // namespace lichtenberg::laplace::spheres
