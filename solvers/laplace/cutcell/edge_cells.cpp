#include "solvers/laplace/cutcell/edge_cells.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

namespace {

/// Calls effect(i) for the cells of row j that lie beside electrodes; a cell in a corner may come twice.
template <class Effect>
void for_cells_beside(const std::array<bool, 4>& is_electrode, const Layout& at, int j, const Effect& effect) {
  if ((j == 0 && is_electrode[bottom]) || (j == at.ny - 1 && is_electrode[top]))
    for (int i = 0; i < at.nx; ++i) effect(i);
  if (is_electrode[left]) effect(0);
  if (is_electrode[right]) effect(at.nx - 1);
}

}  // namespace

void EdgeCells::build(const LaplaceProblem& problem, const Level& level, const LinkLists<double>& links,
                      parallel::Team& team) {
  const Layout& at = level.layout;
  for (int side = 0; side < 4; ++side) is_electrode_[side] = problem.sides[side].kind == Side::Kind::electrode;
  rows_.resize(at.ny);
  int room = 0;
  for (int j = 0; j < at.ny; ++j) {
    rows_[j].start = room;
    room += level.row_start[j + 1] - level.row_start[j];
    for_cells_beside(is_electrode_, at, j, [&](int) { ++room; });
  }
  cells_.resize(room);
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int k) {
    for (int j = at.ny * k / chunks; j < at.ny * (k + 1) / chunks; ++j) list_row(level, links, j);
  });
  size_ = 0;
  for (const Row& row : rows_) size_ += row.end - row.start;
}

void EdgeCells::list_row(const Level& level, const LinkLists<double>& links, int j) {
  Row& row = rows_[j];
  row.black = row.end = row.start;
  row.first_link = links.row_start(j);
  thread_local std::vector<std::int32_t> cells;
  cells.clear();
  for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m) cells.push_back(level.row_links[m].cell);
  const std::size_t linked = cells.size();
  for_cells_beside(is_electrode_, level.layout, j, [&](int i) {
    const std::ptrdiff_t slot = level.layout(i, j);
    if (level.diagonal[slot] > 0) cells.push_back(static_cast<std::int32_t>(slot));
  });
  if (cells.size() > linked) std::sort(cells.begin(), cells.end());
  int link = row.first_link;
  for (const std::int32_t cell : cells) {
    if (row.end > row.start && cells_[row.end - 1].cell == cell) continue;
    while (link < links.row_end(j) && links.cell(link) == cell) ++link;
    if (cell < level.layout.colour_size()) ++row.black;
    cells_[row.end++] = {cell, link};
  }
}

}  // namespace lichtenberg::laplace
