#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <utility>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system A x = b of the finest grid without a matrix, in double precision. Vectors hold the potential of
/// the cells in the level's layout (zero in covered cells and padding), followed by one entry a group (zero for groups
/// of given potential, which stand on the right-hand side).
class CutCellOperator {
 public:
  void build(const LaplaceProblem& problem, const Level& level);
  std::size_t size() const { return cells_ + groups_; }

  /// y = A x
  void apply(const double* x, double* y) const;
  /// Right-hand side: charges / eps, and what groups and sides of given potential bring.
  void right_hand_side(const LaplaceProblem& problem, double* b) const;
  /// Shifts the floating groups' potentials, and all potentials together, such that every group's charge and the sum of
  /// all charges are exact to rounding. What CG has left open is of the order of its tolerance; these shifts are a
  /// Galerkin correction, so that they lessen the error in the energy norm.
  void balance(const double* b, double* x) const;
  /// Sets covered cells and fixed groups to zero.
  void mask(double* x) const;

 private:
  std::vector<double> group_residual(const double* b, const double* x) const;
  Eigen::SparseMatrix<double> group_matrix() const;

  const Level* level_ = nullptr;
  std::size_t cells_ = 0, groups_ = 0;
  // Couplings with floating groups; group indices count from the vector's start.
  std::vector<std::int32_t> link_cell_, link_group_;
  std::vector<double> link_conductance_;
  struct GroupPair {
    std::int32_t a, b;
    double conductance;
  };
  std::vector<GroupPair> pairs_;
  std::vector<double> group_diagonal_;  // 0: fixed
  // Conductances to what has a given potential: of cells and groups, by index into the vector.
  std::vector<std::pair<std::int32_t, double>> to_ground_;
};

}  // namespace lichtenberg::laplace
