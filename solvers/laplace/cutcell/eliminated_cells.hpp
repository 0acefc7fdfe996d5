#pragma once

#include <cstddef>
#include <vector>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

struct GridBodies;
struct Level;

/// Near-surface cells: fluid cells dominated by links to conductors, in gaps below a cell or with a centre close to a
/// surface. The cycle eliminates them (Kron reduction). If such a cell and the groups were
/// relaxed alternately, a sweep would leave c / d of their common error (c: conductance to a group; d: the cell's sum).
/// Elimination changes a group's conductance from c to c - c^2 / d, and adds c_a c_b / d between two groups.
struct EliminatedCells {
  /// Minimum link conductance for the elimination of a cell; a face between two cells has 1
  /// (docs/numerics/multigrid.md).
  static constexpr double least_conductance = 8;
  /// Schur complement of a cell: conductance of a group to the rest, and between two groups. `all`: sum of the cell's
  /// conductances.
  LICHTENBERG_HOST_DEVICE static constexpr double schur_diagonal(double c, double all) { return c * (all - c) / all; }
  LICHTENBERG_HOST_DEVICE static constexpr double schur_offdiagonal(double a, double b, double all) {
    return a * b / all;
  }

  struct Cell {
    std::ptrdiff_t slot;
    int row;
    /// Sum of the cell's conductances.
    double diagonal;
  };
  struct Link {
    int body, group;
    double conductance;
  };
  /// By row.
  std::vector<Cell> cells;
  /// [cells + 1] a cell's first in `links`.
  std::vector<int> start;
  /// Links to floating groups; links of a cell to one group are joined.
  std::vector<Link> links;
  /// Indices in Level::links of all these links.
  std::vector<int> link_of_level;

  void clear();
  /// Appends the cells of another list.
  void append(const EliminatedCells& more);
  /// Calls effect(link, link, conductance) for each pair of groups with links to the same cell.
  template <class Effect>
  void for_each_pair(const Effect& effect) const {
    for (std::size_t k = 0; k < cells.size(); ++k)
      for (int m = start[k]; m < start[k + 1]; ++m)
        for (int n = m + 1; n < start[k + 1]; ++n)
          effect(links[m], links[n], schur_offdiagonal(links[m].conductance, links[n].conductance, cells[k].diagonal));
  }
};

/// Sets `level.eliminated` from its links to resolved bodies and its diagonal.
void find_eliminated_cells(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
