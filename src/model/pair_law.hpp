#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Input of a pair force law: geometry and charges of two particles.
struct PairGeometry {
  double distance = 0;                ///< m, between the centres
  double reach = 0;                   ///< m, cutoff distance of the law
  double radius_i = 0, radius_j = 0;  ///< m
  double charge_i = 0, charge_j = 0;  ///< C, q0 for grains; 0 unless the law is `charged`
};

struct PairForce {
  double energy = 0;     ///< energy of the pair, in the law's units
  double force = 0;      ///< N, repulsive; N/m (force over distance) if the law is `over_distance`
  double stiffness = 0;  ///< N/m, minus the derivative of the force (N) by the distance
};

/// A law is a small struct with parameters and
///
/// ```
///     static constexpr bool over_distance  // true: PairForce::force is force over distance
///     double reach(double radius_i, double radius_j) const
///     double energy_unit() const           // J
///     PairForce operator()(const PairGeometry&) const
/// ```
///
/// and, optionally,
///
/// ```
///     static constexpr bool charged = true    // it uses PairGeometry::charge_i and charge_j
///     PairForce quick(const PairGeometry&) const  // operator() without branches, where quick_holds() is true
///     bool quick_holds(const PairGeometry&) const
///     bool refuses(const PairGeometry&) const     // the law is not valid for such a pair
/// ```
///
/// all for the host and for a device. The loops that take a law are in pair_loop.hpp and pair_part.hpp.
template <class Law>
concept HasQuick = requires(const Law& law, const PairGeometry& geometry) {
  law.quick(geometry), law.quick_holds(geometry);
};
template <class Law>
concept NeedsCharges = requires {
  requires Law::charged;
};
template <class Law>
concept CanRefuse = requires(const Law& law, const PairGeometry& geometry) {
  law.refuses(geometry);
};

/// Returns the force over the distance (N/m).
template <class Law>
LICHTENBERG_HOST_DEVICE double over_distance(const PairForce& law, double distance) {
  return Law::over_distance ? law.force : law.force / distance;
}

}  // namespace lichtenberg
