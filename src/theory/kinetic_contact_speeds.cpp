#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

#include "src/theory/kinetic.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Argument at which exp(-x) is negligible.
constexpr double far_off = 50;

/// Rates of a pair with a given b, without their common factors.
struct PairRates {
  double mergers = 0, contact_loss = 0, merging_loss = 0, contact_charge = 0;

  PairRates operator+(const PairRates& r) const {
    return {mergers + r.mergers, contact_loss + r.contact_loss, merging_loss + r.merging_loss,
            contact_charge + r.contact_charge};
  }
  PairRates operator*(double f) const { return {f * mergers, f * contact_loss, f * merging_loss, f * contact_charge}; }
};

/// Collisions of attracting grains as functions of y = m v_n^2 / (4T) at contact. Their energy at infinity, x, exceeds
/// y - b.
struct Attraction {
  const Impacts& impacts;
  double heat;  ///< T/m
  double b;

  double speed(double y) const { return 2 * std::sqrt(heat * y); }
  double lost(double y) const {
    const double eps = impacts.restitution(speed(y));
    return 1 - eps * eps;
  }
  double furthest() const { return b + far_off; }

  /// Returns the solution of y (1 - lost) = b; faster pairs separate for any x.
  double last_to_merge() const {
    const auto excess = [this](double y) { return y * (1 - lost(y)) - b; };
    if (!(b > 0) || excess(furthest()) < 0) return b > 0 ? furthest() : 0;
    std::uintmax_t steps = 100;
    const auto [low, high] =
        boost::math::tools::toms748_solve(excess, b, furthest(), boost::math::tools::eps_tolerance<double>(45), steps);
    return (low + high) / 2;
  }

  /// Returns the integral over x at this y. Pairs with x above the loss separate.
  PairRates at(double y) const {
    const double loss = lost(y) * y, least = std::max(y - b, 0.0), parting = std::max(loss, least);
    const double transfer = impacts.charge_square ? 2 * impacts.charge_square(speed(y)) : 0;
    PairRates rates{0, loss * std::exp(-parting), 0, transfer * std::exp(-parting)};
    if (loss <= least) return rates;
    rates.mergers = std::exp(-least) - std::exp(-loss);
    rates.merging_loss = (1 + least) * std::exp(-least) - (1 + loss) * std::exp(-loss);
    return rates;
  }

  /// Returns the integral over all y, in the variable r = y^(1/4), in which the rates are smooth: restitution is a
  /// series in v^(1/10).
  PairRates sum() const {
    std::vector<double> ends = {0, std::pow(b, 0.25), std::pow(last_to_merge(), 0.25), std::pow(furthest(), 0.25)};
    std::ranges::sort(ends);
    PairRates all;
    for (std::size_t k = 1; k < ends.size(); ++k) all = all + between(ends[k - 1], ends[k]);
    return all;
  }
  PairRates between(double from, double to) const {
    const int panels = static_cast<int>(std::ceil((to - from) / 0.7));
    PairRates all;
    for (int k = 0; k < panels; ++k)
      all = all + panel(from + (to - from) * k / panels, from + (to - from) * (k + 1) / panels);
    return all;
  }
  PairRates panel(double from, double to) const {
    using Gauss = boost::math::quadrature::gauss<double, 10>;
    const double middle = (from + to) / 2, half = (to - from) / 2;
    PairRates all;
    for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k)
      for (const double side : {-1.0, 1.0}) {
        const double r = middle + side * half * Gauss::abscissa()[k];
        all = all + at(std::pow(r, 4)) * (4 * std::pow(r, 3) * half * Gauss::weights()[k]);
      }
    return all;
  }
};

/// Points and weights for the mean of a function h of b = 2 B w over charges, (4/pi) int K_0(2w) h dw. The trapezoidal
/// rule in t, w = exp(t - exp(-t)), suits the logarithm at 0 and exp(-2w).
struct ChargePoint {
  double w = 0, weight = 0;
};
std::vector<ChargePoint> charge_points() {
  const double step = 0.15, first = -3.6, last = 3.4;
  std::vector<ChargePoint> points;
  for (double t = first; t < last; t += step) {
    const double w = std::exp(t - std::exp(-t));
    points.push_back({w, 4 / pi * boost::math::cyl_bessel_k(0, 2 * w) * w * (1 + std::exp(-t)) * step});
  }
  return points;
}

/// Returns the rates of grains that repel each other, with b = 0.
PairRates repulsive_rates(double heat, const Impacts& impacts) { return Attraction{impacts, heat, 0}.sum(); }

}  // namespace

KineticRates contact_speed_rates(const Aggregates& gas, double coupling, const Impacts& impacts) {
  static const std::vector<ChargePoint> points = charge_points();
  const double bjerrum = gas.bjerrum(coupling), heat = gas.temperature / gas.mass;
  const PairRates without_charge = repulsive_rates(heat, impacts);
  PairRates mean;
  double charge = 0;  // each coalescence removes 2 |q_i q_j| / <q^2> = 4 w
  for (const auto& [w, weight] : points) {
    const double b = 2 * bjerrum * w;
    const PairRates attracted = Attraction{impacts, heat, b}.sum() * (weight / 2);
    mean = mean + attracted + without_charge * (weight / 2 * std::exp(-b));
    charge += 4 * w * attracted.mergers;
  }
  const double before = encounter_rate(gas);
  return {.mergers = before * mean.mergers,
          .contact_loss = before * gas.temperature * mean.contact_loss,
          .merging_loss = before * gas.temperature * mean.merging_loss,
          .contact_charge = before * mean.contact_charge,
          .merging_charge = before * gas.charge_square * charge};
}

}  // namespace lichtenberg::theory
