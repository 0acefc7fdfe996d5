#include "solvers/network/spatial_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

/// Cubic cells of some dozen points in Morton's order, which interleaves the bits of the indices along the axes.
class MortonCells {
 public:
  explicit MortonCells(const std::vector<Point>& position) : low_(position.front()) {
    Point high = low_;
    for (const Point& p : position)
      for (int axis = 0; axis < 3; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, high[axis] - low_[axis]);
    for (int axis = 0; axis < 3; ++axis)
      if (high[axis] - low_[axis] > 1e-3 * longest) axes_[dimensions_++] = axis;
    constexpr double points_a_cell = 64;
    if (dimensions_ > 0)
      bits_ = std::clamp(
          static_cast<int>(std::log2(static_cast<double>(position.size()) / points_a_cell) / dimensions_) + 1, 1, 8);
    cells_a_metre_ = longest > 0 ? (1 << bits_) * (1 - 1e-12) / longest : 0;
  }

  int number() const { return 1 << (bits_ * dimensions_); }
  int of(const Point& p) const {
    std::uint32_t cell = 0;
    for (int k = 0; k < dimensions_; ++k) {
      const auto at = static_cast<std::uint32_t>((p[axes_[k]] - low_[axes_[k]]) * cells_a_metre_);
      for (int bit = 0; bit < bits_; ++bit) cell |= (at >> bit & 1) << (bit * dimensions_ + k);
    }
    return static_cast<int>(cell);
  }

 private:
  Point low_;
  std::array<int, 3> axes_{};
  int dimensions_ = 0, bits_ = 0;
  double cells_a_metre_ = 0;
};

}  // namespace

std::vector<int> spatial_order(const std::vector<Point>& position, parallel::Team& team) {
  if (position.empty()) return {};
  const MortonCells cells(position);
  std::vector<int> start(cells.number() + 1, 0), cell(position.size()), order(position.size());
  parallel::for_each_range(position.size(), team, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) cell[i] = cells.of(position[i]);
  });
  for (const int c : cell) ++start[c + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  for (std::size_t i = 0; i < cell.size(); ++i) order[start[cell[i]]++] = static_cast<int>(i);
  return order;
}

}  // namespace lichtenberg::network
