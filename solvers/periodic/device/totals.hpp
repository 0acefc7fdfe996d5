#pragma once

// Sums over all charges.

#include "solvers/parallel/host_executor.hpp"
#include "solvers/periodic/device/near.hpp"

namespace lichtenberg::periodic::device {

/// Sums over all charges, of terms that are multiples of 2^-26: exact up to 2^27, so that their order does not matter.
struct Totals {
  double x = 0, y = 0, z = 0;  ///< Charge times field, or force with dipoles
  double square = 0;           ///< Squared charges, or strengths with dipoles
  double charge = 0;
  double energy = 0;  ///< Half of charge times potential, without the background

  LICHTENBERG_HOST_DEVICE Totals& operator+=(const Totals& t) {
    x += t.x, y += t.y, z += t.z, square += t.square, charge += t.charge, energy += t.energy;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE Totals operator+(Totals a, const Totals& b) { return a += b; }
  /// Adds atomically.
  LICHTENBERG_HOST_DEVICE void add(const Totals& t) {
    parallel::add_atomically(&x, t.x), parallel::add_atomically(&y, t.y), parallel::add_atomically(&z, t.z);
    parallel::add_atomically(&square, t.square), parallel::add_atomically(&charge, t.charge);
    parallel::add_atomically(&energy, t.energy);
  }
};

LICHTENBERG_HOST_DEVICE inline double on_fine_grid(double value) {
  constexpr double shift = 0x1.8p26;
  return (value + shift) - shift;
}

/// Returns a charge's terms of Totals.
LICHTENBERG_HOST_DEVICE inline Totals terms_of(const PointCharge& charge, const FieldSample& f) {
  const double q = charge.charge;
  return {on_fine_grid(q * f.x), on_fine_grid(q * f.y), on_fine_grid(q * f.z),
          on_fine_grid(q * q),   on_fine_grid(q),       on_fine_grid(0.5 * q * f.potential)};
}

/// Returns the terms of a charge with its dipole, which counts as two charges 1 / sqrt(inverse_separation2) apart
/// (../mesh.cpp). Stores the source's share of the subtracted net force in force.potential.
LICHTENBERG_HOST_DEVICE inline Totals terms_of(const PointCharge& charge, const Moment& m, const FieldSample& f,
                                               FieldSample& force, float inverse_separation2) {
  const double q = charge.charge;
  const float strength = charge.charge * charge.charge + inverse_separation2 * (m.x * m.x + m.y * m.y + m.z * m.z);
  force.potential = strength;
  const double energy = q * f.potential - (static_cast<double>(m.x) * f.x + static_cast<double>(m.y) * f.y +
                                           static_cast<double>(m.z) * f.z);
  return {on_fine_grid(force.x),  on_fine_grid(force.y), on_fine_grid(force.z),
          on_fine_grid(strength), on_fine_grid(q),       on_fine_grid(0.5 * energy)};
}

}  // namespace lichtenberg::periodic::device
