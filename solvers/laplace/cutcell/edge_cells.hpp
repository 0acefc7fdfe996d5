#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// Fluid cells of the finest grid next to conductors, for local relaxation of the initial guess. These are all cells
/// with links (conductances to conductors), including cells with links to conductors of given potential only.
class EdgeCells {
 public:
  /// Lists the fluid cells with links to conductors, by row and colour. `links`: the same grid's links to floating
  /// groups (bodies with one unknown potential).
  void build(const Level& level, const LinkLists<double>& links, parallel::Team& team);
  /// Listed cell.
  struct Cell {
    /// Slot (memory index).
    std::int32_t cell;
    /// 1 / diagonal of its equation.
    double inverse_diagonal;
  };
  /// Returns the listed cells of a colour (0: red, 1: black) in row j.
  std::span<const Cell> cells(int colour, int j) const {
    const auto& [start, black, end, first_link, black_link, links_end] = rows_[j];
    return {&cells_[colour == 0 ? start : black], &cells_[colour == 0 ? black : end]};
  }
  /// Calls effect(link, cell) for the links to floating groups of the cells of a colour in row j. `link`: index in
  /// LinkLists; `cell`: index in cells(). A floating group is a set of bodies with one unknown potential.
  template <class Effect>
  void for_each_link(int colour, int j, const Effect& effect) const {
    const auto& [start, black, end, first_link, black_link, links_end] = rows_[j];
    const int first = colour == 0 ? start : black;
    for (int m = colour == 0 ? first_link : black_link; m < (colour == 0 ? black_link : links_end); ++m)
      effect(m, cell_of_link_[m] - first);
  }
  /// Returns the number of listed cells.
  std::size_t size() const { return size_; }

 private:
  /// Indices of a row in cells_: its first cell, its first black cell, its end. Then those of its links in the
  /// LinkLists: the first, the first of a black cell, the end.
  struct Row {
    int start, black, end, first_link, black_link, links_end;
  };
  void list_row(const Level& level, const LinkLists<double>& links, int j);

  std::vector<Row> rows_;
  // Memory for one cell per link of a row, and by link of the LinkLists the index of its cell.
  std::vector<Cell> cells_;
  std::vector<int> cell_of_link_;
  std::size_t size_ = 0;
};

}  // namespace lichtenberg::laplace
