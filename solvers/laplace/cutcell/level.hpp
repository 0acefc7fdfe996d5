#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/laplace/cutcell/bound_cells.hpp"
#include "solvers/laplace/cutcell/cover.hpp"
#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/link_batch.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"
#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Fluid cell to conductor.
struct FluidLink {
  std::ptrdiff_t cell;  ///< slot in the layout
  int body;             ///< on a coarse grid that of a group's thin conductors which comes first, for all of them
  double conductance;
  Vec2 gradient;  ///< with respect to the body's position, per cell
};

/// A fluid link as loops over rows of cells need it, all in one place.
struct RowLink {
  std::int32_t cell;  ///< slot in the layout
  std::int32_t body;
  double conductance;
  std::int32_t link;  ///< index among the links by body
};

/// What a link's conductance gains when a body other than its own moves (see squeeze).
struct CrossGradient {
  int link;  ///< index of the link
  int body;
  Vec2 gradient;
};

/// Conductor to conductor in the next cell.
struct PairLink {
  int body_a, body_b;
  double conductance;
  Vec2 gradient_a, gradient_b;
};

/// Fluid cell or conductor to an electrode side of the box. `body` is -1 for a fluid cell, `cell` -1 for a body.
struct SideLink {
  std::ptrdiff_t cell;
  int body;
  int side;
  double conductance;
  double potential;  ///< V, of the side at this face
  Vec2 gradient;     ///< of the conductance, with respect to the body's position, per cell
};

/// A floating group's coupling to a fixed group, one of given potential: a resistor to a supply.
struct FixedCoupling {
  int group;
  double conductance;
  double potential;  ///< V
  /// What the preconditioner takes for it. Couplings that are all that grounds the field may be weak by any factor, and
  /// a cycle in single precision needs a ground to stand on. For residuals that sum to zero, as they do
  /// then (CutCellOperator::level_out), it makes no difference how strong a lone one is.
  double conductance_in_cycle;
};

/// Sets of groups that a coarse grid treats like one (homogenize.cpp).
struct Sets;

/// A floating group that is no unknown of a coarse grid: it takes part in the potential at its centre, which is
/// interpolated between four cells.
struct AbsorbedGroup {
  int group;
  std::array<std::ptrdiff_t, 4> cell;
  std::array<float, 4> weight;
};

/// The discretized geometry on one grid: which body covers each cell and the links between cells, conductors and
/// electrode sides. Together with the conductances between neighbouring fluid cells (1, unless `east` and `north` say
/// otherwise) it is the whole linear system.
class Level {
 public:
  /// A grid of nx x ny square cells over the problem's box; `build` or `build_coarse` fills it.
  Level(const LaplaceProblem& problem, int nx, int ny);

  /// Discretizes the problem anew on the finest grid, reusing memory. Throws InputError if the formula cannot do a
  /// shape.
  void build(const LaplaceProblem& problem, LinkFormula formula, parallel::Team& team = parallel::Team::single());
  /// Discretizes the problem on a coarse grid of the preconditioner, which has unknowns only for the conductors that it
  /// resolves: smaller ones are smeared out (homogenize.cpp). `sets` are the groups that it treats like one; `finer` is
  /// the grid of cells half as large, null: nothing is known of one.
  void build_coarse(const LaplaceProblem& problem, LinkFormula formula, const Sets& sets, const Level* finer,
                    parallel::Team& team = parallel::Team::single());

  Layout layout;
  double h = 0;  ///< m

  std::vector<Cover> cover;             ///< by slot
  std::vector<std::ptrdiff_t> covered;  ///< slots of all covered cells, by body
  std::vector<int> covered_start;       ///< [bodies + 1] a body's first in `covered`
  std::vector<std::ptrdiff_t> rim;      ///< covered cells beside one that their body does not cover
  std::vector<FluidLink> links;         ///< by body
  std::vector<int> link_start;          ///< [bodies + 1] a body's first in `links`
  std::vector<RowLink> row_links;       ///< the same by their cell's row, and in it by cell
  std::vector<int> row_start;           ///< [ny + 1] a row's first in `row_links`
  std::vector<CrossGradient> cross_gradients;
  std::vector<PairLink> pairs;  ///< between bodies of different groups
  std::vector<SideLink> side_links;
  BoundCells bound;
  /// What joins groups without a cell between them that has a potential of its own.
  std::vector<NetworkLink> direct_links(const LaplaceProblem& problem) const;
  /// The problem's couplings as conductances: between floating groups, and from one to a fixed group. Those of
  /// groups that this grid has absorbed are left out.
  std::vector<NetworkLink> couplings;
  std::vector<FixedCoupling> fixed_couplings;
  bool is_coupled() const { return !couplings.empty() || !fixed_couplings.empty(); }
  /// Sum of a fluid cell's conductances; 0 in covered cells and padding. By slot.
  std::vector<double> diagonal;
  long fluid_cells = 0;

