#include "src/effects/stokes_drag.hpp"

#include <numbers>

namespace lichtenberg::effects {

double StokesDrag::coefficient(double radius) const { return 6 * std::numbers::pi * viscosity_ * radius; }

void StokesDrag::add_forces(const State& state, std::span<double> force) const {
  const Bodies& b = state.bodies;
  for (int i = 0; i < b.size(); ++i) {
    const double rate = coefficient(b.radius[i]) / b.mass[i];
    for (int k = i * b.dimension; k < (i + 1) * b.dimension; ++k) force[k] -= rate * b.momentum[k];
  }
}

void StokesDrag::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  const Bodies& b = state.bodies;
  for (int i = 0; i < b.size(); ++i) jacobian.add_drag(i, -coefficient(b.radius[i]) / b.mass[i]);
}

}  // namespace lichtenberg::effects
