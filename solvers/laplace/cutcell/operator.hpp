#pragma once

#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/edge_cells.hpp"
#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system A x = b of the finest grid without a matrix, in double precision. Vectors hold the potential of
/// the cells in the level's layout (zero in covered cells and padding), followed by one entry a group (zero for groups
/// of given potential, which stand on the right-hand side).
class CutCellOperator {
 public:
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team = parallel::Team::single());
  std::size_t size() const { return cells_ + groups_; }
  std::size_t cells() const { return cells_; }

  /// y = A x
  void apply(const double* x, double* y) const;
  /// The part of it in row j, and in the groups; returns that part of x'y.
  double apply_row(int j, const double* x, double* y) const;
  double apply_groups(const double* x, double* y_group) const;
  /// Multiplies x such that its error as a solution of A x = b is least in the energy norm, and sets r = b - A x. A bad
  /// first guess becomes small: left as it is, it would be the scale by which CG stops. Returns the energy norm of x.
  double stretch(const double* b, double* x, double* r) const;
  /// Right-hand side: charges / eps, and what groups and sides of given potential bring, in units of `scale` (V).
  void right_hand_side(const LaplaceProblem& problem, double* b, double scale = 1) const;
  /// Shifts all potentials together such that the sum of all equations holds, and with them the residual r: for systems
  /// whose only ground are couplings.
  void level_out(double* x, double* r) const;
  /// Shifts the floating groups' potentials, and all potentials together, such that every group's charge and the sum of
  /// all charges are exact to rounding. What CG has left open is of the order of its tolerance; these shifts are a
  /// Galerkin correction, so that they lessen the error in the energy norm. `scale` as for the right-hand side b.
  void balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const;
  /// Smooths x where a change of geometry leaves its largest errors: sweeps over the groups and the cells linked to
  /// them. Returns the work, in evaluations of A.
  double relax_edges(const double* b, double* x, int sweeps) const;
  /// Sets covered cells and fixed groups to zero.
  void mask(double* x) const;

  const Level& level() const { return *level_; }
  /// Whether nothing has a given potential but what groups are coupled to.
  bool grounded_by_couplings() const { return grounded_by_couplings_; }
  parallel::Team& team() const { return *team_; }

 private:
  void factorize_groups();
  double apply_field_to_groups(const double* x, double* y_group) const;
  double apply_couplings(const double* x_group, double* y_group) const;
  /// Whether groups are linked to each other, by couplings or directly.
  bool are_linked() const { return level_->is_coupled() || !pairs_.empty(); }
  void solve_groups(double* flow) const;
  void shift_cells(double value, double* x) const;
  void relax_groups(const double* b, double* x) const;
  void relax_edges_of_row(int colour, int j, const double* b, double* x) const;
  void narrow_row(int j, const double* x, double* y) const;
  const Level* level_ = nullptr;
  parallel::Team* team_ = nullptr;
  std::size_t cells_ = 0, groups_ = 0;
  LinkLists<double> links_;
  EdgeCells edges_;
  std::vector<NetworkLink> pairs_;      // direct links between floating groups
  std::vector<double> group_diagonal_;  // 0: fixed; couplings are not in it
  bool grounded_by_couplings_ = false;
  NetworkFactors group_factors_;  // of all links of groups, if any are linked to each other
};

}  // namespace lichtenberg::laplace
