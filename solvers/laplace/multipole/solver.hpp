#pragma once

#include <memory>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

struct MultipoleOptions {
  double tolerance = 1e-10;   ///< Error of potentials, charges and forces, relative to the largest; 1e-13 to 0.1
  bool results_only = false;  ///< True: the tolerance holds for these results only, which halves the multipoles; false:
                              ///< for the field too
  bool unbounded = false;     ///< True: no box but the unbounded plane, with V bounded at infinity; `sides` must be
                              ///< insulating
  int cells = 512;            ///< Number of cells of `field()` along the longer side of the box
};

/// Spectral solver for disks: each disk has a logarithm and Fourier multipoles, and the walls are mirrors
/// (docs/numerics/multipole-plane.md).
/// Disks lie inside the box or are centred on a side. Disks at equal potential may touch each other or a side, and
/// overlap by up to 1 % of the smaller radius, like elastic bodies in contact. Sides are insulating or electrodes of
/// constant potential. If two electrodes of different potential meet in a corner, their charges and the energy are
/// infinite and reported as such.
/// `residual` estimates the relative error. It is the larger of two terms: ten times GMRES's relative residual, and the
/// neglected multipoles of the worst disk over the largest coefficient. The neglected multipoles are extrapolated from
/// the last ones. The estimate exceeds `tolerance` if order 1000 does not suffice: for a disk next to one at least 50
/// times smaller. With `results_only` the two terms are the effect of the neglected multipoles on forces and that of
/// GMRES's residual; the estimate is mostly of the size of the error.
class MultipoleSolver : public LaplaceSolver {
 public:
  /// Makes a solver. Throws InputError unless the tolerance is between 1e-13 and 0.1 and there is at least one cell.
  explicit MultipoleSolver(MultipoleOptions options = {});
  ~MultipoleSolver() override;

  /// Solves the problem. Throws the exceptions of LaplaceSolver::solve. Throws InputError for couplings, link models,
  /// sides of varying potential, and electrode sides of an unbounded problem. Throws the exceptions of Arrangement for
  /// disks that the method does not support.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Returns the potential (V) of the last solve at any point of the box, or of the unbounded plane. Like `field`,
  /// throws Failure if nothing has been solved.
  double potential(Vec2 p) const;
  Field field() const override;
  void forget() override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Returns the number of unknowns of this problem without solving it. Throws InputError as the constructor and solve of
/// MultipoleSolver do.
long multipole_unknowns(const LaplaceProblem& problem, const MultipoleOptions& options);

}  // namespace lichtenberg::laplace