  /// Conductance of a fluid cell's face to the cell on its right and above it, by slot. Empty: 1 everywhere.
  std::vector<float> east, north;
  /// Groups that this grid has absorbed, those first that the finer grid had not.
  std::vector<AbsorbedGroup> absorbed;
  int newly_absorbed = 0;
  /// Whether a floating group has a potential of its own on this grid.
  bool has_unknown(int group) const { return is_absorbed_.empty() || !is_absorbed_[group]; }

  friend void build_by_apertures(const LaplaceProblem& problem, Level& level);

 private:
  using Cell = CellIndex;
  /// A disk that covers no cell's centre, in a cell that belongs to another body.
  struct SharedCell {
    int body, owner;
  };
  /// Columns of a row, both included; none if the last is left of the first.
  struct Columns {
    int from = 0, to = -1;
  };
  /// Some rows of what a body may cover.
  struct Piece {
    int body;
    CellRange range;
    int first_row;               ///< its first in `columns_`
    int covered = 0, links = 0;  ///< how many
  };
  /// A body's links of a part that have no conductance yet.
  struct PendingLinks {
    LinkBatch batch;
    std::array<int, LinkBatch::width> link;
    int count = 0;
  };
  /// A part's link whose fluid cell has the conductor `other`, of another group, on its other side. `cell` is the
  /// body's, e the direction to the fluid one.
  struct OppositeLink {
    int link;
    Cell cell;
    Vec2 e;
    int other;
  };
  /// Consecutive pieces, the work of one thread, and what it makes of them.
  struct Part {
    int from_piece, to_piece;
    std::vector<std::ptrdiff_t> covered, rim;
    std::vector<FluidLink> links;
    std::vector<int> link_row;
    std::vector<CrossGradient> cross_gradients;  // `link` counts from the part's first
    std::vector<PairLink> pairs;
    PendingLinks pending;                // of one body
    std::vector<OppositeLink> opposite;  // of one body
  };
  void discretize(const LaplaceProblem& problem, LinkFormula formula, parallel::Team& team);
  void divide(int threads);
  void cover_cells(parallel::Team& team);
  void claim(const Piece& piece, bool alone);
  bool has_cell(int body) const;
  void take_cell(int body);
  void link_part(const LaplaceProblem& problem, LinkFormula formula, Part& part);
  void link_piece(const LaplaceProblem& problem, LinkFormula formula, const Piece& piece, Part& part);
  void link_columns(const LaplaceProblem& problem, LinkFormula formula, int j, Columns columns, int body, Part& part);
  Columns columns_of(const Piece& piece, int j) const;
  Columns inner_columns(const Piece& piece, int j) const;
  std::array<std::ptrdiff_t, 4> slots_beside(int i, int j) const;
  void link_cell(const LaplaceProblem& problem, LinkFormula formula, Cell cell,
                 const std::array<std::ptrdiff_t, 4>& beside, int body, Part& part);
  bool takes_batches(int body, LinkFormula formula) const;
  void add_pending(int link, Vec2 centre, Vec2 e, int body, Part& part) const;
  void link_batch(int body, Part& part) const;
  void squeeze_links(int body, Part& part) const;
  void join_parts(parallel::Team& team);
  void sort_by_row(parallel::Team& team);
  void sort_row(int j, std::vector<int>& place, std::vector<RowLink>& sorted);
  void sum_diagonal(parallel::Team& team);
  void link_shared_cell(const LaplaceProblem& problem, SharedCell cell);
  void link_sides(const LaplaceProblem& problem);
  void find_bound_cells(const LaplaceProblem& problem, parallel::Team& team);
  void bind_cell(const LaplaceProblem& problem, int j, std::span<const RowLink> of_cell, BoundCells& found) const;
  void couple(const LaplaceProblem& problem, double largest);
  void choose_resolved(const LaplaceProblem& problem, const Sets& sets);
  void inherit_pairs(const LaplaceProblem& problem, const Level& finer);
  void absorb_groups(const LaplaceProblem& problem, const Sets& sets, const Level* finer);
  std::vector<float> effective_permittivity(const LaplaceProblem& problem) const;
  void fill_fluid(const std::vector<float>& permittivity, parallel::Team& team);
  void list_thin_conductors(const LaplaceProblem& problem);
  void link_thin_conductors(const LaplaceProblem& problem, int group, Part& part) const;
  bool resolves(int body) const { return is_resolved_.empty() || is_resolved_[body]; }
  Vec2 centre(Cell c) const { return cell_centre(c.i, c.j); }
  bool inside(Cell c) const { return laplace::inside(layout, c.i, c.j); }

  std::vector<Outline> outlines_;       // of the bodies
  std::vector<char> is_resolved_;       // by body; empty: all are
  std::vector<char> is_absorbed_;       // by group; empty: none is
  std::vector<int> thin_, thin_start_;  // thin conductors by group; [groups + 1] a group's first
  std::vector<Piece> pieces_;           // by body
  std::vector<Columns> columns_;        // of each piece's rows: between these lies all that its body covers
  std::vector<Part> parts_;
  int part_count_ = 0;  // parts_ keeps its memory
  std::vector<int> link_row_;
  std::vector<SharedCell> shared_cells_;
};

}  // namespace lichtenberg::laplace
