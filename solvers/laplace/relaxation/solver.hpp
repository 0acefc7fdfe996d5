#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"
#include "solvers/laplace/relaxation/contour.hpp"
#include "solvers/laplace/relaxation/lattice.hpp"

namespace lichtenberg::laplace {

/// Stress that is integrated around a body to get its force.
enum class Stress {
  maxwell,           ///< eps [(E.n) E - E^2 n / 2]: valid on any closed curve in the fluid
  normal_derivative  ///< eps/2 (dV/dn)^2 n (D 6.16): valid on the surface only, while the curve is off the surface
};

struct RelaxationOptions {
  int sites = 512;                 ///< S: lattice spacings along the box's longer side
  double eta = 0;                  ///< Step of the descent (V m/C, D 6.30); 0: chosen from eta_c (D 6.35) in each step
  int surface_points = 500;        ///< N_surf (D 6.11)
  double sweeps_factor = 4;        ///< Sweeps per potential solve, in units of n10 (D 6.9)
  double tolerance = 1e-4;         ///< Largest permitted error in a group's charge, as a fraction of the largest charge
  int largest_iterations = 20000;  ///< Largest number of potential solves
  Stress stress = Stress::maxwell;
};

/// Returns the factor omega of the over-relaxation (D 6.8).
double over_relaxation(int sites);
/// Returns the number of sweeps that reduce the lattice's error tenfold (D 6.9).
double sweeps_per_decade(int sites);

/// Scheme of the dissertation (D 6.3-6.5). Lattice sites inside a body have its potential, and red-black
/// over-relaxation solves for the others. Charges and forces are integrals around the bodies. Gradient descent on the
/// potentials of the floating groups makes these integrals equal to the given charges.
/// `body_charge` contains the integrals themselves. Hence a floating group's members add up to its charge only within
/// the tolerance, and without ground the integrals' own small excess remains as well. `iterations` counts potential
/// solves. `residual` is the larger of two fractions of the largest charge: the worst error of a group's charge, and
/// the charge left in the fluid by the unfinished relaxation.
class RelaxationSolver : public LaplaceSolver {
 public:
  /// Makes a solver. Throws InputError for options out of range.
  explicit RelaxationSolver(RelaxationOptions options = {});

  /// Solves the problem. Throws InputError also for a box that is not a whole number of spacings wide and high, and for
  /// a body that covers no site. Throws Failure if the charges are not reached in `largest_iterations` solves.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Returns the potential of the last solve. Throws Failure before the first solve and after `forget`.
  Field field() const override;
  void forget() override;

  /// Error E = 1/2 sum (Q_i - Q_i*)^2 over the floating groups (D 6.22) of the last solve, (C/m)^2: one entry for each
  /// estimate of the potentials, the last being the accepted one.
  const std::vector<double>& error_history() const { return error_history_; }

 private:
  struct Estimate {
    std::vector<double> group_charge;  ///< Q* (C/m)
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
