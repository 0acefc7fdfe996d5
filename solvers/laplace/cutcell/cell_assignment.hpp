#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Range of columns in a row, both ends included; empty if `to` is less than `from`.
struct Columns {
  int from = 0, to = -1;
};

/// Rows of the cells that a body may cover: the unit of work of a grid's set-up.
struct BodyPiece {
  int body;
  CellRange range;
  /// Index of its first row among the rows of all pieces.
  int first_row;
};

/// Disk that covers no cell centre and whose centre lies in a cell of another body.
struct SharedCell {
  int body, owner;
};

/// Assigns a grid's cells to the bodies that cover them. Keeps the division of bodies into pieces, and of pieces into
/// parts of approximately equal work, for the computation of the links.
class CellAssignment {
 public:
  /// Sets `level.owner`. If several bodies cover a cell's centre, the first in the problem's order gets the cell.
  void assign(const GridBodies& bodies, Level& level, parallel::Team& team);

  int parts() const { return static_cast<int>(part_start_.size()) - 1; }
  /// Pieces in the order of the bodies; a part's pieces are consecutive.
  std::span<const BodyPiece> pieces() const { return pieces_; }
  std::span<const BodyPiece> pieces(int part) const {
    return pieces().subspan(part_start_[part], part_start_[part + 1] - part_start_[part]);
  }
  /// Columns of row j that contain all the cells of the piece's body; empty for rows outside the piece.
  Columns columns(const BodyPiece& piece, int j) const {
    if (j < piece.range.from_j || j > piece.range.to_j) return {};
    return columns_[piece.first_row + j - piece.range.from_j];
  }
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
