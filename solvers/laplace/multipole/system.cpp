#include "solvers/laplace/multipole/system.hpp"

#include <numbers>

namespace lichtenberg::laplace {

namespace {

/// Beyond this many unknown charges, potentials and close pairs a dense factorization costs more than the iterations
/// that it saves (measured at 1000: 25 against 121).
constexpr int most_factorized = 4000;

}  // namespace

System::System(const LaplaceProblem& problem, const Arrangement& arrangement, const LatticeSum& lattice,
               const WallField& wall, FarField& far, const Mirrors& mirrors, double accuracy)
    : problem_(&problem),
      arrangement_(&arrangement),
      far_(&far),
      layout_(arrangement.sources),
      near_(arrangement, accuracy),
      wall_(layout_.size()) {
  const Cells& cells = arrangement.cells;
  const int terms = far.order() + 1;
  shifts_.resize(arrangement.sources.size() * terms);
  for (std::size_t s = 0; s < arrangement.sources.size(); ++s) {
    const Source& source = arrangement.sources[s];
    const int cell = cells.cell_of(source.centre);
    const Complex shift = (cells.centre(cell % cells.nx, cell / cells.nx) - source.centre) / far.scale();
    Complex* power = &shifts_[s * terms];
    power[0] = 1;
    for (int j = 1; j < terms; ++j) power[j] = multiply(power[j - 1], shift) / static_cast<double>(j);
  }
  for (int i = 0; i < arrangement.disks && mirrors.grounded(); ++i)
    wall.local(arrangement.sources[i].centre, arrangement.sources[i].radius, arrangement.sources[i].order + 1,
               &wall_[layout_.start[i]]);
  number_unknowns(mirrors);
  factorize(mirrors, lattice);
}

void System::number_unknowns(const Mirrors& mirrors) {
  const int disks = arrangement_->disks;
  std::vector<int> members(problem_->groups.size());
  for (const Body& body : problem_->bodies) ++members[body.group];
  charge_unknown_.assign(disks, -1);
  potential_unknown_.assign(problem_->groups.size(), -1);
  given_.assign(disks, 0.0);
  int next = 0;
  for (int i = 0; i < disks; ++i) next += 2 * arrangement_->sources[i].order;
  multipole_unknowns_ = next;
  for (int i = 0; i < disks; ++i) {
    const Group& group = problem_->groups[group_of(i)];
    if (group.floating && members[group_of(i)] == 1)
      given_[i] = group.charge / (2 * std::numbers::pi * problem_->permittivity);
    else if (!arrangement_->anchored[i])
      charge_unknown_[i] = next++;
  }
  for (std::size_t g = 0; g < problem_->groups.size(); ++g)
    if (problem_->groups[g].floating && members[g] > 1) potential_unknown_[g] = next++;
  if (!mirrors.grounded() && problem_->has_ground()) level_ = next++;
  for (std::size_t p = 0; p < arrangement_->close_pairs.size(); ++p) pair_unknown_.push_back(next++);
  extra_unknowns_ = next - multipole_unknowns_;
}

/// The unknowns other than multipoles among themselves: the matrix that would be all if the disks had no multipoles.
void System::factorize(const Mirrors& mirrors, const LatticeSum& lattice) {
  if (extra_unknowns_ == 0 || extra_unknowns_ > most_factorized) return;
  // Sources that an unknown charges, and their mean potentials on the disks that have an equation.
  std::vector<int> charged, needed;
  std::vector<bool> involved(arrangement_->sources.size(), false);
  for (int i = 0; i < arrangement_->disks; ++i) involved[i] = charge_unknown_[i] >= 0;
  for (const ClosePair& pair : arrangement_->close_pairs)
    for (const int s : {pair.first, pair.second, pair.first_charge, pair.second_charge})
      if (s >= 0) involved[s] = true;
  for (std::size_t s = 0; s < involved.size(); ++s)
    if (involved[s]) {
      charged.push_back(static_cast<int>(s));
      if (s < given_.size()) needed.push_back(static_cast<int>(s));
    }
  Eigen::MatrixXd potential(needed.size(), charged.size());
  for (std::size_t row = 0; row < needed.size(); ++row)
    for (std::size_t column = 0; column < charged.size(); ++column) {
      // Disks come first in both lists, and act on each other symmetrically.
      if (column < row) {
        potential(row, column) = potential(column, row);
        continue;
      }
      const Source &disk = arrangement_->sources[needed[row]], &source = arrangement_->sources[charged[column]];
      double sum = 0;
      for (const Image& image : mirrors.images)
        sum -= image.sign * lattice.real_part(disk.centre - image.centre(source.centre), disk.radius);
      potential(row, column) = sum;
    }

  Eigen::MatrixXd matrix(extra_unknowns_, extra_unknowns_);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size()), y = x, value(needed.size());
  std::vector<double> mean(given_.size());
  std::vector<Complex> coefficients(layout_.size());
  for (int u = 0; u < extra_unknowns_; ++u) {
    x[multipole_unknowns_ + u] = 1;
    std::fill(coefficients.begin(), coefficients.end(), Complex{0});
    spread(x, coefficients);
    value.setZero();
    for (std::size_t s = 0; s < charged.size(); ++s)
      if (const double lambda = coefficients[layout_.start[charged[s]]].real(); lambda != 0)
        value += lambda * potential.col(s);
    for (std::size_t row = 0; row < needed.size(); ++row) mean[needed[row]] = value[row];
    y.tail(extra_unknowns_).setZero();
    balance(x, mean, y);
    matrix.col(u) = y.tail(extra_unknowns_);
    x[multipole_unknowns_ + u] = 0;
  }
  extra_.compute(matrix);
}

