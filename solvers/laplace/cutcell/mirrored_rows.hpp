#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

/// Potentials of a grid in rows and columns with a border of mirror images, as source of the interpolation to the next
/// finer grid. In a slab, the rows are the own ones and `ghosts` on either side.
class MirroredRows {
 public:
  /// Reserves memory for the cells of the grid `layout` and a border of mirror images.
  explicit MirroredRows(const Layout& layout) : stride_(layout.nx + 2 * Layout::pad), rows_(layout.extended(ghosts)) {
    parallel::resize_in_huge_pages(value_, (rows_.count() + 2) * stride_);
  }
  /// Number of ghost rows from which the finer grid's own and ghost rows are interpolated.
  static constexpr int ghosts = 3;

  /// Returns a pointer to the potentials of row j (-1 to ny), to be indexed by the column (-1 to nx).
  const float* row(int j) const { return &value_[(j + 1 - rows_.begin) * stride_ + Layout::pad]; }

  /// Copies the potentials v, by slot (memory index), and computes the border of mirror images. Images beyond a side
  /// are multiplied by sign[side]: -1 for an odd continuation, +1 for an even one.
  void assign(const std::vector<float>& v, const std::array<float, 4>& sign, const Layout& layout,
              parallel::Team& team) {
    const auto write_row = [&](int j, int from, float row_sign) {
      float* to = &value_[(j + 1 - rows_.begin) * stride_ + Layout::pad];
      for (int colour = 0; colour < 2; ++colour) {
        const float* v_row = &v[layout.row(colour, from)];
        const int parity = Layout::parity(colour, from);
        for (int k = 0; k < layout.row_length(colour, from); ++k) to[2 * k + parity] = row_sign * v_row[k];
      }
      to[-1] = sign[left] * to[0];
      to[layout.nx] = sign[right] * to[layout.nx - 1];
    };
    for_each_row(team, layout, rows_, [&](int j) { write_row(j, j, 1.0f); });
    if (rows_.begin == 0) write_row(-1, 0, sign[bottom]);
    if (rows_.end == layout.ny) write_row(layout.ny, layout.ny - 1, sign[top]);
  }

 private:
  std::ptrdiff_t stride_;
  Rows rows_;
  std::vector<float> value_;
};

}  // namespace lichtenberg::laplace
