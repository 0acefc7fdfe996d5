#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// The cut-cell system of one level as a sparse matrix, or some of its rows: unknowns are the fluid cells, then the
/// floating groups. Upper triangle by columns, or both triangles by rows: the matrix is symmetric, so these are the
/// same arrays.
struct SparseSystem {
  std::vector<int> start;  ///< [rows + 1]
  std::vector<int> index;  ///< [start.back()], ascending in each row
  std::vector<double> value;
  std::vector<std::ptrdiff_t> slot;  ///< layout slot of each cell unknown
  std::vector<int> group;            ///< group of each unknown after the cells
  int unknowns() const { return static_cast<int>(slot.size() + group.size()); }
};

/// Numbers the unknowns: `slot` and `group`, no rows yet.
SparseSystem number_unknowns(const LaplaceProblem& problem, const Level& level);

/// Assembles the rows from `begin` up to, not including, `end` of a system whose unknowns are numbered.
void assemble_rows(const LaplaceProblem& problem, const Level& level, int begin, int end, SparseSystem& system);

/// Assembles the system, with supplies as the preconditioner takes them. `upper_only` leaves out entries below the
/// diagonal. Without any ground the matrix is singular; `pin` then adds its diagonal entry to the last unknown's once
/// more, which leaves the solutions of a consistent right-hand side unchanged up to a constant and makes the matrix
/// positive definite.
SparseSystem assemble(const LaplaceProblem& problem, const Level& level, bool upper_only, bool pin);

}  // namespace lichtenberg::laplace
