#include "src/theory/kinetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Value below which the series replaces the closed forms, which lose digits by cancellation.
constexpr double small_beta = 0.5;

/// Returns P = (1/2) sum over n of h_n Gamma((n + 1)/2)^2 beta^n, for w h with Gamma(n/2 + 1)^2. The moments of K_0 are
/// int w^n K_0(2w) dw = Gamma((n + 1)/2)^2 / 4. The series are h_N = sum (-1)^n (2n - 1) b^n/n! and h_T = -sum (-1)^n
/// (2n - 1)(n - 2) b^n/n!.
MergingIntegrals merging_series(double beta) {
  MergingIntegrals sum;
  double term = beta * beta / 2;  // (-beta)^n / n! at n = 2
  double even = pi / 4, odd = 1;  // Gamma((n + 1)/2)^2, Gamma(n/2 + 1)^2
  for (int n = 2; n < 60; ++n) {
    const double h = (2 * n - 1) * term / 2;
    sum.number += h * even;
    sum.energy -= h * even * (n - 2);
    sum.charge += h * odd;
    term *= -beta / (n + 1);
    even = std::exchange(odd, even * (n + 1) * (n + 1) / 4.0);
  }
  return sum;
}

/// J(beta) = acos(beta/2) / sqrt(4 - beta^2) and its first two derivatives.
struct Arc {
  double j = 0, first = 0, second = 0;
};

/// Returns J = 2/(2 + beta) A(z), z = (2 - beta)/(2 + beta), A = atan(sqrt z)/sqrt z = sum (-z)^n / (2n + 1), and
/// derivatives.
Arc arc_near_two(double beta) {
  const double z = (2 - beta) / (2 + beta), a = 2 / (2 + beta);
  double value = 0, first = 0, second = 0;
  for (int n = 30; n >= 0; --n) {  // |z| < .12
    const double c = (n % 2 ? -1.0 : 1.0) / (2 * n + 1);
    second = second * z + 2 * first;
    first = first * z + value;
    value = value * z + c;
  }
  // Derivatives of z and a by beta: z' = -a^2, z'' = a^3, a' = -a^2/2, a'' = a^3/2.
  const double z1 = -a * a, z2 = a * a * a, a1 = -a * a / 2, a2 = a * a * a / 2;
  return {a * value, a1 * value + a * first * z1,
          a2 * value + 2 * a1 * first * z1 + a * (second * z1 * z1 + first * z2)};
}

Arc arc(double beta) {
  if (std::abs(2 - beta) < 0.1 * (2 + beta)) return arc_near_two(beta);
  const double square = (2 - beta) * (2 + beta), root = std::sqrt(std::abs(square));
  const double j = (beta < 2 ? std::acos(beta / 2) : std::acosh(beta / 2)) / root;
  const double first = (beta * j - 1) / square;
  return {j, first, (j + 3 * beta * first) / square};
}

/// Returns the mean of f(c), c = beta |sin cos| of a uniformly distributed angle. Gaussian charges q_i, q_j = r (cos,
/// sin) have b = c r^2, r^2 ~ exp(-r^2).
template <class F>
double angular_mean(double beta, const F& f) {
  static boost::math::quadrature::tanh_sinh<double> quadrature;
  if (beta == 0) return f(0.0);
  const auto by_angle = [&](double phi) { return f(beta / 2 * std::sin(phi)); };
  return 2 / pi * quadrature.integrate(by_angle, 0.0, pi / 2, 1e-12);
}

/// A table of a function of ln T at equal distances, interpolated by the polynomial through the six nearest points.
class LogTable {
 public:
  template <class F>
  LogTable(const F& f, double coldest, double hottest)
      : low_(std::log(coldest)), step_((std::log(hottest) - low_) / (points - 1)) {
    for (int k = 0; k < points; ++k) value_.push_back(f(std::exp(low_ + k * step_)));
  }

