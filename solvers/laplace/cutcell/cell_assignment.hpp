#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Range of columns in a row of cells, both ends included; empty if `to` is less than `from`.
struct Columns {
  int from = 0, to = -1;
};

/// At most 64 rows of the cells that a body may cover: unit of work when a grid is set up.
struct BodyPiece {
  int body;
  CellRange range;
  /// Number of rows in all pieces before this one; the index of its first row in CellAssignment's list of columns.
  int first_row;
};

/// Resolved disk `body` that owns no cell. The cell that contains the disk's centre belongs to another body, `owner`.
struct SharedCell {
  int body, owner;
  /// Row of the cell.
  int row;
};

/// Assignment of a grid's cells to the bodies that cover them, by the cells' centres. Large bodies are divided into
/// pieces (ranges of rows). Consecutive pieces form parts, which are the tasks of parallel loops over bodies. A single
/// thread has one part.
class CellAssignment {
 public:
  /// Computes the owner of each cell, `level.owner`. If several bodies that the grid resolves cover a cell's centre,
  /// the first in the order of `bodies` gets the cell. A resolved disk without a cell then gets the cell that contains
  /// its centre, if that cell is fluid.
  void assign(const GridBodies& bodies, Level& level, parallel::Team& team);

  /// Returns the number of parts. A part is a task of parallel loops: consecutive pieces (ranges of rows of a body).
  int parts() const { return static_cast<int>(part_start_.size()) - 1; }
  /// Returns all pieces (ranges of rows of a body), in the order of the bodies. The pieces of a part are consecutive.
  std::span<const BodyPiece> pieces() const { return pieces_; }
  /// Returns the pieces (ranges of rows of a body) of one part, a task of parallel loops over bodies.
  std::span<const BodyPiece> pieces(int part) const {
    return pieces().subspan(part_start_[part], part_start_[part + 1] - part_start_[part]);
  }
  /// Returns a range of columns that contains all cells of the piece's body in row j; empty for rows outside the piece.
  /// Only for bodies that the grid resolves.
  Columns columns(const BodyPiece& piece, int j) const {
    if (j < piece.range.from_j || j > piece.range.to_j) return {};
    return columns_[piece.first_row + j - piece.range.from_j];
  }
  /// Returns the resolved disks without a cell, whose centre lies in the cell of another body.
  std::span<const SharedCell> shared_cells() const { return shared_cells_; }

 private:
  void divide(const GridBodies& bodies, const Layout& layout, int threads);
  void claim(const BodyPiece& piece, const Outline& outline, bool is_alone, Level& level);
  void assign_small_disks(const GridBodies& bodies, Level& level);
  void extend_columns(int body, CellIndex cell);

  std::vector<BodyPiece> pieces_;
  // By row of each piece.
  std::vector<Columns> columns_;
  // [parts + 1] a part's first piece.
  std::vector<int> part_start_;
  std::vector<SharedCell> shared_cells_;
};

}  // namespace lichtenberg::laplace
