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

/// Inputs of the computation of a grid's links. `assignment` has set the level's cell owners.
struct LinkInputs {
  const LaplaceProblem& problem;
  LinkFormula formula;
  const GridBodies& bodies;
  const CellAssignment& assignment;
  const Level& level;
};

/// Covered cells and links of a part's bodies, in the order of its pieces.
struct PartLinks {
  struct PieceCounts {
    int covered, links;
  };
  void clear();

  /// By piece.
  std::vector<PieceCounts> counts;
  std::vector<std::ptrdiff_t> covered;
  std::vector<FluidLink> links;
  /// Row of each link's cell.
  std::vector<int> link_row;
  /// CrossGradient::link counts from the part's first link.
  std::vector<CrossGradient> cross_gradients;
  std::vector<PairLink> pairs;
};

/// Computes the links of one part.
class PartLinker {
 public:
  /// `links` receives the results. All arguments must outlive this object.
  PartLinker(const LinkInputs& inputs, PartLinks& links);
  void link(int part);

 private:
  /// Links of a body that wait for their conductances until a batch is full.
  struct PendingLinks {
    LinkBatch batch;
    std::array<int, LinkBatch::width> link;
    int count = 0;
  };
  /// Link whose fluid cell has a conductor of another group, `other`, on its opposite side. `cell` is the body's cell,
  /// e the direction from it to the fluid cell.
  struct OpposedLink {
    int link;
    CellIndex cell;
    Vec2 e;
    int other;
  };
  void link_piece(const BodyPiece& piece);
  void link_columns(int j, Columns columns);
  void link_cell(CellIndex cell, const std::array<std::ptrdiff_t, 4>& neighbours);
  void link_fluid_cell(CellIndex cell, int side, std::ptrdiff_t slot);
  void link_conductor(CellIndex cell, Vec2 e, int other);
  void add_pending(int link, Vec2 centre, Vec2 e);
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
  // The body whose links are being computed.
  int body_ = -1;
  PendingLinks pending_;
  std::vector<OpposedLink> opposed_;
};

}  // namespace lichtenberg::laplace
