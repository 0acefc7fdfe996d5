#pragma once

#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// Fluid cells of the finest grid that have links to conductors, including conductors of given potential, whose links
/// are not in the lists.
class EdgeCells {
 public:
  /// Lists the cells at conductors. `links`: the level's lists.
  void build(const Level& level, const LinkLists<double>& links, parallel::Team& team);
  /// Calls effect(cell, first, end, 1 / diagonal) for the cells of a colour in row j. The cell's links to floating
  /// groups have the indices from `first` to `end` - 1 in the lists.
  template <class Effect>
  void for_each(int colour, int j, const Effect& effect) const {
    const auto& [start, black, end, first_link] = rows_[j];
    int link = colour == 0 || black == start ? first_link : cells_[black - 1].links_end;
    for (int k = colour == 0 ? start : black; k < (colour == 0 ? black : end); ++k) {
      effect(cells_[k].cell, link, cells_[k].links_end, cells_[k].inverse_diagonal);
      link = cells_[k].links_end;
    }
  }
  std::size_t size() const { return size_; }

 private:
  struct Cell {
    std::int32_t cell;
    int links_end;
    double inverse_diagonal;
  };
  /// Indices in cells_: a row's first cell, its first black cell, and the end. Also the row's first link.
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
