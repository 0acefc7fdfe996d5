#pragma once

#include <Eigen/Cholesky>
#include <memory>

#include "solvers/laplace/spheres/cell_field.hpp"
#include "solvers/laplace/spheres/initial_guess.hpp"

namespace lichtenberg::laplace::spheres {

/// Coarse equations for the spheres' charges and dipoles only (for many spheres: charges only), all images included, as
/// one factorized matrix. Near pairs are exact; far cells interact by their charges and dipoles. Conjugate gradients
/// converge slowly for these long-range parts; higher harmonics act on near neighbours only.
class ChargesAndDipoles {
 public:
  /// Returns true if the number of spheres is small enough for the matrix to save time.
  static bool saves_time(std::size_t spheres);
  ChargesAndDipoles(const Mirrors& mirrors, const Cells& cells, const std::vector<Site>& sites,
                    const std::vector<NearPair>& pairs, parallel::Team& team);

  /// Returns true if the matrix is positive definite. A sum of images truncated at a degree need not be; the matrix is
  /// useless then.
  bool is_positive() const { return positive_; }
  /// Returns true if no sphere has moved by more than its radius. A preconditioner need not be exact: displacements by
  /// some radii add an iteration or two, while a new matrix costs as much as many iterations.
  bool is_usable_for(const std::vector<Site>& sites) const;

  /// Returns the number of unknowns per sphere.
  int unknowns_per_sphere() const { return harmonics(degree_); }
  /// Solves x + sqrt(R) b = values for x, in the scaling of System; both [sphere][harmonic].
  Eigen::VectorXf solve(const Eigen::VectorXf& values, parallel::Team& team) const;
  /// Solves for x if only the spheres' charges have values.
  Eigen::VectorXf solve_charges(const Eigen::VectorXf& values) const { return charge_response_ * values; }
  /// Charges of x for a unit value on one sphere; one column per sphere.
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

/// Coarse equations restricted to changes x that keep given charges: right-hand sides that differ only in the groups'
/// potentials yield the same x.
class ConstrainedCharges {
 public:
  ConstrainedCharges(std::shared_ptr<const ChargesAndDipoles> equations, const std::vector<Site>& sites,
                     const std::vector<ChargeConstraint>& constraints);

  /// Solves for the charges and dipoles in `values`, with spheres starting at `start`; leaves other harmonics
  /// unchanged.
  void apply(const std::vector<int>& start, double* values, parallel::Team& team) const;

 private:
  std::shared_ptr<const ChargesAndDipoles> equations_;
  std::vector<int> constraint_;          ///< Per sphere: index of its charge constraint; -1: none
  std::vector<double> share_;            ///< Per sphere: factor of its charge in the constraint, the root of its radius
  Eigen::LLT<Eigen::MatrixXd> factors_;  ///< Factors of the given charges at unit potentials
};

}  // namespace lichtenberg::laplace::spheres
