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

/// Link between a fluid cell and a conductor next to it, usually in a neighbouring cell: its conductance per depth and
/// permittivity.
struct FluidLink {
  /// Slot (memory index) of the fluid cell.
  std::ptrdiff_t cell;
  /// Index of the body. All subgrid conductors of a group on a coarse grid share the links of the first of them.
  int body;
  double conductance;
  /// Derivative of the conductance with respect to the body's position (per cell width).
  Vec2 gradient;
};

/// Compact copy of a FluidLink for loops over rows of cells.
struct RowLink {
  /// Slot (memory index) of the fluid cell.
  std::int32_t cell;
  std::int32_t body;
  double conductance;
  /// Index of the link in Level::links.
  std::int32_t link;
};

/// Point of a closed curve on which the derivative of a link acts as a force does (curve_arm in surface_links.hpp). The
/// torque is the cross product of its position and the derivative.
struct LinkArm {
  /// Index of the link in Level::links.
  int link;
  /// Position in cells.
  Vec2 at;
};

/// Derivative of a link's conductance with respect to the position of another body, at the opposite side of the link's
/// fluid cell (correct_for_opposed_surface in surface_links.hpp).
struct CrossGradient {
  /// Index of the link in Level::links.
  int link;
  int body;
  /// Derivative of the link's conductance with respect to the position of `body` (per cell width).
  Vec2 gradient;
  /// LinkArm of `body`.
  Vec2 arm{};
};

/// Direct link between two close conductors of different groups, without a fluid cell between them. The conductance is
/// per depth and permittivity; its derivatives are with respect to the positions of the bodies (per cell width).
struct PairLink {
  int body_a, body_b;
  double conductance;
  Vec2 gradient_a, gradient_b;
  /// LinkArm of both bodies.
  Vec2 arm_a{}, arm_b{};
};

/// Link between an electrode side of the box and a fluid cell or a conductor. For a fluid cell, `cell` is its slot
/// (memory index) and `body` is -1. For a conductor, `cell` is -1.
struct SideLink {
  std::ptrdiff_t cell;
  int body;
  int side;
  double conductance;
  /// Potential of the side at this face (V).
  double potential;
  /// Derivative of the conductance with respect to the body's position (per cell width).
  Vec2 gradient;
  /// LinkArm of the body.
  Vec2 arm{};
};

/// Coupling (lumped capacitance) between a floating group and a group of given potential, as a conductance. A floating
/// group is a set of bodies with one unknown potential.
struct FixedCoupling {
  int group;
  /// Capacitance per permittivity.
  double conductance;
  /// Given potential (V).
  double potential;
  /// Conductance in the preconditioner. It has a lower bound if only such couplings ground the field: a cycle in single
  /// precision needs a ground of sufficient strength. A single one may have any value, because the residuals then sum
  /// to zero (CutCellOperator::fix_potential_level).
  double conductance_in_cycle;
};

/// Floating group (bodies with one potential) without an unknown on a coarse grid, because it is part of the effective
/// medium. Its potential is the bilinear interpolation between four cells at the centre of its agglomerate (groups that
/// coarse grids treat as one). Cells of other processes have the slot 0 and the weight 0.
struct AbsorbedGroup {
  int group;
  std::array<std::ptrdiff_t, 4> cell;
  std::array<float, 4> weight;
};

/// Conductances of the faces between fluid cells (outside all bodies), by slot (memory index): to the cell on the right
/// and to the cell above. Empty vectors mean 1 everywhere.
struct FaceConductances {
  std::vector<float> east, north;

  /// Returns true if all faces have the conductance 1.
  bool are_uniform() const { return east.empty(); }
};

/// Discretized geometry on one grid: the body that covers each cell, and the links (conductances) between cells,
/// conductors and electrode sides. Together with the conductances of the faces it determines the linear system.
/// LevelBuilder fills it.
struct Level {
  /// Makes a grid of nx x ny square cells over the problem's box, without bodies and links (conductances).
  Level(const LaplaceProblem& problem, int nx, int ny) : Level(problem, Layout(nx, ny)) {}
  /// Makes the rows that `at` stores of such a grid.
  Level(const LaplaceProblem& problem, const Layout& at);

  /// Returns true if the potential of a floating group (bodies with one unknown potential) is an unknown of this grid.
  /// A coarse grid may treat a small group as part of an effective medium instead.
  bool has_unknown(int group) const { return is_absorbed.empty() || !is_absorbed[group]; }
  /// Returns true if any floating group (bodies with one unknown potential) is coupled (by a lumped capacitance) to
  /// another one or to a given potential.
  bool is_coupled() const { return !couplings.empty() || !fixed_couplings.empty(); }
  /// Returns the conductances between groups (bodies with one potential) without an unknown cell between them. They are
  /// direct links across gaps, and links that the elimination of near-surface cells makes. (A near-surface cell has a
  /// large conductance to a conductor.)
  std::vector<NetworkLink> direct_links(const LaplaceProblem& problem) const;

  Layout layout;
  /// Cell size (m).
  double h = 0;

  /// Body at each cell's centre, or fluid, by slot.
  std::vector<CellOwner> owner;
  /// Slots of the covered cells, sorted by body. `covered_start` [bodies + 1]: a body's first in `covered`.
  std::vector<std::ptrdiff_t> covered;
  std::vector<int> covered_start;
  /// Number of cells that no body covers, in all processes.
  long fluid_cells = 0;

  /// Links between fluid cells and conductors, sorted by body. `link_start` [bodies + 1]: a body's first in `links`.
  std::vector<FluidLink> links;
  std::vector<int> link_start;
  /// Copies of the links, sorted by the row of their cell and in each row by cell. `row_start` [ny + 1]: a row's first
  /// in `row_links`.
  std::vector<RowLink> row_links;
  std::vector<int> row_start;
  std::vector<CrossGradient> cross_gradients;
  /// Points of attack of the links to closed curves.
  std::vector<LinkArm> arms;
  /// Direct links between bodies of different groups, of all processes.
  std::vector<PairLink> pairs;
  /// Links of cells in stored rows and of bodies in own rows.
  std::vector<SideLink> side_links;
  EliminatedCells eliminated;
  /// Conductances that the elimination adds between two groups, of all processes.
  std::vector<PairLink> eliminated_pairs;

  /// Sum of each fluid cell's conductances (matrix diagonal), by slot; 0 in covered cells and padding.
  std::vector<double> diagonal;
  FaceConductances faces;

  /// The problem's couplings as conductances per permittivity. `couplings`: between two floating groups;
  /// `fixed_couplings`: from a floating group to one of given potential. Couplings of absorbed groups are left out.
  std::vector<NetworkLink> couplings;
  std::vector<FixedCoupling> fixed_couplings;

  /// Groups without an unknown on this grid. The first `newly_absorbed` of them have an unknown on the next finer grid.
  std::vector<AbsorbedGroup> absorbed;
  int newly_absorbed = 0;
  /// Whether each group is absorbed; empty if none is.
  std::vector<char> is_absorbed;
};

}  // namespace lichtenberg::laplace
