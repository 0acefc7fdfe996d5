#include "src/theory/haff.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"
#include "src/theory/chebyshev.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

double mean_loss(const Impacts& impacts, double temperature) {
  return impact_mean(temperature, [&](double speed, double x) {
    const double restitution = impacts.restitution(speed);
    return x * (1 - restitution * restitution);
  });
}

double mean_charge_square(const Impacts& impacts, double temperature) {
  if (!impacts.charge_square) return 0;
  return impact_mean(temperature, [&](double speed, double) { return impacts.charge_square(speed); });
}

double mean_duration(const Impacts& impacts, double temperature) {
  return impacts.duration ? impacts.duration(temperature) : 0;
}

/// Returns the equations of ln T, <q^2> and collisions; ln T, because temperature decays by powers. `loss`,
/// `charge_square`, `duration`: means at a temperature.
template <class Loss, class ChargeSquare, class Duration>
Ode cooling_ode(double density, Loss loss, ChargeSquare charge_square, Duration duration) {
  const auto rates = [=](double, std::span<const double> y, std::span<double> rate) {
    const double temperature = std::exp(y[0]);
    double frequency = collision_frequency(density, temperature);
    frequency /= 1 + frequency * duration(temperature);
    rate[0] = -frequency * loss(temperature) / 3;
    rate[1] = frequency * charge_square(temperature);
    rate[2] = frequency;
  };
  return {.rates = rates, .absolute = {1e-11, 1e-30, 1e-11}, .relative = 1e-11};
}

std::vector<CoolingState> states_at(const Ode& ode, double initial, std::span<const double> times) {
  std::vector<CoolingState> states;
  for (const auto& y : integrate(ode, 0, {std::log(initial), 0, 0}, times))
    states.push_back({std::exp(y[0]), y[1], y[2]});
  return states;
}

constexpr int interval_nodes = 20;
constexpr double interval_width = 2;  // interval of ln T

/// Positions of the Chebyshev nodes within an interval, from -1 to 1.
const std::array<double, interval_nodes> node_of = [] {
  std::array<double, interval_nodes> all{};
  for (int n = 0; n < interval_nodes; ++n) all[n] = -std::cos(pi * n / (interval_nodes - 1));
  return all;
}();

double between(const std::array<double, interval_nodes>& values, double log_temperature) {
  const double part = log_temperature / interval_width, x = 2 * (part - std::floor(part)) - 1;
  return between_nodes(node_of.data(), values.data(), interval_nodes, x);
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

/// Integrates by the exp-sinh quadrature, which tolerates the series of the restitution coefficient in v^(1/10).
double impact_mean(double temperature, const std::function<double(double speed, double x)>& f) {
  static boost::math::quadrature::exp_sinh<double> quadrature;
  const double fast = 700;  // exp(-x) is negligible beyond
  const double thermal = 2 * std::sqrt(temperature);
  try {
    return quadrature.integrate([&](double x) { return x < fast ? std::exp(-x) * f(thermal * std::sqrt(x), x) : 0.0; },
                                0.0, std::numeric_limits<double>::infinity(), 1e-13);
  } catch (const std::runtime_error&) {  // boost's exception for a result that is not a number
    throw Failure(
        fmt::format("theory: the mean over impacts at the temperature {:g} is not finite: reduce the stiffness, charge "
                    "or temperature of the grains",
                    temperature));
  }
}

/// Values of the three means at Chebyshev points of one interval of ln T. They vary like powers of T up to 2, and
/// restitution has features with a width of several units of ln T. Twenty points in two units are therefore sufficient.
struct ImpactTable::TableInterval {
  std::array<double, interval_nodes> lost{}, charge_square{}, duration{};
};

const ImpactTable::TableInterval& ImpactTable::interval_at(double log_temperature) const {
  const int number = static_cast<int>(std::floor(log_temperature / interval_width));
  std::shared_ptr<const TableInterval>& found = intervals_[number];
  if (found) return *found;
  auto interval = std::make_shared<TableInterval>();
  for (int n = 0; n < interval_nodes; ++n) {
    const double temperature = std::exp(interval_width * (number + 0.5 * (1 + node_of[n])));
    interval->lost[n] = mean_loss(impacts_, temperature);
    interval->charge_square[n] = mean_charge_square(impacts_, temperature);
    interval->duration[n] = mean_duration(impacts_, temperature);
  }
  return *(found = std::move(interval));
}

double ImpactTable::lost(double temperature) const {
  const double at = std::log(temperature);
  return between(interval_at(at).lost, at);
}
double ImpactTable::charge_square(double temperature) const {
  const double at = std::log(temperature);
  return between(interval_at(at).charge_square, at);
}
double ImpactTable::duration(double temperature) const {
  const double at = std::log(temperature);
  return between(interval_at(at).duration, at);
}

std::vector<CoolingState> cool(double density, const Impacts& impacts, double initial, std::span<const double> times) {
  const auto of = [&](auto mean) {
    return [&impacts, mean](double temperature) { return mean(impacts, temperature); };
  };
  return states_at(cooling_ode(density, of(mean_loss), of(mean_charge_square), of(mean_duration)), initial, times);
}

std::vector<CoolingState> cool(double density, const ImpactTable& table, double initial,
                               std::span<const double> times) {
  const auto of = [&](auto mean) { return [&table, mean](double temperature) { return (table.*mean)(temperature); }; };
  const Ode ode =
      cooling_ode(density, of(&ImpactTable::lost), of(&ImpactTable::charge_square), of(&ImpactTable::duration));
  return states_at(ode, initial, times);
}

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
