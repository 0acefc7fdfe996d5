#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system of one grid as a sparse matrix (CSR arrays), or some of its rows. The unknowns are the fluid
/// cells, then the floating groups (bodies with one unknown potential). The arrays hold both triangles by rows, or the
/// upper triangle by columns. The latter equals the lower triangle by rows of a symmetric matrix.
struct SparseSystem {
  /// [rows + 1] index of each row's first entry.
  std::vector<int> start = {0};
  /// Columns of the entries, ascending in each row, and their values.
  std::vector<int> index;
  std::vector<double> value;
  /// Slot (memory index in Layout) of each cell unknown.
  std::vector<std::ptrdiff_t> slot;
  /// Group of each unknown after the cells.
  std::vector<int> group;
  /// Unknown that is the difference between the potentials of two groups (bodies with one potential); `from` is the
  /// other group's unknown. A coupling (lumped capacitance) may exceed all other conductances of two groups by far.
  /// These would vanish in the rounding of the two groups' rows. One row is therefore the sum of both, without the
  /// coupling.
  struct Difference {
    int unknown, from;
  };
  std::vector<Difference> differences;
  struct Entry {
    int column;
    double value;
  };
  /// Appends a row to the sparse matrix. Sorts `row` by column and adds up entries of one column.
  void append(std::vector<Entry>& row);
  /// Converts a right-hand side by unknown, in place, from the groups' charges to the equations of the unknowns (some
  /// are differences of two groups' potentials). A group is a set of bodies with one potential.
  void from_charges(double* b) const;
  /// Converts a vector by unknown, in place, from the groups' potentials to the unknowns (differences of coupled
  /// groups). A group is a set of bodies with one potential.
  void from_potentials(double* x) const;
  /// Converts a vector by unknown, in place, from the unknowns (differences of coupled groups) to the groups'
  /// potentials. A group is a set of bodies with one potential.
  void to_potentials(double* x) const;
  /// Returns the number of unknowns: fluid cells and floating groups (bodies with one unknown potential).
  int unknowns() const { return static_cast<int>(slot.size() + group.size()); }
};

/// Numbers the unknowns (fluid cells, then floating groups) of the grid `level`: makes a sparse system with `slot`,
/// `group` and `differences`, but without matrix rows.
SparseSystem number_unknowns(const LaplaceProblem& problem, const Level& level);

/// Assembles the matrix rows `begin` to `end` - 1 of a system that number_unknowns() has made.
void assemble_rows(const LaplaceProblem& problem, const Level& level, int begin, int end, SparseSystem& system);

/// Assembles the matrix of the preconditioner on the grid `level` (with FixedCoupling::conductance_in_cycle).
/// `upper_only` leaves out one triangle. `pin` doubles one diagonal entry, for a system without any ground, whose
/// matrix is singular. This makes the matrix positive definite. For a consistent right-hand side it changes the
/// potentials by a constant only.
SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin);

}  // namespace lichtenberg::laplace
