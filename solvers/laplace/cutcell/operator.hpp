#pragma once

#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/edge_cells.hpp"
#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// Matrix-free cut-cell system A x = b of the finest grid, in double precision. Vectors contain the cells' potentials
/// in the level's layout (zero in covered cells and padding), then one entry a group. The entry is zero for groups of
/// given potential, which belong to the right-hand side.
class CutCellOperator {
 public:
  /// Takes over the level, which must outlive this object.
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team = parallel::Team::single());
  std::size_t size() const { return cells_ + groups_; }
  std::size_t cells() const { return cells_; }

  /// y = A x
  void apply(const double* x, double* y) const;
  /// Parts of apply(): row j, and the groups. Return their parts of x'y.
  double apply_row(int j, const double* x, double* y) const;
  double apply_groups(const double* x, double* y_group) const;
  /// Multiplies x by the factor that minimizes its error as a solution of A x = b in the energy norm, and sets r = b -
  /// A x. A poor initial guess becomes small; unscaled, its energy norm would set the scale of CG's stop criterion.
  /// Returns the energy norm of x.
  double stretch(const double* b, double* x, double* r) const;
  /// Sets b: charges / permittivity, and links to groups and sides of given potential, in units of `scale` (V).
  void right_hand_side(const LaplaceProblem& problem, double* b, double scale = 1) const;
  /// Shifts all potentials by the value that makes the residuals r sum to zero, and updates r. For systems that are
  /// grounded by couplings only.
  void fix_potential_level(double* x, double* r) const;
  /// Shifts the floating groups' potentials, and all potentials by a common value, such that every group's charge and
  /// the sum of all charges are exact except for rounding. The shifts, of the order of CG's tolerance, are a Galerkin
  /// correction and reduce the error in the energy norm. `scale`: that of b.
  void balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const;
  /// Smooths x by sweeps over the groups and the cells linked to them, where a change of geometry causes the largest
  /// errors. Returns the work in evaluations of A.
  double relax_edges(const double* b, double* x, int sweeps) const;
  /// Sets covered cells and fixed groups to zero.
  void mask(double* x) const;

  const Level& level() const { return *level_; }
  /// Returns true if only couplings link the system to given potentials.
  bool grounded_by_couplings() const { return grounded_by_couplings_; }
  parallel::Team& team() const { return *team_; }

 private:
  void factorize_groups();
  double apply_field_to_groups(const double* x, double* y_group) const;
  double apply_couplings(const double* x_group, double* y_group) const;
  /// Returns true if groups are linked to each other, by couplings or directly.
  bool are_linked() const { return level_->is_coupled() || !pairs_.empty(); }
  void solve_groups(double* flow) const;
  void shift_cells(double value, double* x) const;
  void relax_groups(const double* b, double* x) const;
  void relax_edges_of_row(int colour, int j, const double* b, double* x) const;
  void subtract_closed_faces(int j, const double* x, double* y) const;
  const Level* level_ = nullptr;
  parallel::Team* team_ = nullptr;
  std::size_t cells_ = 0, groups_ = 0;
  LinkLists<double> links_;
  EdgeCells edges_;
  // Pair links between floating groups.
  std::vector<NetworkLink> pairs_;
  // Sums of each group's conductances without couplings; 0 for groups of given potential.
  std::vector<double> group_diagonal_;
  bool grounded_by_couplings_ = false;
  // Factors of the groups' equations, if groups are linked to each other.
  NetworkFactors group_factors_;
};

}  // namespace lichtenberg::laplace
