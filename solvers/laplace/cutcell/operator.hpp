#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/edge_cells.hpp"
#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// Vector of the system: the cells' entries by slot (memory index) in single precision, then one a group (bodies with
/// one potential) in double. It serves for residuals and directions of an iteration, which need fewer digits than
/// potentials.
struct SplitVector {
  std::vector<float> cell;
  std::vector<double> group;
};

/// Matrix-free cut-cell system A x = b of the finest grid, in double precision. Vectors contain the cells' potentials
/// by slot (memory index, Layout), zero in covered cells (inside conductors) and padding, then one entry a group. A
/// group is a set of bodies with one potential. The entry is zero for groups of given potential, which belong to the
/// right-hand side.
class CutCellOperator {
 public:
  /// Builds the operator from the discretized geometry `level`, which must outlive this object. `team`: threads of all
  /// loops.
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team = parallel::Team::single());
  /// Returns the number of entries of a vector: slots (memory indices) of the grid plus groups (bodies with one
  /// potential).
  std::size_t size() const { return cells_ + groups_; }
  /// Returns the number of slots of the grid, the index of the first group (bodies with one potential) in a vector.
  std::size_t cells() const { return cells_; }

  /// Computes y = A x, the product of the system's matrix with x, for cells and groups (bodies with one potential).
  void apply(const double* x, double* y) const;
  /// Computes the cells' part of y = A x for the cells of a colour (0: red, 1: black) in row j, without the fluxes from
  /// groups (bodies with one potential). `x`: by slot (memory index), in single or double precision; `y`: the cells of
  /// the row.
  template <class Real>
  void apply_cells(int colour, int j, const Real* x, double* y) const;
  /// Computes y = A x (A: the system's matrix) for the cells of row j, and returns this row's part of the scalar
  /// product x'y. `x`, `y`: by slot (memory index), both in single or in double precision; `x_group` [groups]. Sums are
  /// in double precision.
  template <class Real>
  double apply_row(int j, const Real* x, const double* x_group, Real* y) const;
  /// Computes the groups' part of y = A x (A: the system's matrix), and returns its part of the scalar product x'y.
  /// `x`: by slot (memory index); `x_group`, `y_group` [groups]. A group is a set of bodies with one potential.
  template <class Real>
  double apply_groups(const Real* x, const double* x_group, double* y_group) const;
  /// Adds to `sum` [groups] the sum of conductance times x over the links of each group (bodies with one potential) to
  /// cells. `x`: by slot (memory index).
  template <class Real>
  void add_cell_fluxes(const Real* x, double* sum) const {
    links_.add_to_groups(*team_, x, sum);
  }
  /// Computes the residual r = b - A x of A x = b (A: the system's matrix).
  void residual(const double* b, const double* x, SplitVector& r) const;
  /// Scales the initial guess x by the factor that minimizes its error as a solution of A x = b in the energy norm. A
  /// factor that differs from 1 by less than 5e-4 counts as 1. Sets r = b - A x. A poor guess thus becomes small;
  /// unscaled, its energy norm would set the scale of CG's stop criterion. Returns the energy norm of x, without the
  /// energy of couplings (lumped capacitances).
  double stretch(const double* b, double* x, SplitVector& r) const;
  /// Computes the right-hand side b, in units of `scale` (V): charge / permittivity of floating groups, plus
  /// conductance * potential of links to given potentials. A group is a set of bodies with one potential; the given
  /// potentials are those of groups and sides.
  void right_hand_side(const LaplaceProblem& problem, double* b, double scale = 1) const;
  /// Shifts all potentials x by one value such that the residuals r sum to zero, and updates r. Only for systems that
  /// are grounded by couplings (lumped capacitances) to given potentials alone.
  void fix_potential_level(double* x, SplitVector& r) const;
  /// Corrects the charges: shifts the floating groups' potentials, and all potentials by a common value. The charge of
  /// each floating group and the sum of all charges then are exact except for rounding. The shifts, of the order of
  /// CG's tolerance, are a Galerkin correction and reduce the error in the energy norm. `scale`: potential unit (V) of
  /// b and x. A group is a set of bodies with one potential.
  void balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const;
  /// Smooths x by Gauss-Seidel sweeps over the groups and the cells next to conductors, where a change of geometry
  /// causes the largest errors. Returns the work in evaluations of A. On grids with varying face conductances it does
  /// nothing and returns 0. A group is a set of bodies with one potential.
  double relax_edges(const double* b, double* x, int sweeps) const;
  /// Sets the entries of covered cells (inside conductors) and of groups of given potential to zero. A group is a set
  /// of bodies with one potential.
  void mask(double* x) const;

  /// Returns the discretized geometry of the finest grid.
  const Level& level() const { return *level_; }
  /// Returns true if only couplings (lumped capacitances) link the system to given potentials.
  bool grounded_by_couplings() const { return grounded_by_couplings_; }
  /// Returns the team of threads that runs the loops of the operator.
  parallel::Team& team() const { return *team_; }

 private:
  /// Part of a row in the scalar products x'A x and x'b.
  struct RowProducts {
    double energy = 0, right_hand_side = 0;
  };
  void factorize_groups();
  template <class Real>
  double apply_field_to_groups(const Real* x, const double* x_group, double* y_group) const;
  template <class Real>
  void apply_links(int j, const Real* x, const double* x_group, std::array<double*, 2> y) const;
  RowProducts residual_row(int j, const double* b, const double* x, float* r) const;
  double apply_couplings(const double* x_group, double* y_group) const;
  /// Returns true if groups (bodies with one potential) are linked to each other, by couplings (lumped capacitances) or
  /// directly through a gap.
  bool are_linked() const { return level_->is_coupled() || !pairs_.empty(); }
  void solve_groups(double* flow) const;
  void shift_cells(double value, double* x) const;
  void relax_groups(const double* b, double* x) const;
  void relax_edges_of_row(int colour, int j, const double* b, double* x) const;
  template <class Real>
  void subtract_closed_faces(int colour, int j, const Real* x, double* y) const;
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
