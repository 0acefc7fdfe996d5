#include "solvers/laplace/cutcell/edge_cells.hpp"

namespace lichtenberg::laplace {

void EdgeCells::build(const Level& level, const LinkLists<double>& links, parallel::Team& team) {
  const int rows = level.layout.ny, chunks = 4 * team.size();
  rows_.resize(rows);
  cells_.resize(level.row_links.size());
  team.for_each(chunks, [&](int k) {
    for (int j = rows * k / chunks; j < rows * (k + 1) / chunks; ++j) list_row(level, links, j);
  });
  size_ = 0;
  for (int j = level.layout.own.begin; j < level.layout.own.end; ++j) size_ += rows_[j].end - rows_[j].start;
}

void EdgeCells::list_row(const Level& level, const LinkLists<double>& links, int j) {
  Row& row = rows_[j];
  row.start = row.black = row.end = level.row_start[j];
  row.first_link = links.row_start(j);
  int link = row.first_link;
  for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m) {
    const std::int32_t cell = level.row_links[m].cell;
    if (row.end > row.start && cells_[row.end - 1].cell == cell) continue;
    while (link < links.row_end(j) && links.cell(link) == cell) ++link;
    if (cell < level.layout.colour_size()) ++row.black;
    cells_[row.end++] = {cell, link, 1 / level.diagonal[cell]};
  }
}

}  // namespace lichtenberg::laplace
