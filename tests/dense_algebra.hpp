#pragma once

#include <Eigen/Core>

namespace lichtenberg {

// Dense matrices for checks, compiled once: Eigen's decompositions take seconds in each file that has one.

/// X with A X = B, by elimination with row pivoting. A: n x n, regular; B: n x m.
Eigen::MatrixXd solve_dense(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The Moore-Penrose inverse.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a);

/// Ascending, of a matrix whose upper triangle is not read.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// Real parts of the eigenvalues of any square matrix, in no order.
Eigen::VectorXd real_parts_of_eigenvalues(const Eigen::MatrixXd& a);

}  // namespace lichtenberg
