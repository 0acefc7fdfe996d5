#include "solvers/laplace/multipole/system.hpp"

#include <numbers>

namespace lichtenberg::laplace::multipole {

namespace {

/// Number of unknown charges, potentials and close pairs beyond which a dense factorization costs more than the
/// iterations that it saves.
constexpr int most_factorized = 4000;

}  // namespace

Unknowns::Unknowns(const LaplaceProblem& problem, const Mirrors& mirrors, const Arrangement& arrangement)
    : given_charge(arrangement.disks), charge(arrangement.disks, -1), potential(problem.groups.size(), -1) {
  std::vector<int> members(problem.groups.size());
  for (const Body& body : problem.bodies) ++members[body.group];
  for (int i = 0; i < arrangement.disks; ++i) multipoles += 2 * arrangement.sources[i].order;
  int next = multipoles;
  for (int i = 0; i < arrangement.disks; ++i) {
    const int group = problem.bodies[i].group;
    given_charge[i] = problem.groups[group].floating && members[group] == 1;
    if (!given_charge[i] && !arrangement.anchored[i]) charge[i] = next++;
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    if (problem.groups[g].floating && members[g] > 1) potential[g] = next++;
  if (!mirrors.grounded() && problem.has_ground()) level = next++;
  for (std::size_t p = 0; p < arrangement.close_pairs.size(); ++p) close_pair.push_back(next++);
  others = next - multipoles;
}

System::System(const Setting& setting, FarField& far, double accuracy)
    : setting_(&setting),
      far_(&far),
      near_(setting.arrangement, accuracy),
      wall_(setting.layout.size()),
      given_(setting.arrangement.disks, 0.0),
      unknown_(setting.problem, setting.mirrors, setting.arrangement) {
  make_shifts();
  for (int i = 0; i < disks() && setting.mirrors.grounded(); ++i) {
    const Source& disk = setting.arrangement.sources[i];
    setting.wall.local(disk.centre, disk.radius, disk.order + 1, &wall_[setting.layout.start[i]]);
  }
  for (int i = 0; i < disks(); ++i)
    if (unknown_.given_charge[i]) given_[i] = lambda(setting.problem.groups[group_of(i)].charge);
  if (unknown_.others > 0 && unknown_.others <= most_factorized) factorize();
}

void System::make_shifts() {
  const Cells& cells = setting_->arrangement.cells;
  const int terms = far_->order() + 1;
  shifts_.reserve(setting_->arrangement.sources.size() * terms);
  for (const Source& source : setting_->arrangement.sources) {
    const Complex shift = (cells.centre(cells.cell_of(source.centre)) - source.centre) / far_->scale();
    Complex power = 1;
    for (int j = 0; j < terms; ++j) {
      shifts_.push_back(power);
      power = multiply(power, shift) / (j + 1.0);
    }
  }
}

double System::lambda(double charge) const { return charge / (2 * std::numbers::pi * setting_->problem.permittivity); }

/// Returns the sources whose charge is an unknown, or depends on that of a close pair; disks first.
std::vector<int> System::charged_sources() const {
  std::vector<bool> charged(setting_->arrangement.sources.size(), false);
  for (int i = 0; i < disks(); ++i) charged[i] = unknown_.charge[i] >= 0;
  for (const ClosePair& pair : setting_->arrangement.close_pairs)
    for (const int s : {pair.first, pair.second, pair.first_charge, pair.second_charge})
      if (s >= 0) charged[s] = true;
  std::vector<int> sources;
  for (int s = 0; s < static_cast<int>(charged.size()); ++s)
    if (charged[s]) sources.push_back(s);
  return sources;
}

/// Returns the mean potential on each disk of `on`, for lambda = 1 on each source of `of`, which must begin with `on`.
Eigen::MatrixXd System::interaction(const std::vector<int>& on, const std::vector<int>& of) const {
  const std::vector<Source>& sources = setting_->arrangement.sources;
  Eigen::MatrixXd potential(on.size(), of.size());
  for (Eigen::Index row = 0; row < potential.rows(); ++row)
    for (Eigen::Index column = 0; column < potential.cols(); ++column) {
      if (column < row) {  // The interaction of two disks is symmetric
        potential(row, column) = potential(column, row);
        continue;
      }
      const Source &disk = sources[on[row]], &source = sources[of[column]];
      double sum = 0;
      for (const Image& image : setting_->mirrors.images)
        sum -= image.sign * setting_->lattice.real_part(disk.centre - image.centre(source.centre), disk.radius);
      potential(row, column) = sum;
    }
  return potential;
}

/// Factorizes the matrix of the unknowns other than multipoles: the whole system if the disks had no multipoles.
void System::factorize() {
  const std::vector<int> charged = charged_sources();
  const std::vector<int> needed(charged.begin(), std::lower_bound(charged.begin(), charged.end(), disks()));
  const Eigen::MatrixXd potential = interaction(needed, charged);
  Eigen::MatrixXd matrix(unknown_.others, unknown_.others);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size()), y = x, value(potential.rows());
  std::vector<double> mean(disks());
  std::vector<Complex> coefficients(setting_->layout.size());
  for (int u = 0; u < unknown_.others; ++u) {
    x[unknown_.multipoles + u] = 1;
    std::fill(coefficients.begin(), coefficients.end(), Complex{0});
    spread(x, coefficients);
    value.setZero();
    for (Eigen::Index s = 0; s < potential.cols(); ++s)
      if (const double charge = coefficients[setting_->layout.start[charged[s]]].real(); charge != 0)
        value += charge * potential.col(s);
    for (Eigen::Index row = 0; row < value.size(); ++row) mean[needed[row]] = value[row];
    y.tail(unknown_.others).setZero();
    balance(x, mean, y);
    matrix.col(u) = y.tail(unknown_.others);
    x[unknown_.multipoles + u] = 0;
  }
  extra_inverse_.compute(matrix);
}

/// Adds the contributions of the unknowns to the coefficients. A point charge is subtracted from its disk, unless the
/// disk's charge is unknown or determined by an electrode.
void System::spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const {
  const std::vector<int>& start = setting_->layout.start;
  int next = 0;
  for (int i = 0; i < disks(); ++i) {
    if (unknown_.charge[i] >= 0) coefficients[start[i]] += x[unknown_.charge[i]];
    for (int k = start[i] + 1; k < start[i + 1]; ++k, next += 2) coefficients[k] = {x[next], x[next + 1]};
  }
  const auto charge = [&](int disk, int point, double amount) {
    if (point < 0) return;
    coefficients[start[point]] += amount;
    if (unknown_.charge[disk] < 0 && !setting_->arrangement.anchored[disk]) coefficients[start[disk]] -= amount;
  };
  for (std::size_t p = 0; p < unknown_.close_pair.size(); ++p) {
    const ClosePair& pair = setting_->arrangement.close_pairs[p];
    charge(pair.first, pair.first_charge, x[unknown_.close_pair[p]]);
    charge(pair.second, pair.second_charge, -x[unknown_.close_pair[p]]);
  }
}

std::vector<Complex> System::coefficients(const Eigen::VectorXd& x) const {
  std::vector<Complex> all(setting_->layout.size());
  for (int i = 0; i < disks(); ++i) all[setting_->layout.start[i]] = given_[i];
  spread(x, all);
  return all;
}

/// Shifts the sources to the centres of their cells, in FarField's units.
void System::gather_in_cells(const std::vector<Complex>& coefficients) const {
  const int terms = far_->order() + 1;
  std::vector<Complex> scaled(terms);
  const Complex* shift = shifts_.data();
  far_->clear_sources();
  for (int s = 0; s < setting_->layout.sources(); ++s, shift += terms) {
    const Source& source = setting_->arrangement.sources[s];
    const Complex* a = &coefficients[setting_->layout.start[s]];
    Complex* alpha = far_->source(setting_->arrangement.cells.cell_of(source.centre));
    const int count = std::min(source.order + 1, terms);
    scaled[0] = -a[0];
    double power = -1;  // (-1)^(k-1) (R/h)^k / (k-1)!
    for (int k = 1; k < count; ++k) {
      power *= -source.radius / far_->scale() / std::max(1, k - 1);
      scaled[k] = power * a[k];
    }
    for (int l = 0; l < terms; ++l) {
      Complex sum = 0;
      for (int k = 0; k <= std::min(l, count - 1); ++k) sum += multiply(shift[l - k], scaled[k]);
      alpha[l] += sum;
    }
  }
}

/// Shifts the cells' local fields to the centres of their disks.
void System::shift_to_disks(std::vector<Complex>& local) const {
  const int terms = far_->order() + 1;
  const Complex* shift = shifts_.data();
  std::vector<Complex> away(terms);
  for (int i = 0; i < disks(); ++i, shift += terms) {
    const Source& disk = setting_->arrangement.sources[i];
    const Complex* beta = far_->local(setting_->arrangement.cells.cell_of(disk.centre));
    Complex* b = &local[setting_->layout.start[i]];
    for (int j = 0; j < terms; ++j) away[j] = j % 2 == 0 ? shift[j] : -shift[j];  // Shift from the cell's centre
    double power = 1;                                                             // (R/h)^m / m!
    for (int m = 0; m < std::min(disk.order + 1, terms); ++m) {
      Complex sum = 0;
      for (int l = m; l < terms; ++l) sum += multiply(beta[l], away[l - m]);
      b[m] = power * sum;
      power *= disk.radius / far_->scale() / (m + 1);
    }
  }
}

/// Returns the field at each disk due to all other sources and its own images; for sources whose potential is constant
/// on it, that constant.
std::vector<Complex> System::local_field(const std::vector<Complex>& coefficients) const {
  std::vector<Complex> local(setting_->layout.size());
  gather_in_cells(coefficients);
  far_->apply();
  shift_to_disks(local);
  near_.add(setting_->layout, coefficients.data(), local.data());
  return local;
}

/// Returns the mean potential over each circle due to the sources, the disk's own included.
std::vector<double> System::mean_potentials(const std::vector<Complex>& local) const {
  std::vector<double> mean(disks());
  for (int i = 0; i < disks(); ++i) mean[i] = local[setting_->layout.start[i]].real();
  return mean;
}

/// Adds the left-hand sides of all equations except those of the multipoles.
void System::balance(const Eigen::VectorXd& x, const std::vector<double>& mean_potential, Eigen::VectorXd& y) const {
  const auto add_to_sums = [&](int disk, double amount) {
    if (unknown_.charge[disk] < 0) return;
    if (const int potential = unknown_.potential[group_of(disk)]; potential >= 0) y[potential] += amount;
    if (unknown_.level >= 0) y[unknown_.level] += amount;
  };
  for (int i = 0; i < disks(); ++i) {
    const int unknown = unknown_.charge[i], potential = unknown_.potential[group_of(i)];
    if (unknown < 0) continue;
    y[unknown] += mean_potential[i];
    if (unknown_.level >= 0) y[unknown] += x[unknown_.level];
    if (potential >= 0) y[unknown] -= x[potential];
    add_to_sums(i, x[unknown]);
  }
  for (std::size_t p = 0; p < unknown_.close_pair.size(); ++p) {
    const ClosePair& pair = setting_->arrangement.close_pairs[p];
    const double amount = x[unknown_.close_pair[p]];
    y[unknown_.close_pair[p]] += mean_potential[pair.first] - pair.difference * amount;
    add_to_sums(pair.first, amount);
    if (pair.second < 0) continue;
    y[unknown_.close_pair[p]] -= mean_potential[pair.second];
    add_to_sums(pair.second, -amount);
  }
}

Eigen::VectorXd System::operator*(const Eigen::VectorXd& x) const {
  std::vector<Complex> a(setting_->layout.size());
  spread(x, a);
  const std::vector<Complex> local = local_field(a);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (int i = 0; i < disks(); ++i) {
    const double share = 1.0 / setting_->arrangement.copies[i];
    for (int k = setting_->layout.start[i] + 1; k < setting_->layout.start[i + 1]; ++k, next += 2) {
      y[next] = x[next] + share * local[k].real();
      y[next + 1] = x[next + 1] - share * local[k].imag();
    }
  }
  balance(x, mean_potentials(local), y);
  return y;
}

Eigen::VectorXd System::right_hand_side() const {
  const LaplaceProblem& problem = setting_->problem;
  std::vector<Complex> local = local_field(coefficients(Eigen::VectorXd::Zero(size())));
  for (std::size_t k = 0; k < local.size(); ++k) local[k] += wall_[k];
  const std::vector<double> mean = mean_potentials(local);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (int i = 0; i < disks(); ++i) {
    const double share = 1.0 / setting_->arrangement.copies[i];
    for (int k = setting_->layout.start[i] + 1; k < setting_->layout.start[i + 1]; ++k, next += 2) {
      y[next] = -share * local[k].real();
      y[next + 1] = share * local[k].imag();
    }
    if (unknown_.level >= 0) y[unknown_.level] -= given_[i];
    if (unknown_.charge[i] < 0) continue;
    const Group& group = problem.groups[group_of(i)];
    y[unknown_.charge[i]] = (group.floating ? 0.0 : group.potential) - mean[i];
    if (group.floating) y[unknown_.potential[group_of(i)]] = lambda(group.charge);
  }
  for (std::size_t p = 0; p < unknown_.close_pair.size(); ++p) {
    const ClosePair& pair = setting_->arrangement.close_pairs[p];
    const double across = pair.second < 0 ? problem.sides[pair.side].potential : mean[pair.second];
    y[unknown_.close_pair[p]] = across - mean[pair.first];
  }
  return y;
}

Eigen::VectorXd System::precondition(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd z = residual;
  if (extra_inverse_.rows() > 0) z.tail(unknown_.others) = extra_inverse_.solve(residual.tail(unknown_.others));
  return z;
}

Eigen::VectorXd System::first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                                    const Eigen::VectorXd& past_extra) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
  int next = 0;
  for (int i = 0; i < disks(); ++i) {
    const int order = setting_->layout.order(i);
    for (int k = 1; k <= std::min(order, past_layout.order(i)); ++k) {
      const Complex a = past_coefficients[past_layout.start[i] + k];
      x[next + 2 * k - 2] = a.real();
      x[next + 2 * k - 1] = a.imag();
    }
    next += 2 * order;
  }
  if (past_extra.size() == unknown_.others) x.tail(unknown_.others) = past_extra;
  return x;
}

System::Potentials System::potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const {
  const std::vector<Group>& groups = setting_->problem.groups;
  const std::vector<double> mean_potential = mean_potentials(local_field(coefficients));
  Potentials potentials{std::vector<double>(groups.size()), unknown_.level < 0 ? 0.0 : x[unknown_.level]};
  std::vector<double>& group = potentials.group;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!groups[g].floating) group[g] = groups[g].potential;
    if (unknown_.potential[g] >= 0) group[g] = x[unknown_.potential[g]];
  }
  for (int i = 0; i < disks(); ++i)
    if (const int g = group_of(i); groups[g].floating && unknown_.potential[g] < 0)
      group[g] = mean_potential[i] + wall_[setting_->layout.start[i]].real() + potentials.level;
  if (setting_->problem.has_ground()) return potentials;
  double mean = 0;
  for (int i = 0; i < disks(); ++i) mean += group[group_of(i)] / disks();
  for (double& phi : group) phi -= mean;
  potentials.level = -mean;
  return potentials;
}

}  // namespace lichtenberg::laplace::multipole
