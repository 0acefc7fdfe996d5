#pragma once

#include <memory>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Options of MultipoleSolver.
struct MultipoleOptions {
  double tolerance = 1e-10;  ///< Error of potentials, charges and forces, relative to the largest; 1e-13 to 0.1
  /// True: the tolerance holds for potentials, charges and forces of bodies only, which about halves the number of
  /// multipoles. False: it holds for the field too.
  bool results_only = false;
  /// True: unbounded plane without the box, with the potential bounded at infinity; all sides must be insulating.
  bool unbounded = false;
  int cells = 512;  ///< Number of cells of `field()` along the longer side of the box
};

/// Field solver for disks by multipole expansions (spectral accuracy). Each disk has a charge and Fourier multipoles;
/// the sides of the box are mirrors that make image charges (docs/numerics/multipole-plane.md).
/// Disks are inside the box or centred on a side. Disks at equal potential may touch each other, and overlap by up to 1
/// % of the smaller radius, like elastic bodies in contact. Disks may also touch an insulating side or an electrode
/// side of their fixed potential, and cross it by up to 0.5 % of the radius. Sides are insulating or electrodes of
/// constant potential. If two electrodes of different potential meet in a corner, their charges and the energy are
/// infinite and reported as such. A charge is NaN if it diverges with opposite signs at the two ends of its side.
/// The iteration stops when its last two results, whose residuals differ by a factor of ten, differ by at most the
/// tolerance. `LaplaceSolution::residual` estimates the relative error. It is the larger of two terms: that difference,
/// and the neglected multipoles of the worst disk over the largest coefficient. The neglected multipoles are
/// extrapolated from the last ones. The estimate exceeds `tolerance` if order 1000 does not suffice. For example,
/// tolerances below 1e-7 need more for a disk at a small gap from one 50 times smaller. With `results_only` the second
/// term is the effect of the neglected multipoles on forces.
class MultipoleSolver : public LaplaceSolver {
 public:
  /// Makes a solver. Throws InputError unless the tolerance is between 1e-13 and 0.1 and there is at least one cell.
  explicit MultipoleSolver(MultipoleOptions options = {});
  ~MultipoleSolver() override;

  /// Solves the problem. Throws the exceptions of LaplaceSolver::solve. Throws InputError for couplings, link models,
  /// sides of varying potential, and electrode sides of an unbounded problem. Throws the exceptions of
  /// multipole::Arrangement for disks that the method does not support.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Computes the potential (V) of the last solve at a point p (m) of the box, or of the unbounded plane. Throws
  /// Failure if no solution is stored.
  double potential(Vec2 p) const;
  Field field() const override;
  void forget() override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Computes the number of unknowns that the multipole method would need for a problem, without a solve. Throws
/// InputError as the constructor and solve() of MultipoleSolver do.
long multipole_unknowns(const LaplaceProblem& problem, const MultipoleOptions& options);

}  // namespace lichtenberg::laplace
