#pragma once

#include <Eigen/Dense>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/near_field.hpp"

namespace lichtenberg::laplace::multipole {

/// Unknown are the multipole coefficients a_k of every disk and, after them, the charges that the problem doesn't give
/// (as lambda = Q / 2 pi eps, V; less what is in point charges), the potentials of floating groups with several
/// members, the level of the potential if no wall fixes it, and the point charges of close pairs. Here is which is
/// where.
struct Unknowns {
  Unknowns(const LaplaceProblem& problem, const Mirrors& mirrors, const Arrangement& arrangement);

  int multipoles = 0, others = 0;  ///< real numbers
  std::vector<bool> given_charge;  ///< of each disk
  std::vector<int> charge;         ///< of each disk, -1 if given or an electrode's
  std::vector<int> potential;      ///< of each group, -1 if given or found afterwards
  std::vector<int> close_pair;
  int level = -1;  ///< -1: fixed by a wall, or free
};

/// The linear system. Equations: on each circle the terms cos k theta and sin k theta vanish,
///   a_k + conj(b_k) = 0   (k >= 1),
/// the disks whose charge is unknown have their group's potential, members' charges add up to their group's, all
/// charges to zero where no wall takes any, and a close pair's potential difference is that of its point charges.
class System {
 public:
  System(const Setting& setting, FarField& far, double accuracy);

  int size() const { return unknown_.multipoles + unknown_.others; }
  Eigen::VectorXd right_hand_side() const;
  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const;
  /// Approximate inverse: identity for the multipoles, the other unknowns by the charges' direct interaction.
  Eigen::VectorXd precondition(const Eigen::VectorXd& residual) const;

  /// Whether it is more than the identity for the other unknowns, of which there may be too many.
  bool has_preconditioner() const { return extra_inverse_.rows() == unknown_.others; }

  /// x with the multipoles of another solution, as far as it has them, and its other unknowns if they are as many.
  Eigen::VectorXd first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                              const Eigen::VectorXd& past_extra) const;
  /// The unknowns of x other than multipoles.
  Eigen::VectorXd extra(const Eigen::VectorXd& x) const { return x.tail(unknown_.others); }
  /// Coefficients of every source, the given charges included.
  std::vector<Complex> coefficients(const Eigen::VectorXd& x) const;
  struct Potentials {
    std::vector<double> group;  ///< V
    double level = 0;           ///< V, to be added to the field of sources and walls
  };
  /// Of the solution x with its coefficients; leaves their far field in `far`.
  Potentials potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const;

 private:
  void make_shifts();
  std::vector<int> charged_sources() const;
  Eigen::MatrixXd interaction(const std::vector<int>& disks, const std::vector<int>& sources) const;
  void factorize();
  void spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const;
  void gather_in_cells(const std::vector<Complex>& coefficients) const;
  void bring_to_disks(std::vector<Complex>& local) const;
  std::vector<Complex> local_field(const std::vector<Complex>& coefficients) const;
  std::vector<double> mean_potentials(const std::vector<Complex>& local) const;
  void balance(const Eigen::VectorXd& x, const std::vector<double>& mean_potential, Eigen::VectorXd& y) const;
  int disks() const { return setting_->arrangement.disks; }
  int group_of(int disk) const { return setting_->problem.bodies[disk].group; }
  double lambda(double charge) const;

  const Setting* setting_;
  FarField* far_;
  NearField near_;
  std::vector<Complex> shifts_;  ///< of each source: ((centre of its cell - centre) / h)^j / j!
  std::vector<Complex> wall_;    ///< local coefficients of the electrodes' field, laid out as the sources
  std::vector<double> given_;    ///< lambda of each disk as far as given, else 0
  Unknowns unknown_;
  Eigen::PartialPivLU<Eigen::MatrixXd> extra_inverse_;
};

}  // namespace lichtenberg::laplace::multipole
