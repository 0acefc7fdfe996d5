#pragma once

#include <vector>

namespace lichtenberg::theory {

/// A head-on collision of two viscoelastic grains in its own units, s'' = -max(s^(3/2) + k sqrt(s) s', 0), s(0) = 0,
/// s'(0) = 1: all of them are one family in k.
struct UniversalCollision {
  double loss = 0;      ///< (1 - restitution) / k, which has a limit at k = 0
  double duration = 0;  ///< until the force is gone
  double deepest = 0;   ///< largest s
};

/// That collision by CVODE: restitution and depth to 1e-12, duration to 1e-9, k >= 0.
UniversalCollision universal_collision(double k);

/// 1.153449...: (1 - restitution) / k at k -> 0, (4/5) (5/4)^(3/5) B(3/5, 3/2) (Schwager and Poeschel 1998; G 5.31).
double first_loss();

/// The family, tabulated for 0 <= k <= `largest`: between, `loss` and `deepest` are within
/// 1e-11 of CVODE's and `duration` is within 1e-9. All have series in
/// sqrt(k) (Schwager and Poeschel 2008), so polynomials through Chebyshev points of u = sqrt(k) / (1 + sqrt(k)) do.
class RestitutionCurve {
 public:
  RestitutionCurve();
  static constexpr double largest = 100;

  /// Throws InputError unless 0 <= k <= largest.
  UniversalCollision operator()(double k) const;

  /// The points u, in ascending order, and `loss` there: what between_nodes wants.
  const std::vector<double>& points() const { return node_; }
  std::vector<double> losses() const;

 private:
  std::vector<double> node_;
  std::vector<UniversalCollision> at_;
};

/// The one curve that there is, made at first use.
const RestitutionCurve& restitution_curve();

/// Restitution within .01 of the curve, in closed form (Mueller and Poeschel 2011, in y = sqrt(k)).
double pade_restitution(double k);

/// Two grains of the contact force max(E xi^(3/2) + D sqrt(xi) xi', 0), xi their overlap, in reduced units.
struct ViscoelasticPair {
  double elastic = 0;           ///< E
  double dissipative = 0;       ///< D
  double effective_mass = 0.5;  ///< m_i m_j / (m_i + m_j)
};

struct PairCollision {
  double restitution = 0;  ///< speed after over speed before
  double duration = 0;     ///< of the force
  double overlap = 0;      ///< the largest
};

/// k = (D/E) (E/m_eff)^(2/5) v^(1/5), v > 0 the speed of impact.
double dissipation_number(const ViscoelasticPair& pair, double speed);

/// Their head-on collision at this speed, from the curve. Throws InputError beyond its end.
PairCollision collision(const ViscoelasticPair& pair, double speed);

/// The speed of impact from which on grains of diameter 1 pass through each other if nothing is dissipated: there
/// (5 m_eff v^2 / (4 E))^(2/5) = 1.
double piercing_speed(const ViscoelasticPair& pair);

}  // namespace lichtenberg::theory
