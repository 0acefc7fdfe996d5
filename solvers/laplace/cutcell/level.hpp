#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/cell_owner.hpp"
#include "solvers/laplace/cutcell/eliminated_cells.hpp"
#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"
#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Link between a fluid cell and a conductor.
struct FluidLink {
  /// Slot in the layout.
  std::ptrdiff_t cell;
  /// For a group's subgrid conductors on a coarse grid: the first of them, for all.
  int body;
  double conductance;
  /// Derivative with respect to the body's position, per cell.
  Vec2 gradient;
};

/// Compact copy of a fluid link for loops over rows of cells.
struct RowLink {
  /// Slot in the layout.
  std::int32_t cell;
  std::int32_t body;
  double conductance;
  /// Index in Level::links.
  std::int32_t link;
};

/// Derivative of a link's conductance with respect to the position of a body at the other side of the link's cell
/// (correct_for_opposed_surface in surface_links.hpp).
struct CrossGradient {
  /// Index in Level::links.
  int link;
  int body;
  Vec2 gradient;
};

/// Link between two conductors in neighbouring cells.
struct PairLink {
  int body_a, body_b;
  double conductance;
  Vec2 gradient_a, gradient_b;
};

/// Link between an electrode side of the box and a fluid cell or a conductor. `body` is -1 for a fluid cell, `cell` is
/// -1 for a body.
struct SideLink {
  std::ptrdiff_t cell;
  int body;
  int side;
  double conductance;
  /// Potential of the side at this face (V).
  double potential;
  /// Derivative of the conductance with respect to the body's position, per cell.
  Vec2 gradient;
};

/// Conductance between a floating group and a group of given potential: a resistor to a voltage source.
struct FixedCoupling {
  int group;
  double conductance;
  /// V
  double potential;
  /// Conductance in the preconditioner, which has a lower bound if only such couplings ground the field: a cycle in
  /// single precision needs a ground of sufficient strength. A sole one may have any value, because the residuals then
  /// sum to zero (CutCellOperator::fix_potential_level).
  double conductance_in_cycle;
};

/// Floating group without an unknown on a coarse grid. Its potential is interpolated at its centre between four cells.
struct AbsorbedGroup {
  int group;
  std::array<std::ptrdiff_t, 4> cell;
  std::array<float, 4> weight;
};

/// Conductances of the faces between fluid cells, by slot: to the cell on the right and to the cell above. Empty
/// vectors mean 1 everywhere.
struct FaceConductances {
  std::vector<float> east, north;

  bool are_uniform() const { return east.empty(); }
};

/// Discretized geometry on one grid: the body that covers each cell, and the links between cells, conductors and
/// electrode sides. Together with the conductances of the faces it determines the linear system. LevelBuilder fills it.
struct Level {
  /// A grid of nx x ny square cells over the problem's box, still without contents.
  Level(const LaplaceProblem& problem, int nx, int ny);

  /// Returns true if a floating group has an unknown on this grid.
  bool has_unknown(int group) const { return is_absorbed.empty() || !is_absorbed[group]; }
  bool is_coupled() const { return !couplings.empty() || !fixed_couplings.empty(); }
  /// Links between groups without an unknown cell between them: pair links and links through eliminated cells.
  std::vector<NetworkLink> direct_links(const LaplaceProblem& problem) const;

  Layout layout;
  /// Cell size (m).
  double h = 0;

  /// Body at each cell's centre, by slot.
  std::vector<CellOwner> owner;
  /// Slots of the covered cells, by body. [bodies + 1]: a body's first in `covered`.
  std::vector<std::ptrdiff_t> covered;
  std::vector<int> covered_start;
  long fluid_cells = 0;

  /// Links by body. [bodies + 1]: a body's first in `links`.
  std::vector<FluidLink> links;
  std::vector<int> link_start;
  /// Copies of the links by the row of their cell, in each row by cell. [ny + 1]: a row's first in `row_links`.
  std::vector<RowLink> row_links;
  std::vector<int> row_start;
  std::vector<CrossGradient> cross_gradients;
  /// Between bodies of different groups.
  std::vector<PairLink> pairs;
  std::vector<SideLink> side_links;
  EliminatedCells eliminated;

  /// Sum of each fluid cell's conductances, by slot; 0 in covered cells and padding.
  std::vector<double> diagonal;
  FaceConductances faces;

  /// The problem's couplings as conductances: between floating groups, and from one to a group of given potential.
  /// Couplings of absorbed groups are left out.
  std::vector<NetworkLink> couplings;
  std::vector<FixedCoupling> fixed_couplings;

  /// Absorbed groups; the first `newly_absorbed` have an unknown on the next finer grid.
  std::vector<AbsorbedGroup> absorbed;
  int newly_absorbed = 0;
  /// By group; empty: no group is absorbed.
  std::vector<char> is_absorbed;
};

}  // namespace lichtenberg::laplace
