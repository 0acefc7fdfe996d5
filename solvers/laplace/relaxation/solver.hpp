#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"
#include "solvers/laplace/relaxation/contour.hpp"
#include "solvers/laplace/relaxation/lattice.hpp"

namespace lichtenberg::laplace {

/// Maxwell stress, or the stress of the normal field alone. Its integral along a contour around a body is the force on
/// the body.
enum class Stress {
  maxwell,           ///< eps [(E.n) E - E^2 n / 2]: valid on any closed curve in the fluid
  normal_derivative  ///< eps/2 (dV/dn)^2 n (D 6.16): valid on the surface only, while the curve is off the surface
};

/// Options of RelaxationSolver; D: equation of Stephenson 2018.
struct RelaxationOptions {
  int sites = 512;                 ///< Lattice spacings S along the box's longer side
  double eta = 0;                  ///< Step of the descent (V m/C, D 6.30); 0: chosen from eta_c (D 6.35) in each step
  int surface_points = 500;        ///< Points of the contour around each body (D 6.11)
  double sweeps_factor = 4;        ///< Sweeps per potential solve, in units of sweeps_per_decade()
  double tolerance = 1e-4;         ///< Largest permitted error in a group's charge, as a fraction of the largest charge
  int largest_iterations = 20000;  ///< Largest number of potential solves
  Stress stress = Stress::maxwell;
};

/// Returns the optimal over-relaxation factor omega = 2 / (1 + pi / S) (Stephenson 2018, D 6.8). S = `sites` is the
/// number of spacings along a side of a square lattice.
double over_relaxation(int sites);
/// Returns the number n10 of sweeps that reduce the relaxation's error tenfold, for S = `sites` lattice spacings
/// (Stephenson 2018, D 6.9).
double sweeps_per_decade(int sites);

/// Field solver by relaxation on a square lattice, the scheme of the dissertation (Stephenson 2018, D 6.3-6.5). Lattice
/// sites inside a body or on an electrode side have its potential; red-black over-relaxation computes the potentials of
/// all others. Charges and forces are integrals along contours around the bodies. Gradient descent on the potentials of
/// floating groups makes these integrals equal to the given charges. In the solution, `body_charge` contains these
/// integrals. Their sum over a floating group therefore equals the group's charge only within the tolerance. Without
/// ground this sum also contains a part of the errors of all integrals. `iterations` counts potential solves.
/// `residual` is the larger of two fractions of the largest charge: the largest error of a group's charge, and the
/// charge that the unfinished relaxation leaves outside the conductors.
class RelaxationSolver : public LaplaceSolver {
 public:
  /// Makes a solver with these options. Throws InputError if an option is out of range.
  explicit RelaxationSolver(RelaxationOptions options = {});

  /// Solves the problem. Throws the exceptions of LaplaceProblem::check. Throws InputError for couplings, link models,
  /// a box whose sides are not whole numbers of lattice spacings, and a body that covers no lattice site. Throws
  /// Failure if the tolerance is not reached in `largest_iterations` potential solves.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Returns the potential of the last solve at the centres of the lattice's cells. Throws Failure before the first
  /// solve and after `forget`.
  Field field() const override;
  void forget() override;

  /// Returns the errors of the last solve before each step of the gradient descent: E = 1/2 sum (Q_i - Q_i*)^2 over the
  /// floating groups, in (C/m)^2 (Stephenson 2018, D 6.22). Q_i is the given charge, Q_i* the charge integral. The
  /// error of the accepted potentials is not included.
  const std::vector<double>& error_history() const { return error_history_; }

 private:
  /// Charges for the present potentials, and their errors.
  struct Estimate {
    std::vector<double> group_charge;  ///< Charge integrals Q* (C/m)
    double charge_error = 0;           ///< Worst error of the floating groups, as a fraction of the largest charge
    double leftover = 0;               ///< Charge left in the fluid, as a fraction of the largest charge
  };

  void set_up_lattice(const LaplaceProblem& problem);
  void first_potentials();
  void set_fixed_sites();
  Estimate estimate();
  bool is_relaxed(const Estimate& estimate) const;
  void descend(const Estimate& estimate);
  void subtract_mean();
  std::vector<double> missing_charge(const std::vector<double>& group_charge) const;
  double body_charge(std::size_t body) const;
  Vec2 body_force(std::size_t body) const;
  double side_potential(int i, int j) const;

  RelaxationOptions options_;
  LaplaceProblem problem_;
  bool grounded_ = true;
  Lattice lattice_;
  std::vector<int> site_body_;  ///< Per site: body that covers it, Lattice::fluid, or -2 on an electrode side
  std::vector<std::vector<ContourPoint>> contours_;
  std::vector<double> group_potential_;
  std::vector<double> body_potential_;  ///< Potentials of the last solve, the initial guess of the next one (D 6.21)
  double eta_ = 0;
  std::vector<double> last_missing_;  ///< q of the previous step, for eta_c
  std::vector<double> error_history_;
};

}  // namespace lichtenberg::laplace
