#include "src/theory/haff.hpp"

#include <fmt/format.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

double cooling_rate(const Impacts& impacts, double temperature) {
  return impact_mean(temperature,
                     [&](double speed, double x) {
                       const double restitution = impacts.restitution(speed);
                       return x * (1 - restitution * restitution);
                     }) /
         3;
}

double charging_rate(const Impacts& impacts, double temperature) {
  return impact_mean(temperature, [&](double speed, double) { return impacts.charge_square(speed); });
}

/// ln T, <q^2> and collisions, over time: a temperature falls by powers.
Ode cooling_ode(double density, const Impacts& impacts) {
  const auto rates = [&impacts, density](double, std::span<const double> y, std::span<double> rate) {
    const double temperature = std::exp(y[0]);
    double frequency = collision_frequency(density, temperature);
    if (impacts.duration) frequency /= 1 + frequency * impacts.duration(temperature);
    rate[0] = -frequency * cooling_rate(impacts, temperature);
    rate[1] = impacts.charge_square ? frequency * charging_rate(impacts, temperature) : 0;
    rate[2] = frequency;
  };
  return {.rates = rates, .absolute = {1e-11, 1e-30, 1e-11}, .relative = 1e-11};
}

}  // namespace

double contact_value(double density) {
  const double filled = pi * density / 6;
  return (1 - filled / 2) / std::pow(1 - filled, 3);
}

double collision_frequency(double density, double temperature) {
  return 4 * density * contact_value(density) * std::sqrt(pi * temperature);
}

double haff_time(double density, double temperature, double restitution, double sonine) {
  return 6 / (collision_frequency(density, temperature) * (1 - restitution * restitution) * (1 + 3 * sonine / 16));
}

double haff_temperature(double initial, double tau, double time) {
  return initial / ((1 + time / tau) * (1 + time / tau));
}

/// Restitution has a series in v^(1/10), which this quadrature does not mind.
double impact_mean(double temperature, const std::function<double(double speed, double x)>& f) {
  static boost::math::quadrature::exp_sinh<double> quadrature;
  const double fast = 700;  // exp(-x) is nothing beyond
  const double thermal = 2 * std::sqrt(temperature);
  try {
    return quadrature.integrate([&](double x) { return x < fast ? std::exp(-x) * f(thermal * std::sqrt(x), x) : 0.0; },
                                0.0, std::numeric_limits<double>::infinity(), 1e-13);
  } catch (const std::runtime_error&) {  // boost's, of what is no number
    throw Failure(
        fmt::format("theory: what impacts do on average at the temperature {:g} is no number; grains that are "
                    "less stiff, less charged or less warm have one",
                    temperature));
  }
}

std::vector<CoolingState> cool(double density, const Impacts& impacts, double initial, std::span<const double> times) {
  std::vector<CoolingState> states;
  for (const auto& y : integrate(cooling_ode(density, impacts), 0, {std::log(initial), 0, 0}, times))
    states.push_back({std::exp(y[0]), y[1], y[2]});
  return states;
}

double mean_charge(double charge_square) { return std::sqrt(2 * charge_square / pi); }

double impact_charge_square(double strength, double exponent, double effective_mass, double speed) {
  const double low = 0.1, high = std::sqrt(10.0), half_width = 0.05 * exponent;
  const double energy = effective_mass * speed * speed;
  const auto mean_over_first = [&](double second) {
    const double power = 2 * (exponent + second);
    return std::pow(energy, power) * (std::pow(high, power + 1) - std::pow(low, power + 1)) /
           ((power + 1) * (high - low));
  };
  const double sum = boost::math::quadrature::gauss<double, 7>::integrate(mean_over_first, -half_width, half_width);
  return strength * strength * sum / (2 * half_width);
}

}  // namespace lichtenberg::theory
