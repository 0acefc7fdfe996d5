#pragma once

#include <Eigen/Dense>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/near_field.hpp"

namespace lichtenberg::laplace::multipole {

/// Numbering of the unknowns (V) of the multipole method. Real and imaginary parts of the multipole coefficients a_k of
/// all disks come first. The unknown charges of disks follow, as lambda = Q / (2 pi eps), without the point charges
/// inside the disks. The potentials of floating groups with several bodies are next. A constant of the potential
/// follows if only groups have a given potential, no side. The point charges of close pairs are last.
struct Unknowns {
  Unknowns(const LaplaceProblem& problem, const Mirrors& mirrors, const Arrangement& arrangement);

  int multipoles = 0, others = 0;  ///< Number of real unknowns
  std::vector<bool> given_charge;  ///< Per disk: true if its charge is given
  std::vector<int> charge;         ///< Per disk: index of its charge, -1 if given or determined by an electrode
  std::vector<int> potential;      ///< Per group: index of its potential, -1 if given or computed afterwards
  std::vector<int> close_pair;     ///< Per close pair: index of its point charges
  int level = -1;                  ///< Index of the potential's constant, -1: fixed by a side, or undetermined
};

/// Linear system of the multipole method, given by its matrix-vector product. Its equations are boundary conditions.
/// The potential is constant on each circle: a_k + conj(b_k) = 0 for k >= 1, with the disk's multipoles a_k and local
/// coefficients b_k. Disks of unknown charge have the potential of their group. The charges of a floating group's
/// bodies add up to the group's charge. All charges add up to zero if no side is an electrode. A close pair has two
/// opposite point charges, one inside each circle (ClosePair), with one unknown. Their potential difference equals the
/// one across the pair.
class System {
 public:
  /// Prepares the linear system of the problem in `setting`. `setting` and `far` (far field) must outlive it;
  /// `accuracy`: relative accuracy of near interactions (NearField).
  System(const Setting& setting, FarField& far, double accuracy);

  /// Returns the number of (real) unknowns.
  int size() const { return unknown_.multipoles + unknown_.others; }
  /// Computes the right-hand side from the given charges, potentials and sides.
  Eigen::VectorXd right_hand_side() const;
  /// Computes the product of the system's matrix with x.
  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const;
  /// Applies the preconditioner: the identity for multipoles. For the other unknowns it is the inverse of the matrix
  /// that they would have if the disks had no multipoles, or the identity if there are too many.
  Eigen::VectorXd precondition(const Eigen::VectorXd& residual) const;

  /// Makes an initial guess from an earlier solution: its multipoles up to the orders of both, and its other unknowns
  /// if their number is equal.
  Eigen::VectorXd first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                              const Eigen::VectorXd& past_extra) const;
  /// Returns the unknowns of x other than multipoles.
  Eigen::VectorXd extra(const Eigen::VectorXd& x) const { return x.tail(unknown_.others); }
  /// Returns the multipole coefficients (V) of every source for the unknowns x, including given charges.
  std::vector<Complex> coefficients(const Eigen::VectorXd& x) const;
  /// Potentials of the groups (bodies with one potential) for a solution of the system.
  struct Potentials {
    std::vector<double> group;  ///< Potential of each group (V)
    double level = 0;           ///< Constant (V) added to the potential of sources and walls
  };
  /// Computes the potentials of all groups for the solution x with its multipole `coefficients`. Also leaves the far
  /// field of the coefficients in the FarField object.
  Potentials potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const;

 private:
  void make_shifts();
  std::vector<int> charged_sources() const;
  Eigen::MatrixXd interaction(const std::vector<int>& disks, const std::vector<int>& sources) const;
  void factorize();
  void spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const;
  void gather_in_cells(const std::vector<Complex>& coefficients) const;
  void shift_to_disks(std::vector<Complex>& local) const;
  std::vector<Complex> local_field(const std::vector<Complex>& coefficients) const;
  std::vector<double> mean_potentials(const std::vector<Complex>& local) const;
  void balance(const Eigen::VectorXd& x, const std::vector<double>& mean_potential, Eigen::VectorXd& y) const;
  int disks() const { return setting_->arrangement.disks; }
  int group_of(int disk) const { return setting_->problem.bodies[disk].group; }
  double lambda(double charge) const;

  const Setting* setting_;
  FarField* far_;
  NearField near_;
  std::vector<Complex> shifts_;  ///< Per source: ((centre of its cell - centre) / h)^j / j!
  std::vector<Complex> wall_;    ///< Local coefficients of the electrodes' field, with the layout of the sources
  std::vector<double> given_;    ///< Per disk: lambda if its charge is given, otherwise 0
  Unknowns unknown_;
  Eigen::PartialPivLU<Eigen::MatrixXd> extra_inverse_;
};

}  // namespace lichtenberg::laplace::multipole
