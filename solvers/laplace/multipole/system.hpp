#pragma once

#include <Eigen/Dense>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/near_field.hpp"

namespace lichtenberg::laplace::multipole {

/// Positions of the unknowns in their vector. The multipole coefficients a_k of all disks come first. The charges that
/// the problem does not give follow (as lambda = Q / 2 pi eps, in V, less the point charges). The potentials of
/// floating groups with several members are next, then the level of the potential if no wall fixes it. The point
/// charges of close pairs are the last.
struct Unknowns {
  Unknowns(const LaplaceProblem& problem, const Mirrors& mirrors, const Arrangement& arrangement);

  int multipoles = 0, others = 0;  ///< Number of real unknowns
  std::vector<bool> given_charge;  ///< Per disk: true if its charge is given
  std::vector<int> charge;         ///< Per disk: index of its charge, -1 if given or determined by an electrode
  std::vector<int> potential;      ///< Per group: index of its potential, -1 if given or computed afterwards
  std::vector<int> close_pair;
  int level = -1;  ///< Index of the potential level, -1: fixed by a wall, or undetermined
};

/// Linear system. On each circle the terms cos k theta and sin k theta vanish: a_k + conj(b_k) = 0 (k >= 1). Disks of
/// unknown charge have their group's potential. Members' charges add up to their group's. All charges add up to zero if
/// no wall takes any. The potential difference of a close pair is that of its point charges.
class System {
 public:
  System(const Setting& setting, FarField& far, double accuracy);

  int size() const { return unknown_.multipoles + unknown_.others; }
  Eigen::VectorXd right_hand_side() const;
  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const;
  /// Approximate inverse: identity for the multipoles; for the other unknowns the inverse of the charges' direct
  /// interaction.
  Eigen::VectorXd precondition(const Eigen::VectorXd& residual) const;

  /// Returns true if the other unknowns are preconditioned too; they are not if there are too many.
  bool has_preconditioner() const { return extra_inverse_.rows() == unknown_.others; }

  /// Returns an initial guess: the multipoles of another solution as far as it has them, and its other unknowns if
  /// their number is equal.
  Eigen::VectorXd first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                              const Eigen::VectorXd& past_extra) const;
  /// Returns the unknowns of x other than multipoles.
  Eigen::VectorXd extra(const Eigen::VectorXd& x) const { return x.tail(unknown_.others); }
  /// Returns the coefficients of every source, given charges included.
  std::vector<Complex> coefficients(const Eigen::VectorXd& x) const;
  struct Potentials {
    std::vector<double> group;  ///< V
    double level = 0;           ///< Potential level (V), added to the field of sources and walls
  };
  /// Computes the potentials of the solution x with its coefficients; leaves their far field in `far`.
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
