#pragma once

#include <cmath>
#include <numbers>

#include "solvers/geometry/host_device.hpp"
#include "solvers/random.hpp"

namespace lichtenberg::effects {

// Charge dq that a contact of grains i and j transfers, q_i += dq and q_j -= dq, by three models (G table 3.1), in
// reduced units. Each is proportional to its strength Q, and both signs are equally likely.

/// White noise during contact: dq = Q sqrt(rate dt) w, w Gaussian of variance 1 (G 3.45, 3.46). Two random words.
struct RandomWalkExchange {
  double strength = 0;  ///< Q
  double rate = 0;      ///< lambda

  LICHTENBERG_HOST_DEVICE double operator()(double dt, Random& random) const {
    return strength * std::sqrt(rate * dt) * random.normal();
  }
};

/// One transfer in each collision: dq = +-Q (Psi_1 m_eff v^2)^(eta + Psi_2). v is the normal speed at contact onset,
/// and m_eff = 1/2 for two grains of mass 1. Psi_1 is uniform in [.1, 10^(1/2)], Psi_2 in +-.05 eta (G 4.3, whose
/// interval for Psi_2 is shifted by eta). Three random words: sign, Psi_1, Psi_2.
struct ImpactExchange {
  double strength = 0;  ///< Q
  double exponent = 0;  ///< eta

  LICHTENBERG_HOST_DEVICE double operator()(double effective_mass, double speed, Random& random) const {
    const double signed_strength = random.sign() * strength;
    const double first = random.uniform(0.1, std::sqrt(10.0)), second = random.uniform(-0.05, 0.05) * exponent;
    return signed_strength * std::pow(first * effective_mass * speed * speed, exponent + second);
  }
};

/// White noise times the area of the contact: dq = Q a sqrt(rate dt) w (G 3.50, 3.51). Two random words.
struct ContactAreaExchange {
  double strength = 0;  ///< Q
  double rate = 0;      ///< lambda

  LICHTENBERG_HOST_DEVICE double operator()(double area, double dt, Random& random) const {
    return strength * area * std::sqrt(rate * dt) * random.normal();
  }
};

/// Returns the area of the circle in which two spheres intersect, pi (xi/2) (d0 - xi/2) for equal spheres (3.51 prints
/// xi for xi/2). It uses Heron's formula, whose factors have no cancellation. Requires overlap >= 0 and neither sphere
/// inside the other.
LICHTENBERG_HOST_DEVICE inline double contact_area(double radius_i, double radius_j, double overlap) {
  const double distance = radius_i + radius_j - overlap, radius_difference = radius_i - radius_j;
  return std::numbers::pi * (radius_i + radius_j + distance) * overlap * (distance + radius_difference) *
         (distance - radius_difference) / (4 * distance * distance);
}

/// Returns the quantum of transfers of strength Q, 2^(floor(log2 Q) - 30). Sums of charges up to 2^22 Q are then exact
/// in double precision, in any order, and a neutral gas remains exactly neutral.
LICHTENBERG_HOST_DEVICE inline double charge_quantum(double strength) {
  return std::ldexp(1.0, std::ilogb(strength) - 30);
}

/// Returns dq rounded to a multiple of the quantum, a power of two.
LICHTENBERG_HOST_DEVICE inline double whole_quanta(double dq, double quantum) {
  return quantum * std::nearbyint(dq / quantum);
}

/// Action for a transfer that would charge a grain beyond its capacity.
enum class OverCapacity {
  refuse,  ///< the transfer is omitted
  reset,   ///< the transfer occurs, and the grain loses all its charge (G 3.47): charge is not conserved
};

struct ExchangedCharges {
  double i = 0, j = 0;
  double lost = 0;  ///< charge removed from both grains
};

/// Returns the charges of two grains after the transfer dq from j to i. An infinite capacity is no limit.
LICHTENBERG_HOST_DEVICE inline ExchangedCharges exchange_charges(double charge_i, double charge_j, double dq,
                                                                 double capacity, OverCapacity over) {
  const double i = charge_i + dq, j = charge_j - dq;
  const bool over_i = std::abs(i) > capacity, over_j = std::abs(j) > capacity;
  if (!over_i && !over_j) return {i, j};
  if (over == OverCapacity::refuse) return {charge_i, charge_j};
  return {over_i ? 0 : i, over_j ? 0 : j, (over_i ? i : 0) + (over_j ? j : 0)};
}

}  // namespace lichtenberg::effects
