#include "solvers/laplace/cutcell/cell_assignment.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

namespace lichtenberg::laplace {

void GridBodies::assign(const LaplaceProblem& problem, double h) {
  outlines.clear();
  for (const Body& body : problem.bodies) outlines.push_back(outline_in_cells(body, h));
  is_resolved.clear();
}

void CellAssignment::assign(const GridBodies& bodies, Level& level, parallel::Team& team) {
  divide(bodies, level.layout, team.size());
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int k) {
    const std::ptrdiff_t size = level.layout.size();
    std::fill(level.owner.begin() + size * k / chunks, level.owner.begin() + size * (k + 1) / chunks, CellOwner());
  });
  team.for_each(parts(), [&](int part) {
    for (const BodyPiece& piece : pieces(part))
      if (bodies.resolves(piece.body)) claim(piece, bodies.outlines[piece.body], team.size() == 1, level);
  });
  assign_small_disks(bodies, level);
}

namespace {

/// Returns the rows of the range that this process stores.
CellRange stored_part(CellRange range, const Layout& layout) {
  range.from_j = std::max(range.from_j, layout.stored.begin);
  range.to_j = std::min(range.to_j, layout.stored.end - 1);
  return range;
}

}  // namespace

/// Divides large bodies into pieces of 64 rows, and joins pieces to parts of at least 4096 cells. A single thread gets
/// one part. All subgrid conductors of a group belong to the part of the first of them; they take a small share of the
/// set-up.
void CellAssignment::divide(const GridBodies& bodies, const Layout& layout, int threads) {
  constexpr int rows_a_piece = 64;
  const long cells_a_part = threads == 1 ? std::numeric_limits<long>::max() : 4096;
  pieces_.clear();
  part_start_.clear();
  int rows = 0;
  long cells = cells_a_part;
  for (int body = 0; body < static_cast<int>(bodies.outlines.size()); ++body) {
    CellRange all = cells_around(bodies.outlines[body], layout.nx, layout.ny);
    if (bodies.resolves(body)) all = stored_part(all, layout);
    for (int j = all.from_j; j <= all.to_j; j += rows_a_piece) {
      const CellRange range{all.from_i, all.to_i, j, std::min(j + rows_a_piece - 1, all.to_j)};
      if (cells >= cells_a_part) {
        part_start_.push_back(static_cast<int>(pieces_.size()));
        cells = 0;
      }
      pieces_.push_back({body, range, rows});
      rows += range.to_j - range.from_j + 1;
      cells += (range.to_i - range.from_i + 1) * (range.to_j - range.from_j + 1);
    }
  }
  part_start_.push_back(static_cast<int>(pieces_.size()));
  columns_.resize(rows);
}

/// Assigns the cells whose centres the piece's body covers, except those that bodies before it cover. `is_alone`: no
/// other thread assigns cells at the same time.
void CellAssignment::claim(const BodyPiece& piece, const Outline& outline, bool is_alone, Level& level) {
  const bool convex = outline.kind == Outline::Kind::disk, curve = outline.kind == Outline::Kind::curve;
  std::vector<char> covered;  // by column, of a curve
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    auto& [from, to] = columns_[piece.first_row + j - piece.range.from_j];
    from = piece.range.from_i, to = piece.range.to_i;
    if (curve) covered_columns(outline, j, from, to, covered);
    // Between its first and its last covered cell a disk's row is covered completely. Rounding does not change this,
    // because the rounded square increases with its argument.
    while (convex && from <= to && !covers(outline, from, j)) ++from;
    while (convex && from <= to && !covers(outline, to, j)) --to;
    for (int i = from; i <= to; ++i) {
      if (curve ? !covered[i - piece.range.from_i] : !convex && !covers(outline, i, j)) continue;
      CellOwner& cell = level.owner[level.layout(i, j)];
      if (is_alone) {
        if (cell.is_fluid()) cell = CellOwner::by(piece.body);
        continue;
      }
      const std::atomic_ref<CellOwner> shared(cell);
      CellOwner current = shared.load(std::memory_order_relaxed);
      while ((current.is_fluid() || piece.body < current.body()) &&
             !shared.compare_exchange_weak(current, CellOwner::by(piece.body), std::memory_order_relaxed)) {
      }
    }
  }
}

namespace {

CellIndex cell_of_centre(const Outline& outline, const Layout& layout) {
  return {cell_at(outline.centre.x, layout.nx), cell_at(outline.centre.y, layout.ny)};
}

/// Returns true if the disk has a cell, or if its rows are not all stored. In the second case the disk is larger than a
/// cell and covers one, unless others cover it completely.
bool has_cell(int body, const Outline& outline, const Level& level) {
  const Layout& layout = level.layout;
  const CellRange range = cells_around(outline, layout.nx, layout.ny);
  if (range.from_j < layout.stored.begin || range.to_j >= layout.stored.end) return true;
  const auto [i_centre, j_centre] = cell_of_centre(outline, layout);
  if (level.owner[layout(i_centre, j_centre)].is(body)) return true;
  for (int j = range.from_j; j <= range.to_j; ++j)
    for (int i = range.from_i; i <= range.to_i; ++i)
      if (level.owner[layout(i, j)].is(body)) return true;
  return false;
}

}  // namespace

/// Assigns a cell to each resolved disk that covers no cell centre: the cell that contains the disk's centre. The
/// log-fitted link remains correct, because it depends on the radius of the disk. If the cell has an owner, the disk is
/// linked to it.
void CellAssignment::assign_small_disks(const GridBodies& bodies, Level& level) {
  shared_cells_.clear();
  for (int body = 0; body < static_cast<int>(bodies.outlines.size()); ++body) {
    const Outline& outline = bodies.outlines[body];
    if (outline.kind != Outline::Kind::disk || !bodies.resolves(body) || has_cell(body, outline, level)) continue;
    const CellIndex index = cell_of_centre(outline, level.layout);
    CellOwner& cell = level.owner[level.layout(index.i, index.j)];
    if (cell.is_fluid()) {
      cell = CellOwner::by(body);
      extend_columns(body, index);
    } else {
      shared_cells_.push_back({body, cell.body(), index.j});
    }
  }
}

/// Extends the columns of the body's pieces so that they contain the cell.
void CellAssignment::extend_columns(int body, CellIndex cell) {
  const auto first_piece = std::ranges::lower_bound(pieces_, body, {}, &BodyPiece::body);
  const auto piece =
      std::find_if(first_piece, pieces_.end(), [&](const BodyPiece& p) { return cell.j <= p.range.to_j; });
  auto& [from, to] = columns_[piece->first_row + cell.j - piece->range.from_j];
  const bool is_first = from > to;
  from = is_first ? cell.i : std::min(from, cell.i);
  to = is_first ? cell.i : std::max(to, cell.i);
}

}  // namespace lichtenberg::laplace
