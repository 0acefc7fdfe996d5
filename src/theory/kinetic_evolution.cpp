#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"
#include "src/theory/kinetic.hpp"

namespace lichtenberg::theory {
namespace {

Aggregates aggregates(const KineticGas& gas, double density, double temperature, double charge_square) {
  const double mass = gas.density / density;
  return {density, temperature, charge_square, mass, std::pow(mass, 1 / gas.fractal_dimension)};
}

/// Returns the common factor of all rates.
double frequency_factor(const KineticGas& gas, const Aggregates& now) {
  if (!gas.impacts.duration) return gas.contact_value;
  const double heat = now.temperature / now.mass;
  const double frequency =
      4 * now.density * now.diameter * now.diameter * gas.contact_value * std::sqrt(std::numbers::pi * heat);
  return gas.contact_value / (1 + frequency * gas.impacts.duration(heat));
}

KineticRates rates_of(const KineticGas& gas, const ImpactMeans& means, const Aggregates& now) {
  if (gas.speeds_at_contact) return contact_speed_rates(now, gas.coupling, gas.impacts);
  KineticRates rates = kinetic_rates(now, gas.coupling, means);
  if (!gas.merges) rates.mergers = rates.merging_loss = rates.merging_charge = 0;
  return rates;
}

/// Returns the equations of ln n, ln T and <q^2>; logarithms, because n and T decay by powers.
Ode kinetic_ode(const KineticGas& gas, const ImpactMeans& means) {
  const auto rates = [&gas, &means](double, std::span<const double> y, std::span<double> rate) {
    const Aggregates now = aggregates(gas, std::exp(y[0]), std::exp(y[1]), std::max(y[2], 0.0));
    const KineticRates r = rates_of(gas, means, now);
    const double factor = frequency_factor(gas, now) / now.density;
    rate[0] = -factor * r.mergers;
    rate[1] = factor * (r.mergers - 2.0 / 3 * (r.contact_loss + r.merging_loss) / now.temperature);
    rate[2] = factor * (r.contact_charge - r.merging_charge + now.charge_square * r.mergers);
  };
  // The rates of `contact_speed_rates` are only smooth to this accuracy.
  const double relative = gas.speeds_at_contact ? 1e-6 : 1e-10;
  return {.rates = rates, .absolute = {relative, relative, 1e-30}, .relative = relative};
}

/// Integrates the equations. Charges may grow so fast that quadratures and time steps give no number.
std::vector<std::vector<double>> followed(const Ode& ode, const std::vector<double>& start,
                                          std::span<const double> times) {
  try {
    return integrate(ode, 0, start, times);
  } catch (const std::runtime_error&) {
    throw Failure(
        "theory: kinetic theory has no course of a gas that charges so fast; with a smaller strength or exponent of "
        "effects.charge_exchange, or a smaller effects.coulomb.coupling_constant, it has one");
  }
}

}  // namespace

std::vector<KineticState> kinetic_evolution(const KineticGas& gas, std::span<const double> times) {
  const ImpactMeans means = gas.speeds_at_contact ? ImpactMeans{} : tabulated_means(gas.impacts, gas.temperature);
  const std::vector<double> start = {std::log(gas.density), std::log(gas.temperature), 0};
  std::vector<KineticState> states;
  for (const auto& y : followed(kinetic_ode(gas, means), start, times)) {
    const Aggregates then = aggregates(gas, std::exp(y[0]), std::exp(y[1]), y[2]);
    states.push_back({then.density, then.temperature, then.charge_square, then.bjerrum(gas.coupling)});
  }
  return states;
}

}  // namespace lichtenberg::theory
