#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system of one level as a sparse matrix, or some of its rows. The unknowns are the fluid cells, then the
/// floating groups. The arrays are the upper triangle by columns, which equals the lower triangle by rows of a
/// symmetric matrix, or both triangles by rows.
struct SparseSystem {
  /// [rows + 1] a row's first entry.
  std::vector<int> start = {0};
  /// Columns, ascending in each row, and values.
  std::vector<int> index;
  std::vector<double> value;
  /// Layout slot of each cell unknown.
  std::vector<std::ptrdiff_t> slot;
  /// Group of each unknown after the cells.
  std::vector<int> group;
  /// Unknown that is the difference of a group's potential from that of unknown `from`. If a coupling exceeds all other
  /// links of two groups by far, these would vanish in the rounding of the two groups' rows. One row is therefore the
  /// sum of both, without the coupling.
  struct Difference {
    int unknown, from;
  };
  std::vector<Difference> differences;
  struct Entry {
    int column;
    double value;
  };
  /// Appends a row; entries of one column are added. Sorts `row`.
  void append(std::vector<Entry>& row);
  // Conversion of vectors by unknown: right-hand sides from the groups' charges; unknowns from and to the groups'
  // potentials.
  void from_charges(double* b) const;
  void from_potentials(double* x) const;
  void to_potentials(double* x) const;
  int unknowns() const { return static_cast<int>(slot.size() + group.size()); }
};

/// Numbers the unknowns: sets `slot`, `group` and `differences`, without rows.
SparseSystem number_unknowns(const LaplaceProblem& problem, const Level& level);

/// Assembles the rows from `begin` to `end` - 1 of a system with numbered unknowns.
void assemble_rows(const LaplaceProblem& problem, const Level& level, int begin, int end, SparseSystem& system);

/// Assembles the preconditioner's system (FixedCoupling::conductance_in_cycle). `upper_only` leaves out entries below
/// the diagonal. Without any ground the matrix is singular. `pin` then doubles the diagonal entry of the last unknown,
/// which makes the matrix positive definite and changes the solution for a consistent right-hand side by a constant
/// only.
SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin);

}  // namespace lichtenberg::laplace
