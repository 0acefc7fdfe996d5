#pragma once

#include "src/model/effect.hpp"

namespace lichtenberg::effects {

/// F = -gamma v with gamma = 6 pi viscosity R (D 5.8).
class StokesDrag : public Effect {
 public:
  explicit StokesDrag(double viscosity) : viscosity_(viscosity) {}  ///< Pa s

  std::string_view name() const override { return "stokes_drag"; }
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  /// gamma of a sphere (kg/s); radius in m.
  double coefficient(double radius) const;

 private:
  double viscosity_;
};

}  // namespace lichtenberg::effects
