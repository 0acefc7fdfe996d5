#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"
#include "solvers/laplace/relaxation/contour.hpp"
#include "solvers/laplace/relaxation/lattice.hpp"

namespace lichtenberg::laplace {

/// What is integrated round a body to get its force.
enum class Stress {
  maxwell,           ///< eps [(E.n) E - E^2 n / 2]: holds on any closed curve in the fluid
  normal_derivative  ///< eps/2 (dV/dn)^2 n (D 6.16): holds on the surface only, and the curve is not on it
};

struct RelaxationOptions {
  int sites = 512;           ///< S: lattice spacings along the box's longer side
  double eta = 0;            ///< V m/C, step of the descent (D 6.30); 0: chosen anew each step from eta_c (D 6.35)
  int surface_points = 500;  ///< N_surf (D 6.11)
  double sweeps_factor = 4;  ///< sweeps a potential solve, in units of n10 (D 6.9)
  double tolerance = 1e-4;   ///< largest error allowed in a group's charge, as a fraction of the largest charge
  int largest_iterations = 20000;  ///< potential solves before giving up
  Stress stress = Stress::maxwell;
};

/// omega of the over-relaxation (D 6.8).
double over_relaxation(int sites);
/// Sweeps that reduce the lattice's error tenfold (D 6.9).
double sweeps_per_decade(int sites);

/// The dissertation's scheme (D 6.3-6.5): a lattice whose sites inside a body have its potential, red-black
/// over-relaxation, charges and forces from integrals round the bodies, and gradient descent on the potentials of the
/// floating groups until those integrals are the given charges.
///
/// `body_charge` holds the integrals themselves, so a floating group's members add up to its charge within the
/// tolerance only; without ground the integrals' own small excess remains as well. `iterations` counts potential
/// solves, `residual` is the larger of two fractions of the largest charge: the worst error of a group's charge, and
/// the charge that the unfinished relaxation leaves in the fluid.
class RelaxationSolver : public LaplaceSolver {
 public:
  /// Throws InputError for options out of range.
  explicit RelaxationSolver(RelaxationOptions options = {});

  /// Throws InputError also for a box that is not a whole number of spacings wide and high, and for a body that covers
  /// no site; Failure if the charges are not reached in `largest_iterations` solves.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Throws Failure before the first solve and after `forget`.
  Field field() const override;
  void forget() override;

  /// The error E = 1/2 sum (Q_i - Q_i*)^2 over the floating groups (D 6.22) of the last solve, (C/m)^2: one entry for
  /// each estimate of the potentials, the last being the accepted one.
  const std::vector<double>& error_history() const { return error_history_; }

 private:
  struct Estimate {
    std::vector<double> group_charge;  ///< Q*, C/m
    double charge_error = 0;           ///< worst of the floating groups, as a fraction of the largest charge
    double leftover = 0;               ///< charge left in the fluid, as a fraction of the largest charge
  };

  void place(const LaplaceProblem& problem);
  void first_potentials();
  void hold_sites();
  Estimate estimate();
  bool settled(const Estimate& estimate) const;
  void descend(const Estimate& estimate);
  void pin_mean();
  std::vector<double> missing_charge(const std::vector<double>& group_charge) const;
  double body_charge(std::size_t body) const;
  Vec2 body_force(std::size_t body) const;
  double side_potential(int i, int j) const;

  RelaxationOptions options_;
  LaplaceProblem problem_;
  bool grounded_ = true;
  Lattice lattice_;
  std::vector<int> site_body_;  ///< by site: body that covers it, Lattice::fluid, or -2 on an electrode side
  std::vector<std::vector<ContourPoint>> contours_;
  std::vector<double> group_potential_;
  std::vector<double> body_potential_;  ///< of the last solve, the next one's first guess (D 6.21)
  double eta_ = 0;
  std::vector<double> last_missing_;  ///< q of the step before, for eta_c
  std::vector<double> error_history_;
};

}  // namespace lichtenberg::laplace
