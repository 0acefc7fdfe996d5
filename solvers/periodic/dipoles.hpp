#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Function that applies the dipole interaction tensor T (symmetric): overwrites `field` [3 N] with the field T mu of
/// the dipoles mu [3 N] at each other's positions.
using DipoleField = std::function<void(std::span<const double> dipole, std::span<double> field)>;

/// Makes a DipoleField that computes the field by `sum` at the positions of `sources`. All arguments must outlive it.
DipoleField field_by(Sum& sum, const Sources& sources, std::span<const Pair> pairs, parallel::Team& team);

/// Solves for induced dipoles mu = A (e + T mu) by conjugate gradients, with the polarizability A (length^3). `field`
/// [3 N] is the external field e. T is applied by `field_of`. `dipole` [3 N] is the initial guess (0 for none) and
/// becomes the solution. Stops when the norm of the residual e + T mu - mu/A is at most `tolerance` times that of e.
/// Returns the number of applications of T. Throws InputError if A is negative. Also throws it if a direction of
/// negative curvature shows that the dipoles' energy has no minimum. (A times the largest eigenvalue of T is then at
/// least 1.) Throws Failure if the residual does not reach the tolerance, as for a tolerance below the rounding error.
int solve_dipoles(const DipoleField& field_of, std::span<const double> field, double polarizability, double tolerance,
                  std::span<double> dipole);

/// Computes the critical polarizability (length^3), at which n induced dipoles would grow without bound (polarization
/// catastrophe): 1 over the largest eigenvalue of T, or infinity if no eigenvalue is positive. Lanczos' method computes
/// the eigenvalue, until its relative change in a step is at most 1e-9 or after 200 steps. Its start vector is random,
/// so that no symmetry of the positions hides an eigenvector. If the critical polarizability is found to be at most
/// `enough`, the iteration stops there and returns an upper bound.
double largest_polarizability(const DipoleField& field_of, int n, double enough = 0);

/// Interaction sums for induced dipoles (docs/numerics/induced-dipoles.md). "Near" sums include only nearest images
/// closer than half of the shortest edge of the box, "far" sums include all images.
enum class DipoleSum {
  ewald,             ///< All interactions far
  mixed_consistent,  ///< Far, except near between dipoles
  minimum_image,     ///< All interactions near, except between charges
  /// Charges polarize by far fields, all else is near (Singh 2019). Forces are not derivatives of an energy.
  source
};

/// Model of charges with induced point dipoles, mu_i = A_i e_i, with the polarizability A_i and the field e_i of all
/// other charges and dipoles. The energy is that of the charges plus -sum mu.e_charges - 1/2 mu T mu + sum mu^2 / (2
/// A_i), at its minimum in mu. Unlike A_i = w_i^2 A are equal ones for the dipoles mu_i / w_i, with the interaction w_i
/// T_ij w_j and the field w_i e_i. Forces are its derivatives at fixed mu, except for DipoleSum::source. Charges always
/// act on each other by `far`.
class InducedDipoles {
 public:
  /// Sets up the model. `far`: sum over all images, which must outlive this object and must support dipoles.
  /// `polarizability` A (length^3), and `each` A_i [N], or empty if they are equal; `tolerance`: see solve_dipoles().
  InducedDipoles(Sum& far, DipoleSum variant, double polarizability, double tolerance,
                 const std::vector<double>& each = {});

  /// Solves for the induced dipoles, and computes potentials, fields, forces and energy. `charges`: sources without
  /// dipoles. `dipole` [3 N]: initial guess (empty: none), then the solution. `response`: results of charges and
  /// dipoles together; its field is the polarizing field.
  /// The energy error is of second order in the residual, because the energy is at its minimum in mu. Returns the
  /// number of dipole field evaluations of the solver. Throws the exceptions of solve_dipoles() and `far`.
  int evaluate(const Sources& charges, std::span<const Pair> pairs, parallel::Team& team, std::vector<double>& dipole,
               Response& response) const;
  /// Checks that induced dipoles at these positions have a stable state; throws InputError otherwise. The check also
  /// finds an unstable mode that symmetry hides from the charges, and so from evaluate(). It costs some tens of dipole
  /// field evaluations.
  void check_stability(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team) const;

 private:
  Sum& far_;
  DipoleSum variant_;
  double polarizability_, tolerance_;
  std::vector<double> weight_;  ///< w_i = sqrt(A_i / A) of each component [3 N]; empty: they are 1
};

/// Predictor of induced dipoles for the initial guess of the next time step, from the dipoles of the last n steps of
/// equal length: Kolafa's always stable predictor (J. Comput. Chem. 25, 335 (2004)). mu = sum_j B_j mu_(-j) with B_j =
/// (-1)^(j+1) j C(2n, n - j) / C(2n - 2, n - 1), that is 1; 2, -1; 5/2, -2, 1/2; 14/5, -14/5, 6/5, -1/5. It is less
/// exact than polynomial extrapolation, but does not amplify solver errors.
class DipolePredictor {
 public:
  /// Makes a predictor without history. `steps`: maximum number of earlier steps used.
  explicit DipolePredictor(int steps = 4) : steps_(steps) {}

  /// Returns the initial guess [3 N] for solve_dipoles(); empty without history.
  std::vector<double> predict() const;
  /// Adds the dipoles [3 N] of a new step to the history.
  void keep(std::vector<double> dipole);
  /// Replaces the dipoles of the last step in the history, or adds them to an empty history: for a second solution at
  /// the same step with other charges.
  void replace(std::vector<double> dipole);

  /// Returns the dipoles of earlier steps, the last one first. They are part of a run's state: a resumed run without
  /// them differs by the tolerance.
  const std::vector<std::vector<double>>& history() const { return history_; }
  /// Restores a history that history() returned.
  void restore(std::vector<std::vector<double>> history) { history_ = std::move(history); }

 private:
  std::size_t steps_;
  std::vector<std::vector<double>> history_;
};

}  // namespace lichtenberg::periodic
