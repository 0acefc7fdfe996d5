#pragma once

#include <Eigen/Cholesky>
#include <memory>

#include "solvers/laplace/spheres/cell_field.hpp"
#include "solvers/laplace/spheres/first_guess.hpp"

namespace lichtenberg::laplace::spheres {

/// The equations of the spheres' charges and dipoles alone (of charges alone where spheres are many), all images
/// included, as one factorized matrix: near pairs exactly, cells that are apart by charges and dipoles of theirs. These
/// are what conjugate gradients are slow with, since they reach far; higher harmonics see their neighbours only.
class ChargesAndDipoles {
 public:
  /// Whether there are so few spheres that the matrix pays.
  static bool pays(std::size_t spheres);
  ChargesAndDipoles(const Mirrors& mirrors, const Cells& cells, const std::vector<Site>& sites,
                    const std::vector<NearPair>& pairs, parallel::Team& team);

  /// A sum of images cut off at a degree need not be; then it is of no use.
  bool is_positive() const { return positive_; }
  /// Whether spheres are where they were, to a radius. As a preconditioner it need not be exact: where all have moved
  /// by some radii an iteration or two are added to six, and to make it takes as long as twenty.
  bool serves(const std::vector<Site>& sites) const;

  /// Unknowns a sphere.
  int of_each() const { return harmonics(degree_); }
  /// [sphere][harmonic], in the scaling of System: x for x + sqrt(R) b.
  Eigen::VectorXf solve(const Eigen::VectorXf& values, parallel::Team& team) const;
  /// x where only the spheres' charges have values.
  Eigen::VectorXf solve_charges(const Eigen::VectorXf& values) const { return of_charges_ * values; }
  /// The charges among that, for a unit value on one sphere: a column a sphere.
  const Eigen::MatrixXd& charges() const { return charges_; }

 private:
  void add_near(const std::vector<NearPair>& pairs, Eigen::MatrixXd& matrix) const;
  void add_far(const Mirrors& mirrors, const Cells& cells, parallel::Team& team, Eigen::MatrixXd& matrix) const;

  int degree_;
  std::vector<Site> sites_;
  bool positive_ = false;
  // In single precision: that is enough to precondition, and reading them is what a solve costs.
  Eigen::MatrixXf inverse_, of_charges_;
  Eigen::MatrixXd charges_;
};

/// The same among the x that do not change given charges: of all right-hand sides that differ in the groups' potentials
/// only it makes one x.
class ConstrainedCharges {
 public:
  ConstrainedCharges(std::shared_ptr<const ChargesAndDipoles> equations, const std::vector<Site>& sites,
                     const std::vector<Given>& given);

  /// Solves for the charges and dipoles in `values`, whose spheres begin at `start`, and leaves what else there is.
  void apply(const std::vector<int>& start, double* values, parallel::Team& team) const;

 private:
  std::shared_ptr<const ChargesAndDipoles> equations_;
  std::vector<int> given_;               ///< of each sphere; -1: its charge is not given
  std::vector<double> share_;            ///< of its charge in that: the root of its radius
  Eigen::LLT<Eigen::MatrixXd> factors_;  ///< of the given charges for unit potentials
};

}  // namespace lichtenberg::laplace::spheres
