#pragma once

#include <cmath>
#include <numbers>

#include "solvers/geometry/host_device.hpp"
#include "solvers/geometry/vec.hpp"
#include "solvers/random.hpp"

namespace lichtenberg::effects {

// Charge dq that a contact of grains i and j transfers, q_i += dq and q_j -= dq, in reduced units. Each law is
// proportional to its strength Q. In three laws both signs are equally likely (Singh 2019, table 3.1); DirectedExchange
// has the sign of its drive.

/// Charge transfer as white noise during a contact: dq = Q sqrt(rate dt) w for a step dt, w Gaussian of variance 1
/// (Singh 2019, eq. 3.45 and 3.46). Reduced units. Draws two random numbers.
struct RandomWalkExchange {
  double strength = 0;  ///< Q (q0)
  double rate = 0;      ///< lambda (1/t0)

  /// Returns the charge dq (q0) transferred from the second grain to the first in a time dt (t0).
  LICHTENBERG_HOST_DEVICE double operator()(double dt, Random& random) const {
    return strength * std::sqrt(rate * dt) * random.normal();
  }
};

/// One charge transfer in each collision: dq = +-Q (Psi_1 m_eff v^2)^(eta + Psi_2), v the normal speed at contact
/// onset. Psi_1 is uniform in [0.1, sqrt(10)] and Psi_2 in +-0.05 eta (Singh 2019, eq. 4.3, whose interval for Psi_2 is
/// shifted by eta). Reduced units. Draws three random numbers: sign, Psi_1, Psi_2.
struct ImpactExchange {
  double strength = 0;  ///< Q (q0)
  double exponent = 0;  ///< eta

  /// Returns the charge dq (q0) transferred from the second grain to the first. `effective_mass`: m_i m_j / (m_i +
  /// m_j); `speed`: normal speed at onset.
  LICHTENBERG_HOST_DEVICE double operator()(double effective_mass, double speed, Random& random) const {
    const double signed_strength = random.sign() * strength;
    const double first = random.uniform(0.1, std::sqrt(10.0)), second = random.uniform(-0.05, 0.05) * exponent;
    return signed_strength * std::pow(first * effective_mass * speed * speed, exponent + second);
  }
};

/// Charge transfer as white noise times the contact area a: dq = Q a sqrt(rate dt) w for a step dt, w Gaussian of
/// variance 1 (Singh 2019, eq. 3.50 and 3.51). Reduced units. Draws two random numbers.
struct ContactAreaExchange {
  double strength = 0;  ///< Q (q0/d0^2)
  double rate = 0;      ///< lambda (1/t0)

  /// Returns the charge dq (q0) transferred from the second grain to the first in a time dt (t0). `area`: d0^2.
  LICHTENBERG_HOST_DEVICE double operator()(double area, double dt, Random& random) const {
    return strength * area * std::sqrt(rate * dt) * random.normal();
  }
};

/// One charge transfer in each collision with a sign, from a drive that grain i has over grain j:
///
///   dq = Q (m_eff v^2)^eta (drive + feedback (q_i - q_j)) exp(-collisions / memory),
///
/// with the normal speed v at contact onset. Negative feedback ends the transfer at q_i - q_j = -drive / feedback
/// (model of a condenser, Matsusaka 2010). A fast collision reaches this difference at once: Q (m_eff v^2)^eta counts
/// as at most -1 / (2 feedback), beyond which the difference would overshoot, or diverge. With positive feedback
/// charges polarize the contact further, and the difference grows by the factor 1 + 2 Q feedback per collision of unit
/// energy. Siu 2014 has the idea that collisions of polarized grains amplify their charges, but not this formula. The
/// memory describes a finite supply of carriers, which each collision of a grain reduces (Duff and Lacks 2008). Reduced
/// units.
struct DirectedExchange {
  double strength = 0;       ///< Q (q0)
  double exponent = 0;       ///< eta
  double feedback = 0;       ///< 1/q0
  double memory = INFINITY;  ///< number of collisions after which transfers are 1/e

