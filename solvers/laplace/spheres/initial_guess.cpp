#include "solvers/laplace/spheres/initial_guess.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace lichtenberg::laplace::spheres {
namespace {

double norm(const std::vector<double>& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())).norm();
}

/// Returns the total charge of the spheres of a constraint.
double charge(const ChargeConstraint& constraint, const PastSolution& past, const std::vector<int>& start) {
  double sum = 0;
  for (const int i : constraint.spheres) sum += std::sqrt(past.sites[i].radius) * past.x[start[i]];
  return sum;
}

/// Returns the deviation of each site's potential from its fixed value (potentials of fixed sites are returned as they
/// are), or from the mean of its group.
std::vector<double> missed_potentials(const SolveTarget& target, const std::vector<double>& potential) {
  std::vector<double> sum(potential.size()), count(potential.size()), missed(potential);
  for (std::size_t i = 0; i < potential.size(); ++i) sum[target.group[i]] += potential[i], ++count[target.group[i]];
  for (std::size_t i = 0; i < potential.size(); ++i)
    if (std::isnan(target.fixed[i])) missed[i] -= sum[target.group[i]] / count[target.group[i]];
  return missed;
}

/// Conditions of the linear combination, all in units of the length of x. These are charges, each like that of one
/// sphere of the constraint's weight, and potentials. Displacements since the latest solution are further conditions;
/// one by a radius changes all of a sphere's x. Larger displacements are jumps across a periodic box and are ignored.
class Conditions {
 public:
  Conditions(const SolveTarget& target, const PastSolution& latest)
      : target_(target), latest_(latest), latest_start_(starts(latest.sites)) {}

  Eigen::VectorXd values_of(const PastSolution& past) const {
    const std::vector<int> start = starts(past.sites);
    std::vector<double> charges;
    for (const ChargeConstraint& constraint : target_.constraints) charges.push_back(charge(constraint, past, start));
    return gathered(charges, past.sites, missed_potentials(target_, past.potential), past.wall);
  }
  Eigen::VectorXd target_values() const {
    std::vector<double> charges, potential;
    for (const ChargeConstraint& constraint : target_.constraints) charges.push_back(constraint.charge);
    for (const double value : target_.fixed) potential.push_back(std::isnan(value) ? 0 : value);
    return gathered(charges, target_.sites, potential, target_.wall);
  }

 private:
  Eigen::VectorXd gathered(const std::vector<double>& charges, const std::vector<Site>& sites,
                           const std::vector<double>& potential, const std::vector<double>& wall) const {
    std::vector<double> all;
    for (std::size_t g = 0; g < charges.size(); ++g)
      all.push_back(charges[g] / std::sqrt(target_.constraints[g].weight));
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const double radius = sites[i].radius;
      const auto first = latest_.x.begin() + latest_start_[i];
      const double own = norm({first, latest_.x.begin() + latest_start_[i + 1]});
      const Vec3 displacement = (sites[i].centre - latest_.sites[i].centre) * (1 / radius);
      for (int k = 0; k < 3; ++k) all.push_back(norm2(displacement) < 1 ? displacement[k] * own : 0);
      all.push_back(std::sqrt(radius) * potential[i]);
      all.push_back(std::sqrt(radius) * wall[i]);
    }
    return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  const SolveTarget& target_;
  const PastSolution& latest_;
  std::vector<int> latest_start_;
};

}  // namespace

std::vector<double> history_coefficients(const History& history, const SolveTarget& target, double noise) {
  const Conditions conditions(target, history.front());
  const Eigen::VectorXd now = conditions.target_values();
  const auto count = static_cast<Eigen::Index>(history.size());
  Eigen::MatrixXd past(now.size(), count);
  Eigen::VectorXd error(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    past.col(k) = conditions.values_of(history[k]);
    error[k] = noise * norm(history[k].x);
  }
  Eigen::MatrixXd squares = past.transpose() * past;
  squares.diagonal() += error.cwiseAbs2();
  const Eigen::VectorXd share = squares.ldlt().solve(past.transpose() * now);
  if (!share.allFinite()) return std::vector<double>(history.size());  // All past solutions are zero
  return {share.begin(), share.end()};
}

}  // namespace lichtenberg::laplace::spheres