  /// Evaluates the barycentric formula, in steps from the first of the six points. The function is constant beyond both
  /// ends.
  double operator()(double temperature) const {
    const double position = temperature > 0 ? std::clamp((std::log(temperature) - low_) / step_, 0.0, points - 1.0) : 0;
    const int first = std::clamp(static_cast<int>(position) - 2, 0, points - 6);
    constexpr double weights[] = {-1, 5, -10, 10, -5, 1};
    double sum = 0, all = 0;
    for (int k = 0; k < 6; ++k) {
      const double distance = position - first - k;
      if (distance == 0) return value_[first + k];
      sum += weights[k] / distance * value_[first + k];
      all += weights[k] / distance;
    }
    return sum / all;
  }

 private:
  static constexpr int points = 200;
  double low_, step_;
  std::vector<double> value_;
};

/// Returns the mean over contacts of a gas of this beta. f(T/m), an integral of psi x^(p - 2) exp(-x), is the mean for
/// a neutral gas. Repulsion by charges prevents contacts, which subtracts f((T/m) c/(1 + c)) (c/(1 + c))^p.
double contact_mean(double beta, int p, double temperature, const std::function<double(double)>& f) {
  return f(temperature) - angular_mean(beta, [&](double c) {
           const double part = c / (1 + c);
           return part > 0 ? std::pow(part, p) * f(temperature * part) : 0.0;
         });
}

}  // namespace

double encounter_rate(const Aggregates& gas) {
  return 2 * std::sqrt(pi * gas.temperature / gas.mass) * std::pow(gas.density * gas.diameter, 2);
}

MergingIntegrals merging_integrals(double beta) {
  if (!(beta >= 0 && beta < 1e150))
    throw InputError(
        fmt::format("the integrals over merging collisions are for beta = 2B in [0, 1e150) with the ratio B = K <q^2> "
                    "/ (T d) of Coulomb energy to temperature, not for beta = {}",
                    beta));
  if (beta <= small_beta) return merging_series(beta);
  const auto [j, first, second] = arc(beta);
  return {2 * (pi / 4 + beta / 4 - j + 2 * beta * first),
          2 * (pi / 2 + beta / 4 - 2 * j + 3 * beta * first - 2 * beta * beta * second),
          2 * (0.25 + beta * pi / 16 + first - 2 * beta * second)};
}

/// Returns pi Gamma(p) times the mean of 1 - (c/(1 + c))^p.
double contact_integral(double p, double beta) {
  if (!(p > 0 && beta >= 0))
    throw InputError(
        fmt::format("the contact integral G(p, beta) is for p > 0 and beta >= 0, not for p = {}, beta = {}", p, beta));
  const auto kept = [p](double c) { return c > 0 ? -std::expm1(-p * std::log1p(1 / c)) : 1.0; };
  return pi * std::tgamma(p) * angular_mean(beta, kept);
}

ImpactMeans tabulated_means(const Impacts& impacts, double hottest) {
  constexpr double coldest = 1e-20;
  const LogTable loss(
      [&](double t) {
        return impact_mean(t, [&](double v, double x) {
          const double eps = impacts.restitution(v);
          return x * (1 - eps * eps);
        });
      },
      coldest, hottest);
  ImpactMeans means{loss, [](double) { return 0.0; }};
  if (!impacts.charge_square) return means;
  const auto charge = [&](double t) {
    return impact_mean(t, [&](double v, double) { return impacts.charge_square(v); });
  };
  if (!(charge(hottest) > 0)) return means;
  // The values span tens of decades, and their logarithm is nearly linear.
  const LogTable log_charge([&](double t) { return std::log(charge(t)); }, coldest, hottest);
  means.charge = [log_charge](double t) { return std::exp(log_charge(t)); };
  return means;
}

KineticRates kinetic_rates(const Aggregates& gas, double coupling, const ImpactMeans& means) {
  const double beta = 2 * gas.bjerrum(coupling), before = encounter_rate(gas), heat = gas.temperature / gas.mass;
  const MergingIntegrals merging = merging_integrals(beta);
  return {.mergers = before / pi * merging.number,
          .contact_loss = before * gas.temperature * contact_mean(beta, 3, heat, means.loss),
          .merging_loss = before / pi * gas.temperature * merging.energy,
          .contact_charge = before * 2 * contact_mean(beta, 2, heat, means.charge),
          .merging_charge = before * 4 / pi * gas.charge_square * merging.charge};
}

}  // namespace lichtenberg::theory
