#pragma once

#include <Eigen/Core>

namespace lichtenberg {

// Dense matrix functions for checks, compiled once: Eigen's decompositions take seconds in each file that uses one.

/// X with A X = B, by elimination with row pivoting. A: n x n, regular; B: n x m.
Eigen::MatrixXd solve_dense(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The Moore-Penrose inverse of a symmetric matrix. Eigenvalues within their rounding error count as 0.
Eigen::MatrixXd symmetric_pseudo_inverse(const Eigen::MatrixXd& a);

/// Eigenvalues in ascending order; the upper triangle of the matrix is not read.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// Real parts of the eigenvalues of any square matrix, unordered.
Eigen::VectorXd real_parts_of_eigenvalues(const Eigen::MatrixXd& a);

}  // namespace lichtenberg
