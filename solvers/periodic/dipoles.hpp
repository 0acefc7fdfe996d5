#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Overwrites `field` ([3 N]) with the field of the dipoles ([3 N]) at each other's places: T mu, T symmetric.
using DipoleField = std::function<void(std::span<const double> dipole, std::span<double> field)>;

/// That field by any way to compute sums. What it is given must outlive it.
DipoleField field_by(Sum& sum, const Sources& places, std::span<const Pair> pairs, parallel::Team& team);

/// Solves mu = A (e + T mu), with A the polarizability (length^3) and e the field of all else ([3 N]), by conjugate
/// gradients until the residual e + T mu - mu/A is at most `tolerance` times e, both as root sums of squares. `dipole`
/// ([3 N]) is the start, 0 for none, and becomes the solution. Returns how often T was applied. Throws InputError if A
/// is negative, or so large that the dipoles' energy is seen to have no minimum (A times T's largest eigenvalue >= 1);
/// Failure if rounding keeps the residual above the tolerance.
int solve_dipoles(const DipoleField& field_of, std::span<const double> field, double polarizability, double tolerance,
                  std::span<double> dipole);

/// The polarizability (length^3) at which N dipoles at their places would grow without end: 1 over T's largest
/// eigenvalue, by Lanczos' method to some 1e-6 of it. It begins in a random direction, so that no symmetry of the
/// places hides an eigenvector. Stops early at a value that is at most `enough`.
double largest_polarizability(const DipoleField& field_of, int n, double enough = 0);

/// What induced dipoles are summed by (README): nearest images closer than half the box (near), or all images
/// (far).
enum class DipoleSum {
  ewald,             ///< all far
  mixed_consistent,  ///< far, but near between dipoles
  minimum_image,     ///< all near
  source             ///< charges polarize far, all else near, as the source does: forces without an energy
};

/// Charges that polarize each other, mu_i = A e_i. The energy, with mu at its minimum, is that of the charges and
///     -sum mu.e_charges - 1/2 mu T mu + sum mu^2 / (2 A)
/// and forces are its slopes at fixed mu, but for DipoleSum::source. Charges act on each other by `far` always.
class InducedDipoles {
 public:
  /// `far` must outlive this object; any Sum that knows dipoles.
  InducedDipoles(Sum& far, DipoleSum variant, double polarizability, double tolerance)
      : far_(far), variant_(variant), polarizability_(polarizability), tolerance_(tolerance) {}

  /// `dipole`: the start (empty: none), then the solution. `charges` without dipoles. `response`: of charges and
  /// dipoles together, the field being the one that polarizes; since the energy is at its minimum in mu, its error is
  /// of the residual's square. Returns how often the dipoles' field was computed on the way. Throws what solve_dipoles
  /// and `far` throw.
  int evaluate(const Sources& charges, std::span<const Pair> pairs, parallel::Team& team, std::vector<double>& dipole,
               Response& response) const;
  /// Throws InputError if dipoles at these places have no stable state, whether the charges excite the growing mode or
  /// symmetry hides it from them and so from `evaluate`. Costs some tens of the dipoles' fields.
  void check_stability(const Sources& places, std::span<const Pair> pairs, parallel::Team& team) const;

 private:
  Sum& far_;
  DipoleSum variant_;
  double polarizability_, tolerance_;
};

/// Where dipoles will be in the next step of equal length, from those of the last ones: Kolafa's always stable
/// predictor (J. Comput. Chem. 25, 335 (2004)), mu = sum_j B_j mu_(-j), B_j = (-1)^(j+1) j C(2n, n - j) / C(2n - 2, n -
/// 1) of n steps: 1; 2, -1; 5/2, -2, 1/2; 14/5, -14/5, 6/5, -1/5. Less exact than the polynomial through them, but what
/// a tolerance leaves in them is not blown up.
class DipolePredictor {
 public:
  /// Uses at most so many steps.
  explicit DipolePredictor(int steps = 4) : steps_(steps) {}

  /// A start for solve_dipoles; empty if nothing is kept.
  std::vector<double> predict() const;
  void keep(std::vector<double> dipole);
  /// In place of the last that was kept, if any: the same step, with other charges.
  void replace(std::vector<double> dipole);

  /// The last step first. Part of a run's state: without it a resumed run differs by the tolerance.
  const std::vector<std::vector<double>>& history() const { return history_; }
  void restore(std::vector<std::vector<double>> history) { history_ = std::move(history); }

 private:
  std::size_t steps_;
  std::vector<std::vector<double>> history_;
};

}  // namespace lichtenberg::periodic
