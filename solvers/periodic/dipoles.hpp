#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Overwrites `field` ([3 N]) with the field of the dipoles ([3 N]) at each other's positions: T mu, T symmetric.
using DipoleField = std::function<void(std::span<const double> dipole, std::span<double> field)>;

/// Makes a DipoleField that uses `sum`. All arguments must outlive it.
DipoleField field_by(Sum& sum, const Sources& sources, std::span<const Pair> pairs, parallel::Team& team);

/// Solves mu = A (e + T mu) by conjugate gradients; A is the polarizability (length^3) and e the external field ([3
/// N]). Stops when the norm of the residual e + T mu - mu/A is at most `tolerance` times that of e. `dipole` ([3 N]) is
/// the initial guess (0 for none) and becomes the solution. Returns the number of applications of T. Throws InputError
/// if A is negative, or if a direction of negative curvature shows that the dipoles' energy has no minimum (A times T's
/// largest eigenvalue >= 1). Throws Failure if rounding keeps the residual above the tolerance.
int solve_dipoles(const DipoleField& field_of, std::span<const double> field, double polarizability, double tolerance,
                  std::span<double> dipole);

/// Polarizability (length^3) at which N dipoles at these positions would grow without bound: 1 over T's largest
/// eigenvalue. Uses Lanczos' method, to about 1e-6 relative. The start vector is random, so that no symmetry of the
/// positions hides an eigenvector. Stops early at a value that is at most `enough`.
double largest_polarizability(const DipoleField& field_of, int n, double enough = 0);

/// Sums used for induced dipoles (docs/numerics/induced-dipoles.md): nearest images closer than half the box (near), or
/// all images (far).
enum class DipoleSum {
  ewald,             ///< All interactions far
  mixed_consistent,  ///< Far, except near between dipoles
  minimum_image,     ///< All interactions near
  source             ///< Charges polarize by far fields, all else is near, as in source G: forces that are not
                     ///< derivatives of an energy
};

/// Charges with induced dipoles, mu_i = A e_i. The energy is that of the charges plus -sum mu.e_charges - 1/2 mu T mu +
/// sum mu^2 / (2 A), at its minimum in mu. Forces are its derivatives at fixed mu, except for DipoleSum::source.
/// Charges always act on each other by `far`.
class InducedDipoles {
 public:
  /// Sets up the model. `far` must outlive this object and must support dipoles.
  InducedDipoles(Sum& far, DipoleSum variant, double polarizability, double tolerance)
      : far_(far), variant_(variant), polarizability_(polarizability), tolerance_(tolerance) {}

  /// Solves for the dipoles and computes the response. `dipole`: initial guess (empty: none), then the solution.
  /// `charges`: without dipoles. `response`: of charges and dipoles together; its field is the polarizing field. The
  /// energy error is of second order in the residual, since the energy is at its minimum in mu. Returns the number of
  /// dipole field evaluations of the solver. Throws the exceptions of solve_dipoles and `far`.
  int evaluate(const Sources& charges, std::span<const Pair> pairs, parallel::Team& team, std::vector<double>& dipole,
               Response& response) const;
  /// Throws InputError if dipoles at these positions have no stable state. It also finds an unstable mode that symmetry
  /// hides from the charges, and so from `evaluate`. Costs some tens of dipole field evaluations.
  void check_stability(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team) const;

 private:
  Sum& far_;
  DipoleSum variant_;
  double polarizability_, tolerance_;
};

/// Predicts the dipoles of the next step of equal length from those of the last n steps. Kolafa's always stable
/// predictor (J. Comput. Chem. 25, 335 (2004)): mu = sum_j B_j mu_(-j), B_j = (-1)^(j+1) j C(2n, n - j) / C(2n - 2, n -
/// 1), so 1; 2, -1; 5/2, -2, 1/2; 14/5, -14/5, 6/5, -1/5. It is less exact than polynomial extrapolation, but does not
/// amplify solver errors.
class DipolePredictor {
 public:
  /// Makes a predictor without history. `steps`: maximum number of earlier steps used.
  explicit DipolePredictor(int steps = 4) : steps_(steps) {}

  /// Returns the initial guess for solve_dipoles; empty without history.
  std::vector<double> predict() const;
  /// Adds the dipoles of a new step to the history.
  void keep(std::vector<double> dipole);
  /// Replaces the last dipoles kept, if any: for a second solution at the same step with other charges.
  void replace(std::vector<double> dipole);

  /// Dipoles of earlier steps, the last one first. Part of a run's state: a resumed run without it differs by the
  /// tolerance.
  const std::vector<std::vector<double>>& history() const { return history_; }
  void restore(std::vector<std::vector<double>> history) { history_ = std::move(history); }

 private:
  std::size_t steps_;
  std::vector<std::vector<double>> history_;
};

}  // namespace lichtenberg::periodic
