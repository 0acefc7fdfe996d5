#pragma once

namespace lichtenberg::theory {

/// Model of the head-on motion of two charged grains of diameter 1, in free space and reduced units: m_eff r'' =
/// F_contact + c / r^2 with the distance r of the centres and c = K q_1 q_2. In contact, with the overlap xi = 1 - r >
/// 0,
///
///   F_contact = max(E xi^p + D xi^(p-1) xi', 0).
///
/// p = 3/2 describes viscoelastic spheres, p = 1 a linear spring.
struct TwoGrains {
  double elastic = 0;           ///< E; for a linear spring A
  double dissipative = 0;       ///< D; for a linear spring B
  double coulomb = 0;           ///< c, negative for attraction
  double exponent = 1.5;        ///< p
  double effective_mass = 0.5;  ///< m_1 m_2 / (m_1 + m_2)
};

/// Results of one contact, from onset until r = 1 again or, if it never opens, until the pair is at rest.
struct PairContact {
  bool opens = false;     ///< true if the grains separate
  double release = 0;     ///< speed at r = 1
  double duration = 0;    ///< time until r = 1 or rest
  double force_ends = 0;  ///< time at which the contact force is zero for good; 0 if it never is
  double deepest = 0;     ///< largest xi
  double dissipated = 0;  ///< dissipated energy
};

/// Integrates one contact with the given impact speed by CVODE, to 1e-11. From onset the independent variable is
/// sqrt(t), in which the motion is smooth. Events are the end and the return of the contact force and the separation of
/// the pair. The pair counts as at rest if its energy above the energy at rest is 1e-10 of its value at impact. Throws
/// Failure if the centres meet.
PairContact contact(const TwoGrains& pair, double impact);

/// Results of all contacts of a pair.
struct PairOutcome {
  bool captured = false;  ///< true: permanently bound
  int contacts = 0;       ///< number of contacts until it escapes or stays in contact
  double last = 0;        ///< speed at r = 1 of its last release; 0 without a release
  double dissipated = 0;  ///< energy dissipated by all contacts
};

/// Integrates all contacts of a pair with the given speed of the first impact. Between contacts energy is conserved, so
/// a bound pair returns at its release speed. A pair that is bound without dissipation is integrated for one contact
/// only. Throws the exceptions of contact().
PairOutcome outcome(const TwoGrains& pair, double impact);

/// Computes the escape speed: the smallest relative speed at r = 1 with which an attracting pair escapes, sqrt(-2 c /
/// m_eff); 0 without attraction.
double escape_speed(const TwoGrains& pair);

/// Computes the overlap xi of an attracting pair at rest: the smaller solution of E xi^p = -c / (1 - xi)^2; 0 without
/// attraction. Throws InputError if the contact is too soft for equilibrium.
double static_overlap(const TwoGrains& pair);

/// Computes the energy of a pair at rest in contact: contact energy plus Coulomb energy, which is 0 at infinity.
double static_energy(const TwoGrains& pair);

/// Computes the capture speed, to 1e-10: the impact speed above which an attracting pair escapes after one contact, and
/// below which it is bound.
double capture_speed(const TwoGrains& pair);

}  // namespace lichtenberg::theory
