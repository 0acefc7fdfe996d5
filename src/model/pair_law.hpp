#pragma once

#include <concepts>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Input of a pair force law: distance, radii and charges of two particles, in SI or the reduced units of grains.
struct PairGeometry {
  double distance = 0;                ///< distance between the centres (m)
  double reach = 0;                   ///< cutoff of the law for this pair, a distance between centres (m)
  double radius_i = 0, radius_j = 0;  ///< m
  double charge_i = 0, charge_j = 0;  ///< C, or q0 for grains; 0 unless the law is `charged`
};

/// Result of a pair force law at one distance: energy, force and stiffness.
struct PairForce {
  double energy = 0;     ///< energy of the pair, in multiples of the law's energy_unit()
  double force = 0;      ///< N, repulsive; N/m (force over distance) if the law is `over_distance`
  double stiffness = 0;  ///< N/m, minus the derivative of the force (N) by the distance
};

/// True for a pair force law: a small struct with parameters and
///
/// ```
///     static constexpr bool over_distance  // true: PairForce::force is force over distance
///     static constexpr bool charged        // true: it uses PairGeometry::charge_i and charge_j
///     double reach(double radius_i, double radius_j) const
///     double energy_unit() const           // J
///     PairForce operator()(const PairGeometry&) const
/// ```
///
/// and, optionally,
///
/// ```
///     PairForce quick(const PairGeometry&) const  // operator() without branches, where quick_holds() is true
///     bool quick_holds(const PairGeometry&) const
///     bool refuses(const PairGeometry&) const     // the law is not valid for such a pair
/// ```
///
/// for the host and for a device. The loops over pairs that take a law are in pair_loop.hpp and pair_part.hpp.
template <class Law>
concept PairLaw = requires(const Law& law, const PairGeometry& pair) {
  { Law::over_distance } -> std::convertible_to<bool>;
  { Law::charged } -> std::convertible_to<bool>;
  { law.reach(1.0, 1.0) } -> std::convertible_to<double>;
  { law.energy_unit() } -> std::convertible_to<double>;
  { law(pair) } -> std::same_as<PairForce>;
};
/// True for a pair force law with the optional functions quick() and quick_holds().
template <class Law>
concept HasQuick = requires(const Law& law, const PairGeometry& geometry) {
  law.quick(geometry), law.quick_holds(geometry);
};
/// True for a pair force law with a function refuses(), which returns true for pairs for which the law is not valid.
template <class Law>
concept CanRefuse = requires(const Law& law, const PairGeometry& geometry) {
  law.refuses(geometry);
};

/// Returns the pair force divided by the distance of the centres (N/m). `law`: result of a law of type Law; if
/// Law::over_distance, its force is already divided.
template <class Law>
LICHTENBERG_HOST_DEVICE double over_distance(const PairForce& law, double distance) {
  return Law::over_distance ? law.force : law.force / distance;
}

}  // namespace lichtenberg
