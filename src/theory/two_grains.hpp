#pragma once

namespace lichtenberg::theory {

/// Two grains of diameter 1 head-on, in free space and reduced units: m_eff r'' = F_contact + c / r^2, r the distance
/// of centres, c = K q_1 q_2. In contact, with xi = 1 - r > 0,
///   F_contact = max(E xi^p + D xi^(p-1) xi', 0):
/// p = 3/2 are viscoelastic spheres, p = 1 is a linear spring.
struct TwoGrains {
  double elastic = 0;           ///< E, of a linear spring A
  double dissipative = 0;       ///< D, of a linear spring B
  double coulomb = 0;           ///< c, negative if they attract
  double exponent = 1.5;        ///< p
  double effective_mass = 0.5;  ///< m_1 m_2 / (m_1 + m_2)
};

/// One contact, from touch until r = 1 again or, if it never opens, until the pair is at rest.
struct PairContact {
  bool opens = false;
  double release = 0;     ///< speed at r = 1
  double duration = 0;    ///< until r = 1 or rest
  double force_ends = 0;  ///< when the contact force is gone for good; 0 if it never is
  double deepest = 0;     ///< largest xi
  double dissipated = 0;  ///< energy
};

/// The contact that begins at this speed, by CVODE to 1e-11: from touch on in sqrt(t), in which it is smooth, and with
/// events where the force is gone, where it comes back, and where the pair parts. At rest means all but 1e-10 of the
/// energy of impact above that of rest is gone. Throws Failure if the centres meet.
PairContact contact(const TwoGrains& pair, double impact);

/// All contacts of a pair that first touches at this speed.
struct PairOutcome {
  bool captured = false;  ///< bound for ever
  int contacts = 0;       ///< until it escapes or stays in contact
  double last = 0;        ///< speed at r = 1 of its last release; 0 if it has none
  double dissipated = 0;  ///< energy, by all contacts
};

/// Between contacts energy is kept, so that a bound pair comes back as fast as it left. A pair that is bound without
/// dissipation is followed for one contact only. Throws as `contact`.
PairOutcome outcome(const TwoGrains& pair, double impact);

/// 2 sqrt(-c) for two grains of mass 1: the speed at r = 1 from which on an attracting pair comes apart.
double escape_speed(const TwoGrains& pair);

/// The overlap at which an attracting pair rests, E xi^p = -c / (1 - xi)^2, the smaller of two; 0 if it does not
/// attract. Throws InputError if the contact is too soft to hold it.
double static_overlap(const TwoGrains& pair);

/// Energy of the pair at rest in contact, contact and Coulomb; at infinity it is 0.
double static_energy(const TwoGrains& pair);

/// The speed of impact above which an attracting pair escapes after one contact and below which it is bound, to 1e-10.
double capture_speed(const TwoGrains& pair);

}  // namespace lichtenberg::theory