/// Adds what the unknowns make of the coefficients. Point charges come out of the disk that they are in, unless its
/// charge is unknown anyway.
void System::spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const {
  int next = 0;
  for (int i = 0; i < arrangement_->disks; ++i) {
    Complex* a = &coefficients[layout_.start[i]];
    if (charge_unknown_[i] >= 0) a[0] += x[charge_unknown_[i]];
    for (int k = 1; k <= arrangement_->sources[i].order; ++k, next += 2) a[k] = {x[next], x[next + 1]};
  }
  for (std::size_t p = 0; p < pair_unknown_.size(); ++p) {
    const ClosePair& pair = arrangement_->close_pairs[p];
    const auto charge = [&](int disk, int point, double lambda) {
      if (point < 0) return;
      coefficients[layout_.start[point]] += lambda;
      if (charge_unknown_[disk] < 0 && !arrangement_->anchored[disk]) coefficients[layout_.start[disk]] -= lambda;
    };
    charge(pair.first, pair.first_charge, x[pair_unknown_[p]]);
    charge(pair.second, pair.second_charge, -x[pair_unknown_[p]]);
  }
}

std::vector<Complex> System::coefficients(const Eigen::VectorXd& x) const {
  std::vector<Complex> all(layout_.size());
  for (std::size_t i = 0; i < given_.size(); ++i) all[layout_.start[i]] = given_[i];
  spread(x, all);
  return all;
}

/// The field at each disk of all others and of its own images; of sources that are constant on it, their constant.
std::vector<Complex> System::local_field(const std::vector<Complex>& coefficients) const {
  const std::vector<Source>& sources = arrangement_->sources;
  const Cells& cells = arrangement_->cells;
  const int terms = far_->order() + 1;
  std::vector<Complex> scaled(terms), local(layout_.size());
  far_->clear_sources();
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const Complex *a = &coefficients[layout_.start[s]], *shift = &shifts_[s * terms];
    Complex* alpha = far_->source(cells.cell_of(sources[s].centre));
    const int count = std::min(sources[s].order + 1, terms);
    scaled[0] = -a[0];
    double power = -1;  // (-1)^(k-1) (R/h)^k / (k-1)!
    for (int k = 1; k < count; ++k) {
      power *= -sources[s].radius / far_->scale() / std::max(1, k - 1);
      scaled[k] = power * a[k];
    }
    for (int l = 0; l < terms; ++l) {
      Complex sum = 0;
      for (int k = 0; k <= std::min(l, count - 1); ++k) sum += multiply(shift[l - k], scaled[k]);
      alpha[l] += sum;
    }
  }
  far_->apply();
  for (int i = 0; i < arrangement_->disks; ++i) {
    const Complex* beta = far_->local(cells.cell_of(sources[i].centre));
    const Complex* shift = &shifts_[i * terms];
    Complex* b = &local[layout_.start[i]];
    const int count = std::min(sources[i].order + 1, terms);
    double power = 1;  // (R/h)^m / m!
    for (int m = 0; m < count; ++m) {
      Complex sum = 0;  // shift has the sign of the way to the cell's centre
      for (int l = m; l < terms; ++l) {
        const Complex term = multiply(beta[l], shift[l - m]);
        sum += (l - m) % 2 == 0 ? term : -term;
      }
      b[m] = power * sum;
      power *= sources[i].radius / far_->scale() / (m + 1);
    }
  }
  near_.add(layout_, coefficients.data(), local.data());
  return local;
}

/// Mean over each circle of the potential that sources make, the disk's own included.
std::vector<double> System::mean_potentials(const std::vector<Complex>& local) const {
  std::vector<double> mean(given_.size());
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = local[layout_.start[i]].real();
  return mean;
}