  /// Returns the charge dq (q0) transferred from the second grain to the first. `energy`: m_eff v^2 (m0 v0^2);
  /// `difference`: q_i - q_j (q0); `collisions`: mean number of earlier collisions of both grains.
  LICHTENBERG_HOST_DEVICE double operator()(double energy, double drive, double difference, double collisions) const {
    const double unlimited = strength * std::pow(energy, exponent);
    const double unit = feedback < 0 ? std::fmin(unlimited, -0.5 / feedback) : unlimited;
    return unit * (drive + feedback * difference) * std::exp(-collisions / memory);
  }
};

/// Returns the contact area of two overlapping spheres: the area of the circle in which their surfaces intersect. For
/// equal spheres of diameter d0 it is pi (xi/2) (d0 - xi/2), xi the overlap (Singh 2019, eq. 3.51, prints xi for xi/2).
/// Heron's formula avoids cancellation. Requires overlap >= 0 and neither sphere inside the other.
LICHTENBERG_HOST_DEVICE inline double contact_area(double radius_i, double radius_j, double overlap) {
  const double distance = radius_i + radius_j - overlap, radius_difference = radius_i - radius_j;
  return std::numbers::pi * (radius_i + radius_j + distance) * overlap * (distance + radius_difference) *
         (distance - radius_difference) / (4 * distance * distance);
}

/// Returns the charge quantum of transfers of strength Q: 2^(floor(log2 Q) - 30). All transfers are multiples of it.
/// Sums of transferred charges up to 2^22 Q are then exact in double precision, in any order.
LICHTENBERG_HOST_DEVICE inline double charge_quantum(double strength) {
  return std::ldexp(1.0, std::ilogb(strength) - 30);
}

/// Returns the charge dq rounded to the nearest multiple of the charge quantum, which is a power of two.
LICHTENBERG_HOST_DEVICE inline double whole_quanta(double dq, double quantum) {
  return quantum * std::nearbyint(dq / quantum);
}

/// One transfer in each collision by patches of donors and acceptors (Apodaca et al. 2010). The contact brings n pairs
/// of facing patches together. A patch of grain i is a donor with the probability p_i, otherwise an acceptor. A donor
/// of i that faces an acceptor of j gives dq = Q, the reverse -Q, and equal patches 0. The sum over n pairs has the
/// mean Q n (p_i - p_j) and the variance Q^2 n (s - (p_i - p_j)^2) with s = p_i (1 - p_j) + p_j (1 - p_i). Patches are
/// new in each collision. Reduced units.
struct PatchExchange {
  double strength = 0;  ///< Q (q0), rounded to the charge quantum
  double patches = 0;   ///< mean number of pairs of patches in a contact of unit energy
  double exponent = 0;  ///< eta: the number of pairs is patches (m_eff v^2)^eta, as the contact area

  /// Number of pairs up to which each is drawn; more have the Gaussian limit.
  static constexpr double most_drawn = 256;

  /// Returns the charge dq (q0) transferred from the second grain to the first. `energy`: m_eff v^2 (m0 v0^2);
  /// `donor_i`, `donor_j`: probabilities of donors. Draws at most 257 random numbers.
  LICHTENBERG_HOST_DEVICE double operator()(double energy, double donor_i, double donor_j, Random& random) const {
    const double count = std::floor(patches * std::pow(energy, exponent) + random.uniform());
    return whole_quanta(strength, charge_quantum(strength)) * charged_pairs(count, donor_i, donor_j, random);
  }

