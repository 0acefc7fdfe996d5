#include "src/analysis/close_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::analysis {
namespace {

/// Points sorted into square cells at least `reach` wide, so that partners stand in the same or an adjacent cell.
class CellList {
 public:
  CellList(std::span<const Vec2> points, double reach) {
    Vec2 high = low_ = points[0];
    for (const Vec2 p : points) {
      low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    // No more cells than points, or a short reach in a wide field would cost memory for nothing.
    const Vec2 extent = high - low_;
    const double n = static_cast<double>(points.size());
    side_ = std::max({reach, std::sqrt(extent.x * extent.y / n), std::max(extent.x, extent.y) / n});
    nx_ = static_cast<int>(extent.x / side_) + 1;
    ny_ = static_cast<int>(extent.y / side_) + 1;
    sort(points);
  }

  /// Calls visit(j) for every point j in the cells around p.
  template <class Visit>
  void for_each_near(Vec2 p, Visit visit) const {
    const int cx = column(p), cy = row(p);
    for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, ny_ - 1); ++y)
      for (int x = std::max(cx - 1, 0); x <= std::min(cx + 1, nx_ - 1); ++x)
        for (int k = start_[y * nx_ + x]; k < start_[y * nx_ + x + 1]; ++k) visit(order_[k]);
  }

 private:
  int column(Vec2 p) const { return static_cast<int>((p.x - low_.x) / side_); }
  int row(Vec2 p) const { return static_cast<int>((p.y - low_.y) / side_); }

  /// Counting sort: cell c holds order_[start_[c]] ... order_[start_[c + 1] - 1].
  void sort(std::span<const Vec2> points) {
    start_.assign(static_cast<size_t>(nx_) * ny_ + 1, 0);
    for (const Vec2 p : points) ++start_[row(p) * nx_ + column(p) + 1];
    for (size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    std::vector<int> next(start_.begin(), start_.end() - 1);
    order_.resize(points.size());
    for (size_t i = 0; i < points.size(); ++i)
      order_[next[row(points[i]) * nx_ + column(points[i])]++] = static_cast<int>(i);
  }

  Vec2 low_;
  double side_ = 0;
  int nx_ = 0, ny_ = 0;
  std::vector<int> start_, order_;
};

}  // namespace

std::vector<std::pair<int, int>> close_pairs(std::span<const Vec2> points, double reach) {
  std::vector<std::pair<int, int>> pairs;
  if (points.empty() || !(reach > 0)) return pairs;
  const CellList cells(points, reach);
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    cells.for_each_near(points[i], [&](int j) {
      if (j > i && norm2(points[j] - points[i]) < reach * reach) pairs.emplace_back(i, j);
    });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace lichtenberg::analysis
