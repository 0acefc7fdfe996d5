#include "solvers/laplace/cutcell/edge_cells.hpp"

namespace lichtenberg::laplace {

void EdgeCells::build(const Level& level, const LinkLists<double>& links, parallel::Team& team) {
  const int rows = level.layout.ny, chunks = 4 * team.size();
  rows_.resize(rows);
  cells_.resize(level.row_links.size() + 1);  // one more, so that the end of the last row is a valid reference
  cell_of_link_.resize(level.row_links.size());
  team.for_each(chunks, [&](int k) {
    for (int j = rows * k / chunks; j < rows * (k + 1) / chunks; ++j) list_row(level, links, j);
  });
  size_ = 0;
  for (const Row& row : rows_) size_ += row.end - row.start;
}

void EdgeCells::list_row(const Level& level, const LinkLists<double>& links, int j) {
  Row& row = rows_[j];
  row.start = row.black = row.end = level.row_start[j];
  row.first_link = row.black_link = row.links_end = links.row_start(j);
  for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m) {
    const std::int32_t cell = level.row_links[m].cell;
    if (row.end > row.start && cells_[row.end - 1].cell == cell) continue;
    for (; row.links_end < links.row_end(j) && links.cell(row.links_end) == cell; ++row.links_end)
      cell_of_link_[row.links_end] = row.end;
    cells_[row.end++] = {cell, 1 / level.diagonal[cell]};
    if (cell < level.layout.colour_size()) row.black = row.end, row.black_link = row.links_end;
  }
}

}  // namespace lichtenberg::laplace
