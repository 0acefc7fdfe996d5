#include "src/theory/restitution.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

constexpr int nodes = 40;

/// Returns the equations of s, s', and the work of the dashpot over k, in the variable sigma = sqrt(t), in which
/// sqrt(s) is smooth.
Ode universal_ode(double k) {
  const auto rates = [k](double sigma, std::span<const double> y, std::span<double> rate) {
    const double root = std::sqrt(std::max(y[0], 0.0));
    rate[0] = 2 * sigma * y[1];
    rate[1] = -2 * sigma * root * (y[0] + k * y[1]);
    rate[2] = 2 * sigma * root * y[1] * y[1];
  };
  return {.rates = rates, .absolute = {1e-16, 1e-16, 1e-16}};
}

double to_u(double k) { return std::sqrt(k) / (1 + std::sqrt(k)); }
double to_k(double u) { return u * u / ((1 - u) * (1 - u)); }

}  // namespace

UniversalCollision universal_collision(double k) {
  Ode ode = universal_ode(k);
  const double never = 1e3;
  std::vector<double> y = {0, 1, 0};
  ode.falls = {[](double, std::span<const double> now) { return now[1]; }};
  const double turn = integrate(ode, 0, never, y).time, deepest = y[0];
  ode.falls = {[k](double, std::span<const double> now) { return now[0] + k * now[1]; }};
  const double end = integrate(ode, turn, never, y).time, restitution = -y[1];
  // 1 - eps^2 is twice the total loss: that of the dashpot, and the energy left in the spring, 2/5 s^(5/2) at s = k
  // eps. The difference of 1 and eps would lose digits of this quotient at small k.
  const double lost = y[2] + 0.4 * std::pow(k, 1.5) * std::pow(restitution, 2.5);
  return {2 * lost / (1 + restitution), end * end, deepest};
}

double first_loss() { return 0.8 * std::pow(1.25, 0.6) * boost::math::beta(0.6, 1.5); }

RestitutionCurve::RestitutionCurve() {
  for (int n = 0; n <= nodes; ++n) {
    node_.push_back(to_u(largest) * (1 - std::cos(std::numbers::pi * n / nodes)) / 2);
    collision_.push_back(universal_collision(to_k(node_.back())));
  }
}

/// Evaluates the barycentric formula with the weights of Chebyshev nodes of the second kind (Berrut and Trefethen 2004,
/// eq. 5.4).
UniversalCollision RestitutionCurve::operator()(double k) const {
  if (!(k >= 0 && k <= largest))
    throw InputError(
        fmt::format("the restitution coefficient is tabulated for dissipation numbers (D/E) (E/m_eff)^(2/5) v^(1/5) "
                    "from 0 to {}, not for {}: smaller damping or impact speeds are needed",
                    largest, k));
  const double u = to_u(k);
  UniversalCollision sum;
  double weights = 0;
  for (int n = 0; n <= nodes; ++n) {
    if (u == node_[n]) return collision_[n];
    const double weight = (n % 2 ? -1.0 : 1.0) * (n == 0 || n == nodes ? 0.5 : 1.0) / (u - node_[n]);
    weights += weight;
    sum.loss += weight * collision_[n].loss;
    sum.duration += weight * collision_[n].duration;
    sum.deepest += weight * collision_[n].deepest;
  }
  return {sum.loss / weights, sum.duration / weights, sum.deepest / weights};
}

std::vector<double> RestitutionCurve::losses() const {
  std::vector<double> all;
  for (const UniversalCollision& one : collision_) all.push_back(one.loss);
  return all;
}

const RestitutionCurve& restitution_curve() {
  static const RestitutionCurve curve;
  return curve;
}

double pade_restitution(double k) {
  const double y = std::sqrt(k), above = 1 + 0.501086 * y;
  return above / (above + k * (1.15345 + y * (0.577977 + y * 0.532178)));
}

PairCollision collision(const ViscoelasticPair& pair, double speed) {
  const double k = dissipation_number(pair, speed);
  const double length = std::pow(pair.effective_mass * speed * speed / pair.elastic, 0.4);
  const UniversalCollision universal = restitution_curve()(k);
  return {1 - k * universal.loss, length / speed * universal.duration, length * universal.deepest};
}

double piercing_speed(const ViscoelasticPair& pair) { return std::sqrt(0.8 * pair.elastic / pair.effective_mass); }

}  // namespace lichtenberg::theory