 private:
  /// Returns the number of pairs with dq = Q minus that of those with dq = -Q.
  LICHTENBERG_HOST_DEVICE static double charged_pairs(double count, double donor_i, double donor_j, Random& random) {
    const double gain = donor_i * (1 - donor_j), loss = donor_j * (1 - donor_i);
    if (count > most_drawn) {
      const double deviation = std::sqrt(count * (gain + loss - (gain - loss) * (gain - loss)));
      const double sum = std::nearbyint(count * (gain - loss) + deviation * random.normal());
      return std::fmax(-count, std::fmin(sum, count));
    }
    double sum = 0;
    for (double pair = 0; pair < count; ++pair) {
      const double u = random.uniform();
      sum += u < gain ? 1 : u < gain + loss ? -1 : 0;
    }
    return sum;
  }
};

/// Treatment of a charge transfer that would charge a grain beyond its capacity (largest allowed charge).
enum class OverCapacity {
  refuse,  ///< the transfer is omitted
  reset,   ///< the grain loses all its charge after the transfer (Singh 2019, eq. 3.47): charge is not conserved
};

/// Charges of two grains i and j after a transfer.
struct ExchangedCharges {
  double i = 0, j = 0;
  double lost = 0;  ///< charge removed from both grains
};

/// Returns the charges of two grains after the transfer of a charge dq from grain j to grain i. `capacity`: largest
/// magnitude of a grain's charge, INFINITY for no limit; `over`: treatment of a transfer beyond the capacity.
LICHTENBERG_HOST_DEVICE inline ExchangedCharges exchange_charges(double charge_i, double charge_j, double dq,
                                                                 double capacity, OverCapacity over) {
  const double i = charge_i + dq, j = charge_j - dq;
  const bool over_i = std::abs(i) > capacity, over_j = std::abs(j) > capacity;
  if (!over_i && !over_j) return {i, j};
  if (over == OverCapacity::refuse) return {charge_i, charge_j};
  return {over_i ? 0 : i, over_j ? 0 : j, (over_i ? i : 0) + (over_j ? j : 0)};
}

/// Returns the drive by size: (R_i - R_j) / (R_i + R_j). The larger grain becomes positive, as in experiments with one
/// material (Lacks and Levandovsky 2007).
LICHTENBERG_HOST_DEVICE inline double size_drive(double radius_i, double radius_j) {
  return (radius_i - radius_j) / (radius_i + radius_j);
}

/// Two grains i and j that collide, for the transfer of charge. Reduced units.
struct Collision {
  double effective_mass = 0, speed = 0;       ///< m_i m_j / (m_i + m_j), and normal speed at contact onset
  double radius_i = 0, radius_j = 0;          ///< d0
  double affinity_i = 0, affinity_j = 0;      ///< for the drive by material, or probabilities of donors for patches
  Vec3 separation{};                          ///< from the centre of j to that of i (d0), for the drive by a field
  double difference = 0;                      ///< q_i - q_j (q0)
  double collisions_i = 0, collisions_j = 0;  ///< numbers of earlier collisions of the grains
};

/// Cause of the transfer of charge in a collision: none, so that the sign is random (ImpactExchange), a drive of
/// DirectedExchange, or patches (PatchExchange).
enum class ExchangeDrive { random, size, material, field, patches };

/// Charge transfer of the models with one transfer in a collision, on the CPU and on a device. Reduced units.
struct CollisionExchange {
  ExchangeDrive drive = ExchangeDrive::random;
  ImpactExchange impact{};
  DirectedExchange directed{};
  PatchExchange patch{};
  Vec3 field{};                ///< for the drive by a field, in any unit
  double capacity = INFINITY;  ///< largest magnitude of a charge (q0), beyond which transfers are refused

  /// Returns true if a transfer depends on earlier ones, so that the transfers of a grain have an order.
  LICHTENBERG_HOST_DEVICE bool in_order() const { return drive != ExchangeDrive::random || capacity < INFINITY; }
  /// Returns the charge dq (q0) transferred from grain j to grain i, apart from the capacity.
  LICHTENBERG_HOST_DEVICE double operator()(const Collision& of, Random& random) const {
    if (drive == ExchangeDrive::random) return impact(of.effective_mass, of.speed, random);
    const double energy = of.effective_mass * of.speed * of.speed;
    if (drive == ExchangeDrive::patches) return patch(energy, of.affinity_i, of.affinity_j, random);
    return directed(energy, drive_of(of), of.difference, 0.5 * (of.collisions_i + of.collisions_j));
  }

 private:
  LICHTENBERG_HOST_DEVICE double drive_of(const Collision& of) const {
    if (drive == ExchangeDrive::size) return size_drive(of.radius_i, of.radius_j);
    if (drive == ExchangeDrive::material) return of.affinity_i - of.affinity_j;
    return dot(field, of.separation) / norm(of.separation);
  }
};

}  // namespace lichtenberg::effects
