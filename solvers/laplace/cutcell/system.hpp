#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system of one level as a sparse matrix, or some of its rows: unknowns are the fluid cells, then the
/// floating groups. Upper triangle by columns, or both triangles by rows: the matrix is symmetric, so these are the
/// same arrays.
struct SparseSystem {
  std::vector<int> start = {0};  ///< [rows + 1]
  std::vector<int> index;        ///< [start.back()], ascending in each row
  std::vector<double> value;
  std::vector<std::ptrdiff_t> slot;  ///< layout slot of each cell unknown
  std::vector<int> group;            ///< group of each unknown after the cells
  /// An unknown that is a group's difference of potential from that of another unknown. Where a coupling outweighs all
  /// other links of two groups, a row for each group would keep nothing of them beside it; so the row of the one is the
  /// sum of both, without the coupling, and the other's potential counts from the first one's.
  struct Difference {
    int unknown, from;
  };
  std::vector<Difference> differences;
  struct Entry {
    int column;
    double value;
  };
  /// Appends a row; entries of the same column are added. `row` becomes sorted.
  void append(std::vector<Entry>& row);
  // Vectors by unknown: right-hand sides from groups' charges, unknowns from groups' potentials and back.
  void from_charges(double* b) const;
  void from_potentials(double* x) const;
  void to_potentials(double* x) const;
  int unknowns() const { return static_cast<int>(slot.size() + group.size()); }
};

/// Numbers the unknowns: `slot` and `group`, no rows yet.
SparseSystem number_unknowns(const LaplaceProblem& problem, const Level& level);

/// Assembles the rows from `begin` up to, not including, `end` of a system whose unknowns are numbered.
void assemble_rows(const LaplaceProblem& problem, const Level& level, int begin, int end, SparseSystem& system);

/// Assembles the system, with couplings to fixed groups as the preconditioner takes them. `upper_only` leaves out
/// entries below the diagonal. Without any ground the matrix is singular; `pin` then adds its diagonal entry to the
/// last unknown's once more, which leaves the solutions of a consistent right-hand side unchanged up to a constant and
/// makes the matrix positive definite.
SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin);

}  // namespace lichtenberg::laplace
