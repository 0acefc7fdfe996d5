#pragma once

#include <cmath>
#include <vector>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::theory {

/// A head-on collision of two viscoelastic grains in its own units, s'' = -max(s^(3/2) + k sqrt(s) s', 0), s(0) = 0,
/// s'(0) = 1. All such collisions depend only on k.
struct UniversalCollision {
  double loss = 0;      ///< (1 - restitution) / k, which has a limit at k = 0
  double duration = 0;  ///< time until the force is zero
  double deepest = 0;   ///< largest s
};

/// Integrates that collision by CVODE: restitution and depth to 1e-12, duration to 1e-9, k >= 0.
UniversalCollision universal_collision(double k);

/// Returns 1.153449...: the limit of (1 - restitution) / k for k -> 0, (4/5) (5/4)^(3/5) B(3/5, 3/2) (Schwager and
/// Poeschel 1998; G 5.31).
double first_loss();

/// Table of the collisions for 0 <= k <= `largest`. Interpolated `loss` and `deepest` are within 1e-11 of CVODE's,
/// `duration` is within 1e-9. All three have series in sqrt(k) (Schwager and Poeschel 2008), so polynomials through
/// Chebyshev points of u = sqrt(k) / (1 + sqrt(k)) converge.
class RestitutionCurve {
 public:
  RestitutionCurve();
  static constexpr double largest = 100;

  /// Returns the collision with the dimensionless damping k, interpolated in the table. Throws InputError unless 0 <= k
  /// <= largest.
  UniversalCollision operator()(double k) const;

  /// Points u, in ascending order, and `loss` at these points: the input of between_nodes.
  const std::vector<double>& points() const { return node_; }
  std::vector<double> losses() const;

 private:
  std::vector<double> node_;
  std::vector<UniversalCollision> collision_;
};

/// Returns the shared curve, made at first use.
const RestitutionCurve& restitution_curve();

/// Returns the restitution within .01 of the curve, in closed form (Mueller and Poeschel 2011, in y = sqrt(k)).
double pade_restitution(double k);

/// Two grains with the contact force max(E xi^(3/2) + D sqrt(xi) xi', 0), xi their overlap, in reduced units.
struct ViscoelasticPair {
  double elastic = 0;           ///< E
  double dissipative = 0;       ///< D
  double effective_mass = 0.5;  ///< m_i m_j / (m_i + m_j)
};

struct PairCollision {
  double restitution = 0;  ///< speed after over speed before
  double duration = 0;     ///< duration of the force
  double overlap = 0;      ///< largest overlap
};

/// Returns k = (D/E) (E/m_eff)^(2/5) v^(1/5), v > 0 the impact speed.
LICHTENBERG_HOST_DEVICE inline double dissipation_number(const ViscoelasticPair& pair, double speed) {
  return pair.dissipative / pair.elastic * std::pow(pair.elastic / pair.effective_mass, 0.4) * std::pow(speed, 0.2);
}

/// Returns their head-on collision at this impact speed, from the curve. Throws InputError beyond its end.
PairCollision collision(const ViscoelasticPair& pair, double speed);

/// Returns the smallest impact speed at which undamped grains of diameter 1 pass through each other: (5 m_eff v^2 / (4
/// E))^(2/5) = 1.
double piercing_speed(const ViscoelasticPair& pair);

}  // namespace lichtenberg::theory
