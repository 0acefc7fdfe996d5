#pragma once

#include <Eigen/Dense>

#include "solvers/laplace/multipole/arrangement.hpp"
#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/near_field.hpp"
#include "solvers/laplace/multipole/wall_field.hpp"

namespace lichtenberg::laplace {

/// The linear system. Unknown are the multipole coefficients a_k of every disk and, after them, the charges that the
/// problem doesn't give (as lambda = Q / 2 pi eps, V; less what is in point charges), the potentials of floating groups
/// with several members, the level of the potential if no wall fixes it, and the point charges of close pairs.
/// Equations: on each circle the terms cos k theta and sin k theta vanish,
///   a_k + conj(b_k) = 0   (k >= 1),
/// the disks whose charge is unknown have their group's potential, members' charges add up to their group's, all
/// charges to zero where no wall takes any, and a close pair's potential difference is that of its point charges.
class System {
 public:
  System(const LaplaceProblem& problem, const Arrangement& arrangement, const LatticeSum& lattice,
         const WallField& wall, FarField& far, const Mirrors& mirrors, double accuracy);

  Eigen::Index size() const { return multipole_unknowns_ + extra_unknowns_; }
  Eigen::VectorXd right_hand_side() const;
  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const;
  /// Approximate inverse: identity for the multipoles, the other unknowns by the charges' direct interaction.
  Eigen::VectorXd precondition(const Eigen::VectorXd& residual) const;

  /// x with the multipoles of another solution, as far as it has them, and its other unknowns if they are as many.
  Eigen::VectorXd first_guess(const Layout& past_layout, const std::vector<Complex>& past_coefficients,
                              const Eigen::VectorXd& past_extra) const;
  /// The unknowns of x other than multipoles.
  Eigen::VectorXd extra(const Eigen::VectorXd& x) const { return x.tail(extra_unknowns_); }
  /// Coefficients of every disk, the given charges included.
  std::vector<Complex> coefficients(const Eigen::VectorXd& x) const;
  struct Potentials {
    std::vector<double> group;  ///< V
    double level = 0;           ///< V, to be added to the field of sources and walls
  };
  /// Of the solution x with its coefficients; leaves their far field in `far`.
  Potentials potentials(const Eigen::VectorXd& x, const std::vector<Complex>& coefficients) const;

 private:
  void number_unknowns(const Mirrors& mirrors);
  void factorize(const Mirrors& mirrors, const LatticeSum& lattice);
  std::vector<Complex> local_field(const std::vector<Complex>& coefficients) const;
  void spread(const Eigen::VectorXd& x, std::vector<Complex>& coefficients) const;
  void balance(const Eigen::VectorXd& x, const std::vector<double>& mean_potential, Eigen::VectorXd& y) const;
  std::vector<double> mean_potentials(const std::vector<Complex>& local) const;
  int group_of(int disk) const { return problem_->bodies[disk].group; }

  const LaplaceProblem* problem_;
  const Arrangement* arrangement_;
  FarField* far_;
  Layout layout_;
  NearField near_;
  std::vector<Complex> shifts_;  ///< of each disk: ((centre of its cell - centre) / h)^j / j!
  std::vector<Complex> wall_;    ///< local coefficients of the electrodes' field, laid out as the sources
  std::vector<double> given_;    ///< lambda of each disk as far as given, else 0

  int multipole_unknowns_ = 0, extra_unknowns_ = 0;
  std::vector<int> charge_unknown_;     ///< of each disk, -1 if given
  std::vector<int> potential_unknown_;  ///< of each group, -1 if given or found afterwards
  std::vector<int> pair_unknown_;       ///< of each close pair
  int level_ = -1;
  Eigen::PartialPivLU<Eigen::MatrixXd> extra_;
};

}  // namespace lichtenberg::laplace
