#pragma once

#include <cstdint>
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
  /// Calls effect(cell, first, end, 1 / diagonal) for the listed cells of a colour (0: red, 1: black) in row j. `cell`:
  /// memory index. The cell's links to floating groups (bodies with one unknown potential) have the indices `first` to
  /// `end` - 1 in LinkLists.
  template <class Effect>
  void for_each(int colour, int j, const Effect& effect) const {
    const auto& [start, black, end, first_link] = rows_[j];
    int link = colour == 0 || black == start ? first_link : cells_[black - 1].links_end;
    for (int k = colour == 0 ? start : black; k < (colour == 0 ? black : end); ++k) {
      effect(cells_[k].cell, link, cells_[k].links_end, cells_[k].inverse_diagonal);
      link = cells_[k].links_end;
    }
  }
  /// Returns the number of listed cells in own rows.
  std::size_t size() const { return size_; }

 private:
  struct Cell {
    std::int32_t cell;
    int links_end;
    double inverse_diagonal;
  };
  /// Indices of a row's cells in cells_: its first cell, its first black cell, and its end. `first_link`: index of the
  /// row's first link (conductance to a conductor) in LinkLists.
  struct Row {
    int start, black, end, first_link;
  };
  void list_row(const Level& level, const LinkLists<double>& links, int j);

  std::vector<Row> rows_;
  // Memory for one cell per link of a row.
  std::vector<Cell> cells_;
  std::size_t size_ = 0;
};

}  // namespace lichtenberg::laplace
