#pragma once

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Charge (C/m) of a body and force (N/m) on it, by some of its links or by all. Charge: the sum of its own links'
/// fluxes (D 5.4). Force: virtual work, eps/2 sum over its links of (dV)^2 dc/dx, the closed-form derivative of the
/// energy eps/2 sum c (dV)^2. (The energy itself must not be differenced: it jumps when a cell centre becomes covered.)
struct BodyResult {
  double charge = 0, force_x = 0, force_y = 0;
  LICHTENBERG_HOST_DEVICE BodyResult& operator+=(const BodyResult& other) {
    charge += other.charge;
    force_x += other.force_x;
    force_y += other.force_y;
    return *this;
  }
};

/// What links give bodies, on a grid of cells of size h.
struct LinkResults {
  double permittivity, stress;
  LICHTENBERG_HOST_DEVICE LinkResults(double eps, double h) : permittivity(eps), stress(0.5 * eps / h) {}

  LICHTENBERG_HOST_DEVICE double flux(double conductance, double difference) const {
    return permittivity * conductance * difference;
  }
  /// The force alone. `difference`: of potentials, V; `gradient`: of the conductance, per cell.
  LICHTENBERG_HOST_DEVICE BodyResult force(double difference, Vec2 gradient) const {
    const double pull = stress * difference * difference;
    return {0, pull * gradient.x, pull * gradient.y};
  }
  /// `difference`: from the body's potential to the other one's.
  LICHTENBERG_HOST_DEVICE BodyResult link(double conductance, double difference, Vec2 gradient) const {
    BodyResult result = force(difference, gradient);
    result.charge = flux(conductance, difference);
    return result;
  }
};

/// Hands over the bodies' results; `side_energy`: half of the sides' charges times their potentials (J/m). The
/// solution's group_potential is set already.
void take_results(const LaplaceProblem& problem, const BodyResult* result, double side_energy,
                  LaplaceSolution& solution);

/// Charges, forces and energy of a solved level. `cell` holds the fluid cells' potentials by slot, in units of `scale`
/// (V); the solution's group_potential is set already.
void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::laplace
