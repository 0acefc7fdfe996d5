#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/cell_assignment.hpp"
#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/part_links.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Discretization of problems on one grid: assigns cells to bodies and computes the links (conductances between cells
/// and conductors). It keeps the memory of its intermediate results for the next problem.
class LevelBuilder {
 public:
  /// Discretizes the problem on the finest grid. `formula`: formula of the links' conductances. Throws InputError if
  /// the formula does not support a shape.
  void build(const LaplaceProblem& problem, LinkFormula formula, Level& level,
             parallel::Team& team = parallel::Team::single());
  /// Discretizes the problem on a coarse grid of the preconditioner. Of the conductors that the grid does not resolve,
  /// small floating sets become part of an effective medium and have no unknown. The others become subgrid conductors
  /// (medium.hpp). `agglomerates`: sets of groups (bodies with one potential) treated together. `finer`: the grid of
  /// cells half as large, or null.
  void build_coarse(const LaplaceProblem& problem, LinkFormula formula, const Agglomerates& agglomerates,
                    const Level* finer, Level& level, parallel::Team& team = parallel::Team::single());

 private:
  void discretize(const LaplaceProblem& problem, LinkFormula formula, Level& level, parallel::Team& team);
  void join_parts(Level& level, parallel::Team& team);

  GridBodies bodies_;
  CellAssignment assignment_;
  // At least one for each part.
  std::vector<PartLinks> parts_;
  // Row of each link's cell.
  std::vector<int> link_row_;
  // By chunk of rows.
  std::vector<EliminatedCells> eliminated_;
};

/// Sorts the links (conductances between fluid cells and conductors) by row: computes `level.row_links` and
/// `level.row_start` from `level.links`. `link_row`: the row of each link's cell.
void sort_links_by_row(std::span<const int> link_row, Level& level, parallel::Team& team);

/// Computes `level.couplings` and `level.fixed_couplings`, the problem's lumped capacitances divided by the
/// permittivity. Conductances above `largest` are replaced by it. Couplings of a group without an unknown on this grid
/// are left out.
void set_couplings(const LaplaceProblem& problem, double largest, Level& level);

}  // namespace lichtenberg::laplace
