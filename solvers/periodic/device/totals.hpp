#pragma once

// Sums over all charges.

#include "solvers/parallel/host_executor.hpp"
#include "solvers/periodic/device/near.hpp"

namespace lichtenberg::periodic::device {

/// Sums over all sources on a device. Terms are multiples of 2^-26, so that sums up to 2^27 are exact and do not depend
/// on the order.
struct Totals {
  double x = 0, y = 0, z = 0;  ///< Sum of charge times field, or of the forces with dipoles
  /// Sum of the squared charges; with dipoles, of the sources' weights for the correction of the net force
  double square = 0;
  double charge = 0;  ///< Sum of the charges
  double energy = 0;  ///< Energy: half of charge times potential, without the background

  LICHTENBERG_HOST_DEVICE Totals& operator+=(const Totals& t) {
    x += t.x, y += t.y, z += t.z, square += t.square, charge += t.charge, energy += t.energy;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE Totals operator+(Totals a, const Totals& b) { return a += b; }
  /// Adds other sums to these by atomic additions, so that many threads may do so at once.
  LICHTENBERG_HOST_DEVICE void add(const Totals& t) {
    parallel::add_atomically(&x, t.x), parallel::add_atomically(&y, t.y), parallel::add_atomically(&z, t.z);
    parallel::add_atomically(&square, t.square), parallel::add_atomically(&charge, t.charge);
    parallel::add_atomically(&energy, t.energy);
  }
};

/// Number that rounds another to a multiple of 2^-26 when it is added and subtracted.
constexpr double fine_grid = 0x1.8p26;
/// Number that rounds energies of many charges of one sign without a background to multiples of 2^-18. Their sums are
/// exact up to 2^35.
constexpr double grid_of_large_energies = 0x1.8p34;

/// Rounds a number to a multiple of 2^-26, or of the quantum of another grid.
LICHTENBERG_HOST_DEVICE inline double on_fine_grid(double value, double grid = fine_grid) {
  return (value + grid) - grid;
}

/// Returns the terms of a charge in Totals, for the field and potential at the charge. `grid`: of energies.
LICHTENBERG_HOST_DEVICE inline Totals terms_of(const PointCharge& charge, const FieldSample& f, double grid) {
  const double q = charge.charge;
  return {on_fine_grid(q * f.x), on_fine_grid(q * f.y), on_fine_grid(q * f.z),
          on_fine_grid(q * q),   on_fine_grid(q),       on_fine_grid(0.5 * q * f.potential, grid)};
}

/// Returns the terms of a charge with a dipole in Totals, for the field and force at the source. Stores the source's
/// weight for the correction of the net force in force.potential. For the weight, the dipole counts as two charges 1 /
/// sqrt(inverse_separation2) apart (../mesh.cpp).
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