/// Adds the left-hand sides of all equations but the multipoles'.
void System::balance(const Eigen::VectorXd& x, const std::vector<double>& mean_potential, Eigen::VectorXd& y) const {
  const auto add_to_sums = [&](int disk, double lambda) {
    if (charge_unknown_[disk] < 0) return;
    if (const int potential = potential_unknown_[group_of(disk)]; potential >= 0) y[potential] += lambda;
    if (level_ >= 0) y[level_] += lambda;
  };
  for (int i = 0; i < arrangement_->disks; ++i) {
    const int unknown = charge_unknown_[i], potential = potential_unknown_[group_of(i)];
    if (unknown < 0) continue;
    y[unknown] += mean_potential[i] + (level_ < 0 ? 0.0 : x[level_]) - (potential < 0 ? 0.0 : x[potential]);
    add_to_sums(i, x[unknown]);
  }
  for (std::size_t p = 0; p < pair_unknown_.size(); ++p) {
    const ClosePair& pair = arrangement_->close_pairs[p];
    const double lambda = x[pair_unknown_[p]];
    y[pair_unknown_[p]] += mean_potential[pair.first] - pair.difference * lambda;
    add_to_sums(pair.first, lambda);
    if (pair.second < 0) continue;
    y[pair_unknown_[p]] -= mean_potential[pair.second];
    add_to_sums(pair.second, -lambda);
  }
}

Eigen::VectorXd System::operator*(const Eigen::VectorXd& x) const {
  std::vector<Complex> a(layout_.size());
  spread(x, a);
  const std::vector<Complex> local = local_field(a);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const double share = 1.0 / arrangement_->copies[i];
    for (int k = layout_.start[i] + 1; k < layout_.start[i + 1]; ++k, next += 2) {
      y[next] = x[next] + share * local[k].real();
      y[next + 1] = x[next + 1] - share * local[k].imag();
    }
  }
  balance(x, mean_potentials(local), y);
  return y;
}

Eigen::VectorXd System::right_hand_side() const {
  std::vector<Complex> local = local_field(coefficients(Eigen::VectorXd::Zero(size())));
  for (std::size_t k = 0; k < local.size(); ++k) local[k] += wall_[k];
  const std::vector<double> mean = mean_potentials(local);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const double share = 1.0 / arrangement_->copies[i];
    for (int k = layout_.start[i] + 1; k < layout_.start[i + 1]; ++k, next += 2) {
      y[next] = -share * local[k].real();
      y[next + 1] = share * local[k].imag();
    }
    if (level_ >= 0) y[level_] -= given_[i];
    if (charge_unknown_[i] < 0) continue;
    const Group& group = problem_->groups[group_of(i)];
    y[charge_unknown_[i]] = (group.floating ? 0.0 : group.potential) - mean[i];
    if (group.floating)
      y[potential_unknown_[group_of(i)]] = group.charge / (2 * std::numbers::pi * problem_->permittivity);
  }
  for (std::size_t p = 0; p < pair_unknown_.size(); ++p) {
    const ClosePair& pair = arrangement_->close_pairs[p];
    y[pair_unknown_[p]] =
        (pair.second < 0 ? problem_->sides[pair.side].potential : mean[pair.second]) - mean[pair.first];
  }
  return y;
}

Eigen::VectorXd System::first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                                    const Eigen::VectorXd& past_extra) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (int i = 0; i < arrangement_->disks; ++i) {
    const int past_order = past_layout.order(i);
    for (int k = 1; k <= arrangement_->sources[i].order; ++k, next += 2) {
      if (k > past_order) continue;
      const Complex a = past_coefficients[past_layout.start[i] + k];
      x[next] = a.real();
      x[next + 1] = a.imag();
    }
  }
  if (past_extra.size() == extra_unknowns_) x.tail(extra_unknowns_) = past_extra;
  return x;
}

Eigen::VectorXd System::precondition(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd z = residual;
  if (extra_.rows() > 0) z.tail(extra_unknowns_) = extra_.solve(residual.tail(extra_unknowns_));
  return z;
}

System::Potentials System::potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const {
  const std::vector<double> mean_potential = mean_potentials(local_field(coefficients));
  Potentials potentials{std::vector<double>(problem_->groups.size()), level_ < 0 ? 0.0 : x[level_]};
  std::vector<double>& group = potentials.group;
  for (std::size_t g = 0; g < group.size(); ++g) {
    if (!problem_->groups[g].floating) group[g] = problem_->groups[g].potential;
    if (potential_unknown_[g] >= 0) group[g] = x[potential_unknown_[g]];
  }
  for (std::size_t i = 0; i < given_.size(); ++i)
    if (const int g = group_of(i); problem_->groups[g].floating && potential_unknown_[g] < 0)
      group[g] = mean_potential[i] + wall_[layout_.start[i]].real() + potentials.level;
  if (problem_->has_ground()) return potentials;
  double mean = 0;
  for (std::size_t i = 0; i < given_.size(); ++i) mean += group[group_of(i)] / static_cast<double>(given_.size());
  for (double& phi : group) phi -= mean;
  potentials.level = -mean;
  return potentials;
}

}  // namespace lichtenberg::laplace
