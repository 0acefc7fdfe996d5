#include "solvers/laplace/multipole/system.hpp"

#include <numbers>

namespace lichtenberg::laplace {

System::System(const LaplaceProblem& problem, const Arrangement& arrangement, const LatticeSum& lattice,
               const WallField& wall, FarField& far, const Mirrors& mirrors, double accuracy)
    : problem_(&problem),
      arrangement_(&arrangement),
      far_(&far),
      layout_(arrangement.disks),
      near_(arrangement.cells, arrangement.disks, static_cast<int>(arrangement.disks.size()), arrangement.decay,
            accuracy),
      wall_(layout_.size()) {
  const Cells& cells = arrangement.cells;
  const int terms = far.order() + 1;
  shifts_.resize(arrangement.disks.size() * terms);
  for (std::size_t i = 0; i < arrangement.disks.size(); ++i) {
    const Source& disk = arrangement.disks[i];
    const int cell = cells.cell_of(disk.centre);
    const Complex shift = (cells.centre(cell % cells.nx, cell / cells.nx) - disk.centre) / far.scale();
    Complex* power = &shifts_[i * terms];
    power[0] = 1;
    for (int j = 1; j < terms; ++j) power[j] = multiply(power[j - 1], shift) / static_cast<double>(j);
    if (mirrors.grounded()) wall.local(disk.centre, disk.radius, disk.order + 1, &wall_[layout_.start[i]]);
  }
  number_unknowns(mirrors);
  factorize(mirrors, lattice);
}

void System::number_unknowns(const Mirrors& mirrors) {
  const std::size_t disks = problem_->bodies.size();
  std::vector<int> members(problem_->groups.size());
  for (const Body& body : problem_->bodies) ++members[body.group];
  charge_unknown_.assign(disks, -1);
  potential_unknown_.assign(problem_->groups.size(), -1);
  given_.assign(disks, 0.0);
  multipole_unknowns_ = 2 * (layout_.size() - static_cast<int>(disks));
  int next = multipole_unknowns_;
  for (std::size_t i = 0; i < disks; ++i) {
    const Group& group = problem_->groups[group_of(i)];
    if (group.floating && members[group_of(i)] == 1)
      given_[i] = group.charge / (2 * std::numbers::pi * problem_->permittivity);
    else if (!arrangement_->anchored[i])
      charge_unknown_[i] = next++;
  }
  for (std::size_t g = 0; g < problem_->groups.size(); ++g)
    if (problem_->groups[g].floating && members[g] > 1) potential_unknown_[g] = next++;
  if (!mirrors.grounded() && problem_->has_ground()) level_ = next++;
  extra_unknowns_ = next - multipole_unknowns_;
}

/// The unknown charges, potentials and level among themselves: the matrix that would be all if the disks had no
/// multipoles.
void System::factorize(const Mirrors& mirrors, const LatticeSum& lattice) {
  if (extra_unknowns_ == 0) return;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(extra_unknowns_, extra_unknowns_);
  const auto& disks = arrangement_->disks;
  const int first = multipole_unknowns_;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    if (charge_unknown_[i] < 0) continue;
    const int row = charge_unknown_[i] - first;
    for (std::size_t j = 0; j <= i; ++j) {
      if (charge_unknown_[j] < 0) continue;
      double potential = 0;
      for (const Image& image : mirrors.images)
        potential -= image.sign * lattice.real_part(disks[i].centre - image.centre(disks[j].centre), disks[i].radius);
      const int column = charge_unknown_[j] - first;
      matrix(row, column) = matrix(column, row) = potential;
    }
    if (const int g = potential_unknown_[group_of(i)]; g >= 0) {
      matrix(row, g - first) = -1;
      matrix(g - first, row) = 1;
    }
    if (level_ >= 0) {
      matrix(row, level_ - first) = 1;
      matrix(level_ - first, row) = 1;
    }
  }
  extra_.compute(matrix);
}

void System::spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const {
  int next = 0;
  for (std::size_t i = 0; i < arrangement_->disks.size(); ++i) {
    Complex* a = &coefficients[layout_.start[i]];
    if (charge_unknown_[i] >= 0) a[0] = x[charge_unknown_[i]];
    for (int k = 1; k <= arrangement_->disks[i].order; ++k, next += 2) a[k] = {x[next], x[next + 1]};
  }
}

std::vector<Complex> System::coefficients(const Eigen::VectorXd& x) const {
  std::vector<Complex> all(layout_.size());
  for (std::size_t i = 0; i < given_.size(); ++i) all[layout_.start[i]] = given_[i];
  spread(x, all);
  return all;
}

