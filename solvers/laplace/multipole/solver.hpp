#pragma once

#include <memory>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

struct MultipoleOptions {
  double tolerance = 1e-10;   ///< error of potentials, charges and forces, relative to the largest; 1e-13 to 0.1
  bool results_only = false;  ///< it is asked of these alone, which allows half the multipoles; else of the field, too
  bool unbounded = false;     ///< no box: the plane, V bounded at infinity. `sides` must be insulating.
  int cells = 512;            ///< cells of `field()` along the longer side of the box
};

/// Spectral solution for disks: each has a logarithm and Fourier multipoles, the walls are mirrors (README.md). Disks
/// lie inside the box or are centred on a side. Where both have one potential they may touch each other, or a side, and
/// overlap by up to 1 % of the smaller radius, as elastic bodies in contact do. Sides are insulating or electrodes of
/// constant potential. Where two electrodes of different potential meet in a corner, their charges and the energy are
/// infinite, and are reported so.
///
/// `residual` estimates the relative error: the larger of ten times GMRES's relative residual and what the multipoles
/// left out add up to, extrapolated from the last ones, for the worst disk over the largest coefficient of all. It
/// exceeds `tolerance` where order 1000 is not enough: a disk beside one 50 times smaller, or less. With `results_only`
/// it is what the last multipoles add to forces and what GMRES may lack, and mostly of the size of the error.
class MultipoleSolver : public LaplaceSolver {
 public:
  /// Throws InputError for options out of range.
  explicit MultipoleSolver(MultipoleOptions options = {});
  ~MultipoleSolver() override;

  /// Throws InputError also for bodies that are no disks, disks of different potential without a gap between them,
  /// disks cut by a side off their centre, and sides of varying potential.
  LaplaceSolution solve(const LaplaceProblem& problem) override;
  /// Potential of the last solve anywhere in the box (anywhere in the unbounded plane), V. Like `field`, throws Failure
  /// if nothing has been solved.
  double potential(Vec2 p) const;
  Field field() const override;
  void forget() override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Unknowns that a solve of this problem will have, without solving it. Throws what MultipoleSolver throws.
long multipole_unknowns(const LaplaceProblem& problem, const MultipoleOptions& options);

}  // namespace lichtenberg::laplace
