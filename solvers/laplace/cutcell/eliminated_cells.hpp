#pragma once

#include <cstddef>
#include <vector>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

struct GridBodies;
struct Level;

/// Near-surface cells that the V-cycle eliminates (Kron reduction): fluid cells with a large conductance to a
/// conductor. They lie in narrow gaps, or their centre is close to a surface. If such a cell and the groups were
/// relaxed alternately, a sweep would leave c / d of their common error. Here c is the conductance to a group (bodies
/// with one potential), d the sum of the cell's conductances. Elimination changes a group's conductance from c to c -
/// c^2 / d, and adds c_a c_b / d between two groups.
struct EliminatedCells {
  /// Minimum conductance of a link (per permittivity) for the elimination of its cell. A face between two cells has 1
  /// (docs/numerics/multigrid.md).
  static constexpr double least_conductance = 8;
  /// Computes the Schur complement's diagonal term of an eliminated cell (with a large conductance to a conductor), c -
  /// c^2 / all. The result is the conductance of a group (bodies with one potential) to the rest after the elimination.
  /// `c`: conductance of the group's link; `all`: sum of the cell's conductances.
  LICHTENBERG_HOST_DEVICE static constexpr double schur_diagonal(double c, double all) { return c * (all - c) / all; }
  /// Computes the conductance a b / all that the elimination of a cell adds between two groups (Schur complement). `a`,
  /// `b`: conductances of their links to the cell; `all`: sum of the cell's conductances. A group is a set of bodies
  /// with one potential.
  LICHTENBERG_HOST_DEVICE static constexpr double schur_offdiagonal(double a, double b, double all) {
    return a * b / all;
  }

  struct Cell {
    std::ptrdiff_t slot;
    int row;
    /// Sum of the conductances of all the cell's faces and links.
    double diagonal;
  };
  struct Link {
    int body, group;
    double conductance;
  };
  /// Eliminated cells, sorted by row.
  std::vector<Cell> cells;
  /// [cells + 1] index of each cell's first link in `links`.
  std::vector<int> start;
  /// Links of the cells to floating groups (unknown potential). Links of a cell to one group are added up.
  std::vector<Link> links;
  /// Indices in Level::links of all links that `links` contains.
  std::vector<int> link_of_level;

  /// Empties the list of eliminated cells and of their links.
  void clear();
  /// Appends the cells of another list `more` and their links (conductances to conductors).
  void append(const EliminatedCells& more);
};

/// Finds the near-surface cells that the V-cycle eliminates, and stores them in `level.eliminated`. Stores the
/// conductances that their elimination adds between groups in `level.eliminated_pairs`. The cells are fluid cells with
/// a link of at least `least_conductance` to a resolved body and with a link to a floating group. A floating group is a
/// set of bodies with one unknown potential.
void find_eliminated_cells(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
