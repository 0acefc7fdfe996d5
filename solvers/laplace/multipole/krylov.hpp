#pragma once

#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <vector>

namespace lichtenberg::laplace::multipole {

class System;

/// GMRES for a system and its preconditioner, with modified Gram-Schmidt, which is backward stable (Paige 2006). The
/// iteration can stop at a residual and continue to a smaller one without loss of its directions.
class Gmres {
 public:
  /// Starts from the guess x. `system` must outlive it.
  Gmres(const System& system, Eigen::VectorXd x);
  /// Iterates until residual() is at most `tolerance`. Returns false if 1000 iterations in all do not suffice.
  bool reduce_to(double tolerance);
  /// Returns the norm of the preconditioned residual over that of the preconditioned right-hand side.
  double residual() const { return scale_ == 0 ? 0 : std::abs(projected_.back()) / scale_; }
  /// Returns the number of iterations so far.
  int iterations() const { return iterations_; }
  /// Computes the iterate with the least residual.
  Eigen::VectorXd solution() const;

 private:
  void start();
  void step();

  const System* system_;
  Eigen::VectorXd right_, x_;  ///< Preconditioned right-hand side, and the iterate at the start of the directions
  double scale_;               ///< Norm of the preconditioned right-hand side (V)
  int iterations_ = 0;
  std::vector<Eigen::VectorXd> directions_;  ///< Orthonormal basis of the Krylov space
  std::vector<Eigen::VectorXd> columns_;     ///< Triangular factor of the projected matrix, by columns
  std::vector<Eigen::JacobiRotation<double>> rotations_;
  std::vector<double> projected_;  ///< Rotated right-hand side; the last entry is the residual up to its sign
};

}  // namespace lichtenberg::laplace::multipole
