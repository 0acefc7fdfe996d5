#include "src/mechanics/step_control.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::mechanics {
namespace {

/// Returns psi(z) / z of displacement(). Below 0.01 it is the series, because the closed form loses two digits for each
/// decade of z.
double psi_over_z(double z) {
  if (z < 0.01) return 1.0 / 6 - z / 24 + z * z / 120;
  return (0.5 - 1 / z - std::expm1(-z) / (z * z)) / z;
}

}  // namespace

double displacement(double error, double dt, double mass, double drag) {
  return error * dt * dt / mass * psi_over_z(dt * drag / mass);
}

double time_to_displace(double tolerance, double rate, double mass, double drag) {
  if (rate <= 0) return INFINITY;
  return std::max(std::sqrt(2 * drag * tolerance / rate), std::cbrt(6 * mass * tolerance / rate));
}

double time_to_displace_from_rest(double tolerance, double growth, double mass) {
  return growth > 0 ? std::pow(24 * mass * mass * tolerance / growth, 0.25) : INFINITY;
}

double time_to_move(double distance, double speed, double acceleration) {
  if (std::isinf(distance)) return INFINITY;
  return 2 * distance / (speed + std::sqrt(speed * speed + 2 * acceleration * distance));
}

double next_step(double dt, double error, int order) {
  constexpr double margin = 0.9, most_growth = 2, most_shrinkage = 0.2;
  if (error <= 0) return most_growth * dt;
  return dt * std::clamp(margin * std::pow(error, -1.0 / order), most_shrinkage, most_growth);
}

}  // namespace lichtenberg::mechanics
