#include "tests/line_charges.hpp"

#include <cmath>
#include <numbers>

#include "tests/dense_algebra.hpp"

namespace lichtenberg {

namespace {

const Disk& disk(const laplace::LaplaceProblem& problem, Eigen::Index b) {
  return std::get<Disk>(problem.bodies[static_cast<std::size_t>(b)].shape);
}

Eigen::MatrixXd potential_coefficients(const laplace::LaplaceProblem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.bodies.size());
  const double unit = 1 / (2 * std::numbers::pi * problem.permittivity);
  Eigen::MatrixXd p(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Disk &a = disk(problem, i), &b = disk(problem, j);
      p(i, j) = -unit * std::log((i == j ? a.radius : norm(a.centre - b.centre)) / problem.size.x);
    }
  return p;
}

/// Solves P q = u for charges q and potentials u. For each floating group the sum of q, plus capacitance (u - u') over
/// its couplings, equals its charge.
Eigen::VectorXd share(const laplace::LaplaceProblem& problem, const Eigen::MatrixXd& p) {
  const auto n = static_cast<Eigen::Index>(problem.bodies.size());
  const auto groups = static_cast<Eigen::Index>(problem.groups.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n + groups, n + groups);
  matrix.topLeftCorner(n, n) = p;
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n + groups);
  for (Eigen::Index g = 0; g < groups; ++g) {
    const laplace::Group& group = problem.groups[static_cast<std::size_t>(g)];
    rhs[n + g] = group.floating ? group.charge : group.potential;
    if (group.floating) matrix(n + g, n + g) = 0;
  }
  for (Eigen::Index b = 0; b < n; ++b) {
    const int g = problem.bodies[static_cast<std::size_t>(b)].group;
    matrix(b, n + g) = -1;
    if (problem.groups[static_cast<std::size_t>(g)].floating) matrix(n + g, b) = 1;
  }
  for (const laplace::Coupling& coupling : problem.couplings)
    for (const auto& [a, b] : {std::pair{coupling.a, coupling.b}, std::pair{coupling.b, coupling.a}}) {
      if (!problem.groups[static_cast<std::size_t>(a)].floating) continue;
      matrix(n + a, n + a) += coupling.capacitance;
      matrix(n + a, n + b) -= coupling.capacitance;
    }
  return solve_dense(matrix, rhs);
}

Vec2 force(const laplace::LaplaceProblem& problem, const Eigen::VectorXd& charge, std::size_t b) {
  const auto i = static_cast<Eigen::Index>(b);
  Vec2 sum;
  for (Eigen::Index j = 0; j < charge.size(); ++j) {
    if (j == i) continue;
    const Vec2 r = disk(problem, i).centre - disk(problem, j).centre;
    sum += charge[i] * charge[j] / (2 * std::numbers::pi * problem.permittivity * norm2(r)) * r;
  }
  return sum;
}

}  // namespace

laplace::LaplaceSolution LineCharges::solve(const laplace::LaplaceProblem& problem) {
  ++log_->solves;
  const Eigen::MatrixXd coefficients = potential_coefficients(problem);
  const Eigen::VectorXd charges_and_potentials = share(problem, coefficients);
  const auto bodies = static_cast<Eigen::Index>(problem.bodies.size());
  const Eigen::VectorXd charge = charges_and_potentials.head(bodies);
  const Eigen::VectorXd potential = coefficients * charge;
  const double off = 1 + 1e-9 * solves_since_forget_++;
  laplace::LaplaceSolution solution;
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    solution.group_potential.push_back(charges_and_potentials[bodies + static_cast<Eigen::Index>(g)] * off);
  solution.energy = 0.5 * charge.dot(potential);
  solution.iterations = 1;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    solution.body_charge.push_back(charge[static_cast<Eigen::Index>(b)] * off);
    solution.body_force.push_back(off * force(problem, charge, b));
  }
  return solution;
}

void LineCharges::forget() {
  ++log_->forgets;
  solves_since_forget_ = 0;
}

}  // namespace lichtenberg
