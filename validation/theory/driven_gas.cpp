#include "validation/theory/driven_gas.hpp"

#include <cmath>

namespace lichtenberg::theory {

double driven_temperature(double density, const Impacts& impacts, const RandomDrag& drag) {
  const auto [stokes, speed, hold] = drag;
  const auto balanced = [&](double temperature) {
    const double frequency = collision_frequency(density, temperature);
    const auto restitution = [&](double v) { return impacts.restitution(v); };
    const double turned = impact_mean(temperature, [&](double v, double x) { return x * (1 + restitution(v)); });
    const double lost =
        impact_mean(temperature, [&](double v, double x) { return x * (1 - restitution(v) * restitution(v)); });
    const double lambda = stokes + frequency * turned / 3, y = lambda * hold;
    const double correlation = speed * speed * stokes / lambda * (1 + std::expm1(-y) / y);
    return correlation / (1 + frequency * lost / (6 * stokes));
  };
  double low = 0, high = speed * speed;  // the temperature cannot exceed that of the gas
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (balanced(middle) > middle ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace lichtenberg::theory
