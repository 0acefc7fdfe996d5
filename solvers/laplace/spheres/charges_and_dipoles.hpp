#pragma once

#include <Eigen/Cholesky>
#include <memory>

#include "solvers/laplace/spheres/cell_field.hpp"
#include "solvers/laplace/spheres/initial_guess.hpp"

namespace lichtenberg::laplace::spheres {

/// Coarse-grid preconditioner for conducting spheres: the equations for charges and dipoles only, as one inverted dense
/// matrix that includes all images. For more than 500 spheres it has charges only. Near pairs are exact; far cells
/// interact by their charges and dipoles. Conjugate gradients converge slowly for these long-range parts, while higher
/// harmonics act on near neighbours only.
class ChargesAndDipoles {
 public:
  /// Returns true if the number of spheres is small enough (at most 2000) for the dense matrix to save time.
  static bool saves_time(std::size_t spheres);
  /// Assembles the matrix of the coarse equations, and inverts it if it is positive definite. `pairs`: all near pairs
  /// of the sites.
  ChargesAndDipoles(const Mirrors& mirrors, const Cells& cells, const std::vector<Site>& sites,
                    const std::vector<NearPair>& pairs, parallel::Team& team);

  /// Returns true if the matrix is positive definite. With a sum over images that is truncated at a degree it need not
  /// be; then it cannot be used.
  bool is_positive() const { return positive_; }
  /// Returns true if the matrix can precondition a solve with these sites: they have the same radii, and no sphere has
  /// moved by more than its radius. A preconditioner need not be exact. Small displacements add few iterations, while a
  /// new matrix costs as much as many iterations.
  bool is_usable_for(const std::vector<Site>& sites) const;

  /// Returns the number of unknowns per sphere: 4 with dipoles, 1 without.
  int unknowns_per_sphere() const { return harmonics(degree_); }
  /// Solves the coarse equations x + sqrt(R) b = values for x = sqrt(R) a. R is the radius, a are the multipoles and b
  /// the local coefficients of the field of all other spheres and images. Both arrays are [sphere][harmonic].
  Eigen::VectorXf solve(const Eigen::VectorXf& values, parallel::Team& team) const;
  /// Solves the coarse equations for x [sphere][harmonic] if only the charges have nonzero `values` [sphere].
  Eigen::VectorXf solve_charges(const Eigen::VectorXf& values) const { return charge_response_ * values; }
  /// Returns the charges in the solution of the coarse equations for a unit value on one sphere's charge: a column for
  /// each such sphere.
  const Eigen::MatrixXd& charges() const { return charges_; }

 private:
  void add_near(const std::vector<NearPair>& pairs, Eigen::MatrixXd& matrix) const;
  void add_far(const Mirrors& mirrors, const Cells& cells, parallel::Team& team, Eigen::MatrixXd& matrix) const;

  int degree_;
  std::vector<Site> sites_;
  bool positive_ = false;
  // Single precision suffices for a preconditioner, and reading the matrices dominates the cost of a solve.
  Eigen::MatrixXf inverse_, charge_response_;
  Eigen::MatrixXd charges_;
};

/// Coarse-grid preconditioner with constraints: the coarse equations restricted to changes x that keep the given
/// charges of floating groups. Right-hand sides that differ only by potentials of these groups give the same x.
class ConstrainedCharges {
 public:
  /// Factorizes the constraints of given charges for the coarse `equations` of charges and dipoles.
  ConstrainedCharges(std::shared_ptr<const ChargesAndDipoles> equations, const std::vector<Site>& sites,
                     const std::vector<ChargeConstraint>& constraints);

  /// Applies the preconditioner to `values` [sphere][harmonic]: replaces charges (and dipoles, if included) by the
  /// constrained solution, and leaves higher harmonics unchanged. `start`: index of each sphere's first coefficient.
  void apply(const std::vector<int>& start, double* values, parallel::Team& team) const;

 private:
  std::shared_ptr<const ChargesAndDipoles> equations_;
  std::vector<int> constraint_;          ///< Per sphere: index of its charge constraint; -1: none
  std::vector<double> share_;            ///< Per sphere: factor of its charge in the constraint, the root of its radius
  Eigen::LLT<Eigen::MatrixXd> factors_;  ///< Factors of the given charges at unit potentials
};

}  // namespace lichtenberg::laplace::spheres
