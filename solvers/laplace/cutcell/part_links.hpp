#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "solvers/laplace/cutcell/cell_assignment.hpp"
#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/link_batch.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Inputs of the computation of a grid's links (conductances between cells and conductors). `assignment` must have set
/// the cell owners in `level`.
struct LinkInputs {
  const LaplaceProblem& problem;
  LinkFormula formula;
  const GridBodies& bodies;
  const CellAssignment& assignment;
  const Level& level;
};

/// Covered cells (inside conductors) and links (conductances) of the bodies of one part, in the order of the part's
/// pieces. A part is a task of the parallel set-up. A piece is a range of rows of one body.
struct PartLinks {
  struct PieceCounts {
    int covered, links;
  };
  /// Removes all entries and keeps the memory.
  void clear();

  /// Number of covered cells and of links to fluid cells, by piece.
  std::vector<PieceCounts> counts;
  std::vector<std::ptrdiff_t> covered;
  std::vector<FluidLink> links;
  /// Row of the fluid cell of each link.
  std::vector<int> link_row;
  /// Derivatives with respect to bodies on the other side of a gap. CrossGradient::link counts from the part's first
  /// link.
  std::vector<CrossGradient> cross_gradients;
  /// Points of attack of the links to closed curves. LinkArm::link counts from the part's first link.
  std::vector<LinkArm> arms;
  std::vector<PairLink> pairs;
};

/// Computation of the links (conductances) of the bodies in one part, a task of the parallel set-up. They are links to
/// fluid cells, and direct links (gap conductances) to other conductors.
class PartLinker {
 public:
  /// Prepares the computation of links (conductances between cells and conductors). `links` receives the results. All
  /// arguments must outlive this object.
  PartLinker(const LinkInputs& inputs, PartLinks& links);
  /// Computes the covered cells (inside conductors) and the links (conductances) of the bodies in part number `part`, a
  /// task of the parallel set-up. Large bodies may be divided among parts.
  void link(int part);

 private:
  /// Links whose conductances are computed together once the batch is full or the part's links are complete. `link`:
  /// indices in PartLinks::links.
  struct PendingLinks {
    LinkBatch batch;
    std::array<int, LinkBatch::width> link;
    int count = 0;
  };
  /// Link whose fluid cell has a conductor of another group (bodies with one potential), the body `other`, on its
  /// opposite side. `cell` is the cell that the link's own body covers, e the direction from it to the fluid cell.
  struct OpposedLink {
    int link;
    CellIndex cell;
    Vec2 e;
    int other;
  };
  void link_piece(const BodyPiece& piece);
  void link_columns(int j, Columns columns);
  void link_cell(CellIndex cell, std::ptrdiff_t slot, const std::array<std::ptrdiff_t, 4>& neighbours);
  void link_fluid_cell(CellIndex cell, int side, std::ptrdiff_t slot, CellOwner opposed);
  void link_conductor(CellIndex cell, Vec2 e, int other);
  void add_pending(int link, const Outline& disk, Vec2 centre, Vec2 e);
  void compute_pending();
  void couple_opposed_surfaces();
  void link_subgrid_conductors(int group);
  Columns inner_columns(const BodyPiece& piece, int j) const;
  bool uses_batches() const;
  int group_of(int body) const { return problem_.bodies[body].group; }
  bool is_inside(CellIndex c) const { return inside(layout_, c.i, c.j); }

  const LaplaceProblem& problem_;
  const LinkFormula formula_;
  const GridBodies& bodies_;
  const CellAssignment& assignment_;
  const std::vector<CellOwner>& owner_;
  const Layout layout_;
  PartLinks& links_;
  // The body whose links are being computed, and whether they are computed in batches.
  int body_ = -1;
  bool in_batches_ = false;
  PendingLinks pending_;
  std::vector<OpposedLink> opposed_;
};

}  // namespace lichtenberg::laplace
