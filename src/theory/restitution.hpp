#pragma once

#include <cmath>
#include <vector>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::theory {

/// A head-on collision of two viscoelastic grains in its own units. The overlap s obeys s'' = -max(s^(3/2) + k sqrt(s)
/// s', 0), s(0) = 0, s'(0) = 1, with the dimensionless damping k. All such collisions depend only on k.
struct UniversalCollision {
  double loss = 0;      ///< (1 - restitution coefficient) / k, which has a limit at k = 0
  double duration = 0;  ///< time until the force is zero
  double deepest = 0;   ///< largest s
};

/// Integrates the equation of the head-on collision with damping k >= 0 by CVODE: restitution and depth to 1e-12,
/// duration to 1e-9.
UniversalCollision universal_collision(double k);

/// Returns the limit of (1 - restitution coefficient) / k for damping k -> 0, which is (4/5) (5/4)^(3/5) B(3/5, 3/2) =
/// 1.153449... with the beta function B (Schwager and Poeschel 1998; G 5.31).
double first_loss();

/// Table of head-on collisions of viscoelastic grains for the dimensionless damping 0 <= k <= `largest`. Interpolated
/// `loss` and `deepest` are within 1e-11 of universal_collision(), `duration` is within 1e-9. All three have series in
/// sqrt(k) (Schwager and Poeschel 2008), so polynomials through Chebyshev points of u = sqrt(k) / (1 + sqrt(k))
/// converge.
class RestitutionCurve {
 public:
  RestitutionCurve();
  static constexpr double largest = 100;

  /// Returns the collision with the dimensionless damping k, interpolated in the table. Throws InputError unless 0 <= k
  /// <= largest.
  UniversalCollision operator()(double k) const;

  /// Returns the interpolation points u in ascending order; losses() returns `loss` there, both for between_nodes().
  const std::vector<double>& points() const { return node_; }
  std::vector<double> losses() const;

 private:
  std::vector<double> node_;
  std::vector<UniversalCollision> collision_;
};

/// Returns the table of head-on collisions, which is made at first use and shared.
const RestitutionCurve& restitution_curve();

/// Computes the restitution coefficient for the dimensionless damping k by a Pade approximant in sqrt(k), within .01 of
/// RestitutionCurve (Mueller and Poeschel 2011).
double pade_restitution(double k);

/// Parameters of the viscoelastic contact of two grains, in reduced units. The contact force is max(E xi^(3/2) + D
/// sqrt(xi) xi', 0), where xi is the overlap.
struct ViscoelasticPair {
  double elastic = 0;           ///< E
  double dissipative = 0;       ///< D
  double effective_mass = 0.5;  ///< m_i m_j / (m_i + m_j)
};

/// Result of a head-on collision of two grains: restitution coefficient, duration and largest overlap, in reduced
/// units.
struct PairCollision {
  double restitution = 0;  ///< speed after over speed before
  double duration = 0;     ///< duration of the force
  double overlap = 0;      ///< largest overlap
};

/// Computes the dimensionless damping of a collision, k = (D/E) (E/m_eff)^(2/5) v^(1/5), with the impact speed v > 0.
LICHTENBERG_HOST_DEVICE inline double dissipation_number(const ViscoelasticPair& pair, double speed) {
  return pair.dissipative / pair.elastic * std::pow(pair.elastic / pair.effective_mass, 0.4) * std::pow(speed, 0.2);
}

/// Computes the head-on collision of two viscoelastic grains at this impact speed, from RestitutionCurve. Throws
/// InputError if the damping k exceeds the table.
PairCollision collision(const ViscoelasticPair& pair, double speed);

/// Computes the smallest impact speed at which undamped grains of diameter 1 pass through each other: (5 m_eff v^2 / (4
/// E))^(2/5) = 1.
double piercing_speed(const ViscoelasticPair& pair);

}  // namespace lichtenberg::theory
