#include "tests/dense_algebra.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace lichtenberg {

Eigen::MatrixXd solve_dense(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.partialPivLu().solve(b); }

Eigen::MatrixXd symmetric_pseudo_inverse(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double zero = std::numeric_limits<double>::epsilon() * a.rows() * values.cwiseAbs().maxCoeff();
  const Eigen::VectorXd inverse = values.unaryExpr([zero](double v) { return std::abs(v) > zero ? 1 / v : 0.0; });
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd real_parts_of_eigenvalues(const Eigen::MatrixXd& a) { return a.eigenvalues().real(); }

}  // namespace lichtenberg
