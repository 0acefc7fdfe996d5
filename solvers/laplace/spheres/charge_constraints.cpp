#include "solvers/laplace/spheres/charge_constraints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lichtenberg::laplace::spheres {

ChargeConstraints::ChargeConstraints(const SphereProblem& problem, const std::vector<int>& start, int couplings)
    : problem_(&problem),
      scale_(4 * std::numbers::pi * problem.permittivity),
      start_(start),
      first_(couplings),
      node_of_group_(problem.groups.size(), -1) {
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    if (!problem.groups[g].floating) continue;
    node_of_group_[g] = static_cast<int>(charge_.size());
    charge_.push_back(problem.groups[g].charge / scale_);
  }
  if (!problem.grounded() && problem.has_ground()) {
    level_ = static_cast<int>(charge_.size());
    double floating = 0;
    for (const double charge : charge_) floating += charge;
    charge_.push_back(-floating);
    for (int& node : node_of_group_) node = node < 0 ? level_ : node;
  }
  std::vector<double> ground(charge_.size());
  std::vector<NetworkLink> network;
  // Largest capacitance in use. The end potentials of a coupling r times the spheres' capacitance differ by 1 / r of
  // the potentials, and its contribution to the right-hand side has a rounding error of sqrt(r). Where both are equal
  // the coupling acts as a wire, and a larger capacitance improves nothing.
  double wire = 0;
  for (const Sphere& sphere : problem.spheres)
    wire += sphere.radius * std::pow(std::numeric_limits<double>::epsilon(), -2.0 / 3);
  for (const Sphere& sphere : problem.spheres) {
    node_of_sphere_.push_back(node_of_group_[sphere.group]);
    root_.push_back(std::sqrt(sphere.radius));
    if (node_of_sphere_.back() >= 0) ground[node_of_sphere_.back()] += sphere.radius;
  }
  for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
    const auto& [a, b, coupling_capacitance] = problem.couplings[k];
    const double capacitance = std::min(coupling_capacitance / scale_, wire);
    const Group &from = problem.groups[a], &to = problem.groups[b];
    if (capacitance == 0 || (!from.floating && !to.floating)) continue;
    const Link link{.a = node_of_group_[a],
                    .b = node_of_group_[b],
                    .coupling = static_cast<int>(k),
                    .root = std::sqrt(capacitance),
                    .supply = (to.floating ? 0 : to.potential) - (from.floating ? 0 : from.potential)};
    links_.push_back(link);
    if (link.a >= 0 && link.b >= 0)
      network.push_back({link.a, link.b, capacitance});
    else
      ground[std::max(link.a, link.b)] += capacitance;
  }
  factors_ = NetworkFactors(std::move(ground), network);
}

/// Returns N x.
std::vector<double> ChargeConstraints::flows(const double* x) const {
  std::vector<double> flow(charge_.size());
  for (std::size_t i = 0; i < root_.size(); ++i)
    if (node_of_sphere_[i] >= 0) flow[node_of_sphere_[i]] += root_[i] * x[start_[i]];
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const double carried = links_[k].root * x[first_ + k];
    if (links_[k].a >= 0) flow[links_[k].a] += carried;
    if (links_[k].b >= 0) flow[links_[k].b] -= carried;
  }
  return flow;
}

/// Adds N' potential: x += sign N' potential.
void ChargeConstraints::spread(const std::vector<double>& potential, double sign, double* x) const {
  const auto of = [&](int node) { return node < 0 ? 0 : potential[node]; };
  for (std::size_t i = 0; i < root_.size(); ++i)
    if (node_of_sphere_[i] >= 0) x[start_[i]] += sign * root_[i] * potential[node_of_sphere_[i]];
  for (std::size_t k = 0; k < links_.size(); ++k)
    x[first_ + k] += sign * links_[k].root * (of(links_[k].a) - of(links_[k].b));
}

void ChargeConstraints::project(double* x) const {
  std::vector<double> potential = flows(x);
  factors_.solve(potential.data());
  spread(potential, -1, x);
}

void ChargeConstraints::add(double* x) const {
  std::vector<double> potential = charge_;
  factors_.solve(potential.data());
  spread(potential, 1, x);
}

void ChargeConstraints::enforce_charges(double* x) const {
  std::vector<double> missing = flows(x);
  for (std::size_t n = 0; n < missing.size(); ++n) missing[n] = charge_[n] - missing[n];
  factors_.solve(missing.data());
  spread(missing, 1, x);
}

void ChargeConstraints::add_fixed_potentials(double* right_hand_side) const {
  for (std::size_t k = 0; k < links_.size(); ++k) right_hand_side[first_ + k] -= links_[k].root * links_[k].supply;
}

std::vector<double> ChargeConstraints::potentials(const double* missed) const {
  std::vector<double> multiplier = flows(missed);
  factors_.solve(multiplier.data());
  const double level = level_ < 0 ? 0 : -multiplier[level_];
  std::vector<double> potential;
  for (std::size_t g = 0; g < node_of_group_.size(); ++g) {
    const Group& group = problem_->groups[g];
    potential.push_back(group.floating ? multiplier[node_of_group_[g]] + level : group.potential);
  }
  return potential;
}

std::vector<double> ChargeConstraints::carried(const double* x) const {
  std::vector<double> charge;
  for (const auto& [a, b, capacitance] : problem_->couplings) {
    const Group &from = problem_->groups[a], &to = problem_->groups[b];
    charge.push_back(from.floating || to.floating ? 0 : capacitance * (from.potential - to.potential));
  }
  for (std::size_t k = 0; k < links_.size(); ++k) charge[links_[k].coupling] = scale_ * links_[k].root * x[first_ + k];
  return charge;
}

std::vector<double> ChargeConstraints::differences(const double* x) const {
  std::vector<double> difference;
  for (std::size_t k = 0; k < links_.size(); ++k) difference.push_back(x[first_ + k] / links_[k].root);
  return difference;
}

void ChargeConstraints::set_differences(std::span<const double> difference, double* x) const {
  for (std::size_t k = 0; k < links_.size(); ++k) x[first_ + k] = links_[k].root * difference[k];
}

std::vector<ChargeConstraint> ChargeConstraints::on_spheres(std::span<const double> difference) const {
  std::vector<ChargeConstraint> constraints(charge_.size());
  for (std::size_t n = 0; n < constraints.size(); ++n) constraints[n].charge = charge_[n];
  for (std::size_t i = 0; i < root_.size(); ++i) {
    if (node_of_sphere_[i] < 0) continue;
    constraints[node_of_sphere_[i]].spheres.push_back(static_cast<int>(i));
    constraints[node_of_sphere_[i]].weight += root_[i] * root_[i];
  }
  for (std::size_t k = 0; k < difference.size(); ++k) {
    const double carried = links_[k].root * links_[k].root * difference[k];
    if (links_[k].a >= 0) constraints[links_[k].a].charge -= carried;
    if (links_[k].b >= 0) constraints[links_[k].b].charge += carried;
  }
  std::erase_if(constraints, [](const ChargeConstraint& one) { return one.spheres.empty(); });
  return constraints;
}

}  // namespace lichtenberg::laplace::spheres