/// The field at each disk of all others and of its own images, except those that coincide with it.
std::vector<Complex> System::local_field(const std::vector<Complex>& coefficients) const {
  const auto& disks = arrangement_->disks;
  const Cells& cells = arrangement_->cells;
  const int terms = far_->order() + 1;
  std::vector<Complex> scaled(terms), local(layout_.size());
  far_->clear_sources();
  for (std::size_t i = 0; i < disks.size(); ++i) {
    const Complex *a = &coefficients[layout_.start[i]], *shift = &shifts_[i * terms];
    Complex* alpha = far_->source(cells.cell_of(disks[i].centre));
    const int count = std::min(disks[i].order + 1, terms);
    scaled[0] = -a[0];
    double power = -1;  // (-1)^(k-1) (R/h)^k / (k-1)!
    for (int k = 1; k < count; ++k) {
      power *= -disks[i].radius / far_->scale() / std::max(1, k - 1);
      scaled[k] = power * a[k];
    }
    for (int l = 0; l < terms; ++l) {
      Complex sum = 0;
      for (int k = 0; k <= std::min(l, count - 1); ++k) sum += multiply(shift[l - k], scaled[k]);
      alpha[l] += sum;
    }
  }
  far_->apply();
  for (std::size_t i = 0; i < disks.size(); ++i) {
    const Complex* beta = far_->local(cells.cell_of(disks[i].centre));
    const Complex* shift = &shifts_[i * terms];
    Complex* b = &local[layout_.start[i]];
    const int count = std::min(disks[i].order + 1, terms);
    double power = 1;  // (R/h)^m / m!
    for (int m = 0; m < count; ++m) {
      Complex sum = 0;  // shift has the sign of the way to the cell's centre
      for (int l = m; l < terms; ++l) {
        const Complex term = multiply(beta[l], shift[l - m]);
        sum += (l - m) % 2 == 0 ? term : -term;
      }
      b[m] = power * sum;
      power *= disks[i].radius / far_->scale() / (m + 1);
    }
  }
  near_.add(layout_, coefficients.data(), local.data());
  return local;
}

/// Without the electrodes' field and the level.
double System::disk_potential(int disk, const std::vector<Complex>& coefficients,
                              const std::vector<Complex>& local) const {
  const int start = layout_.start[disk];
  return local[start].real() -
         arrangement_->copies[disk] * coefficients[start].real() * std::log(arrangement_->disks[disk].radius);
}

Eigen::VectorXd System::operator*(const Eigen::VectorXd& x) const {
  std::vector<Complex> a(layout_.size());
  spread(x, a);
  const std::vector<Complex> local = local_field(a);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const double share = 1.0 / arrangement_->copies[i];
    const int start = layout_.start[i];
    for (int k = start + 1; k < layout_.start[i + 1]; ++k, next += 2) {
      y[next] = x[next] + share * local[k].real();
      y[next + 1] = x[next + 1] - share * local[k].imag();
    }
    const int unknown = charge_unknown_[i], potential = potential_unknown_[group_of(i)];
    if (unknown < 0) continue;
    y[unknown] = disk_potential(i, a, local) + (level_ < 0 ? 0.0 : x[level_]);
    if (potential >= 0) {
      y[unknown] -= x[potential];
      y[potential] += x[unknown];
    }
    if (level_ >= 0) y[level_] += x[unknown];
  }
  return y;
}

Eigen::VectorXd System::right_hand_side() const {
  const std::vector<Complex> charges = coefficients(Eigen::VectorXd::Zero(size()));
  const std::vector<Complex> local = local_field(charges);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const double share = 1.0 / arrangement_->copies[i];
    const int start = layout_.start[i];
    for (int k = start + 1; k < layout_.start[i + 1]; ++k, next += 2) {
      y[next] = -share * (local[k] + wall_[k]).real();
      y[next + 1] = share * (local[k] + wall_[k]).imag();
    }
    if (level_ >= 0) y[level_] -= given_[i];
    if (charge_unknown_[i] < 0) continue;
    const Group& group = problem_->groups[group_of(i)];
    y[charge_unknown_[i]] = -disk_potential(i, charges, local) - wall_[start].real();
    if (group.floating)
      y[potential_unknown_[group_of(i)]] = group.charge / (2 * std::numbers::pi * problem_->permittivity);
    else
      y[charge_unknown_[i]] += group.potential;
  }
  return y;
}

Eigen::VectorXd System::precondition(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd z = residual;
  if (extra_unknowns_ > 0) z.tail(extra_unknowns_) = extra_.solve(residual.tail(extra_unknowns_));
  return z;
}

System::Potentials System::potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const {
  const std::vector<Complex> local = local_field(coefficients);
  Potentials potentials{std::vector<double>(problem_->groups.size()), level_ < 0 ? 0.0 : x[level_]};
  std::vector<double>& group = potentials.group;
  for (std::size_t g = 0; g < group.size(); ++g) {
    if (!problem_->groups[g].floating) group[g] = problem_->groups[g].potential;
    if (potential_unknown_[g] >= 0) group[g] = x[potential_unknown_[g]];
  }
  for (std::size_t i = 0; i < given_.size(); ++i)
    if (const int g = group_of(i); problem_->groups[g].floating && potential_unknown_[g] < 0)
      group[g] = disk_potential(i, coefficients, local) + wall_[layout_.start[i]].real() + potentials.level;
  if (problem_->has_ground()) return potentials;
  double mean = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) mean += group[group_of(i)] / static_cast<double>(given_.size());
  for (double& phi : group) phi -= mean;
  potentials.level = -mean;
  return potentials;
}

}  // namespace lichtenberg::laplace
