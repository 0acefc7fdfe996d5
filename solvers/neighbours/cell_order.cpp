#include "solvers/neighbours/cell_order.hpp"

#include <algorithm>
#include <cmath>
#include <experimental/simd>
#include <limits>
#include <numeric>

namespace lichtenberg {
namespace {

namespace stdx = std::experimental;
/// Width of the SIMD vectors: usually somewhat more than the number of particles in three cells. It does not affect the
/// result.
constexpr int width = 8;
using SimdPack = stdx::simd<float, stdx::simd_abi::deduce_t<float, width>>;

/// Lane numbers 0, 1, 2 ...
const SimdPack lanes([](int lane) { return static_cast<float>(lane); });

}  // namespace

/// Chooses the cells. There are at most four per particle, so that a single distant particle does not cost memory. A
/// periodic axis has at least three cells, so that no two cells are neighbours twice, or a single one.
template <int d>
void CellOrder<d>::lay_out(const Spheres<d>& spheres) {
  const int n = spheres.size(), most = std::max(1, static_cast<int>(std::pow(4.0 * n, 1.0 / d)));
  double longest = 0;
  needs_nearest_images_ = false;
  for (int k = 0; k < d; ++k) {
    period_[k] = spheres.box.periodic(k) ? spheres.box.lengths[k] : 0;
    low_[k] = 0;
    double length = period_[k];
    if (length == 0) {
      double high = low_[k] = spheres.position[k];
      for (int i = 0; i < n; ++i) {
        low_[k] = std::min(low_[k], spheres.position[i * d + k]);
        high = std::max(high, spheres.position[i * d + k]);
      }
      length = std::max(high - low_[k], range_);
    }
    constexpr double rounding = 1e-9;  // More than the rounding of positions relative to the cells' borders
    count_[k] = static_cast<int>(std::clamp(length / (range_ * (1 + rounding)), 1.0, static_cast<double>(most)));
    if (period_[k] > 0 && count_[k] < 3) count_[k] = 1, needs_nearest_images_ = true;
    cells_a_metre_[k] = count_[k] / length;
    longest = std::max(longest, length);
  }
  // Positions are rounded by up to half of their last digit, and so are the shifts of images.
  position_error_ = 4 * longest * std::numeric_limits<float>::epsilon();
  const double within = (range_ + position_error_) * (1 + 1e-6);
  within_square_ = static_cast<float>(within * within);
}

template <int d>
int CellOrder<d>::column(double x, int k) const {
  return x > 0 ? static_cast<int>(std::min(x * cells_a_metre_[k], count_[k] - 1.0)) : 0;  // Also for NaN
}

template <int d>
void CellOrder<d>::sort(const Spheres<d>& spheres, double range) {
  const int n = spheres.size();
  range_ = range;
  if (n > 0) lay_out(spheres);
  start_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
  for (auto* of : {&cell_, &particle_, &slot_}) of->resize(n);
  wrapped_position_.resize(n);
  for (auto* of : {&position_, &velocity_})
    for (auto& along : *of) along.resize(n + width);
  for (int i = 0; i < n; ++i) {
    int cell = 0;
    for (int k = d - 1; k >= 0; --k) {
      double x = spheres.position[i * d + k] - low_[k];
      if (period_[k] > 0 && !(x >= 0 && x < period_[k])) {
        x -= period_[k] * std::floor(x / period_[k]);
        if (!(x >= 0 && x < period_[k])) x = 0;
      }
      wrapped_position_[i][k] = static_cast<float>(x);
      cell = cell * count_[k] + column(x, k);
    }
    ++start_[(cell_[i] = cell) + 1];
  }
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  // Fills each cell's slots from its start on; afterwards the starts are those of the next cells.
  for (int i = 0; i < n; ++i) {
    const int slot = slot_[i] = start_[cell_[i]]++;
    particle_[slot] = i;
    for (int k = 0; k < d; ++k) position_[k][slot] = wrapped_position_[i][k];
  }
  std::copy_backward(start_.begin(), start_.end() - 1, start_.end());
  start_[0] = 0;
}

/// Returns half of the rows around a row: the other half includes this row among theirs.
template <int d>
auto CellOrder<d>::neighbour_rows(int y, int z) const -> std::vector<Row> {
  std::vector<Row> rows;
  const auto add = [&](int row_y, int row_z) {
    std::array<int, 3> at{0, row_y, row_z};
    Row row;
    for (int k = 1; k < d; ++k) {
      const int image = at[k] < 0 ? -1 : at[k] >= count_[k] ? 1 : 0;
      if (image != 0 && period_[k] == 0) return;
      at[k] -= image * count_[k];
      row.image_shift[k] = static_cast<float>(image * period_[k]);
    }
    row.first = (at[2] * count_[1] + at[1]) * count_[0];
    rows.push_back(row);
  };
  const int half_width = count_[1] > 1 ? 1 : 0;
  if (half_width) add(y + 1, z);
  if (count_[2] > 1)
    for (int step = -half_width; step <= half_width; ++step) add(y + step, z + 1);
  return rows;
}

/// Finds the particles near a slot. `nearest_images`: computes nearest images; otherwise `image_shift` is the shift of
/// the image. `moving`: finds only pairs that may meet. Each vector is computed without branches, because the results
/// are hard to predict.
template <int d>
template <bool nearest_images, bool moving>
[[gnu::always_inline]] inline void CellOrder<d>::search(int slot, const SlotRange& candidates, Near& near) const {
  for (int first = candidates.first; first < candidates.last; first += width) {
    SimdPack square = 0, rate = 0;  // Rate of half the square
    for (int k = 0; k < d; ++k) {
      SimdPack separation =
          SimdPack(&position_[k][first], stdx::element_aligned) - (position_[k][slot] - candidates.image_shift[k]);
      if (nearest_images && period_[k] > 0) {
        const float period = static_cast<float>(period_[k]);
        separation -= period * stdx::nearbyint(separation * (1 / period));
      }
      square += separation * separation;
      if constexpr (moving)
        rate += separation * (SimdPack(&velocity_[k][first], stdx::element_aligned) - velocity_[k][slot]);
    }
    auto is_near = square < within_square_ && lanes < static_cast<float>(candidates.last - first);
    if constexpr (moving)
      is_near = is_near && (square < near_square_ || square + time_ * rate < meeting_distance_ * stdx::sqrt(square));
    if (stdx::none_of(is_near)) continue;
    const int end = stdx::find_last_set(is_near);
    for (int lane = stdx::find_first_set(is_near); lane <= end; ++lane)
      if (is_near[lane]) near.push_back({std::min(slot, first + lane), std::max(slot, first + lane)});
  }
}

template <int d>
template <bool nearest_images, bool moving>
void CellOrder<d>::search_row(int y, int z, Near& near) const {
  const int row = (z * count_[1] + y) * count_[0], columns = count_[0];
  const std::vector<Row> neighbours = neighbour_rows(y, z);
  const bool is_periodic = period_[0] > 0 && columns > 1;
  const auto period = static_cast<float>(period_[0]);
  std::vector<SlotRange> others;  // Slots outside the cell that each of its particles is compared with
  const auto add = [&](int first_cell, int end_cell, std::array<float, d> image_shift, int image) {
    image_shift[0] = static_cast<float>(image) * period;
    others.push_back({start_[first_cell], start_[end_cell], image_shift});
  };
  for (int x = 0; x < columns; ++x) {
    const int begin = start_[row + x], end = start_[row + x + 1];
    if (begin == end) continue;
    const int from = std::max(x - 1, 0), to = std::min(x + 2, columns);
    others.clear();
    if (is_periodic && x == columns - 1) add(row, row + 1, {}, 1);
    for (const Row& other : neighbours) {
      add(other.first + from, other.first + to, other.image_shift, 0);
      if (is_periodic && x == 0) add(other.first + columns - 1, other.first + columns, other.image_shift, -1);
      if (is_periodic && x == columns - 1) add(other.first, other.first + 1, other.image_shift, 1);
    }
    for (int s = begin; s < end; ++s) {
      search<nearest_images, moving>(s, {s + 1, start_[row + to], {}}, near);
      for (const SlotRange& candidates : others) search<nearest_images, moving>(s, candidates, near);
    }
  }
}

template <int d>
template <bool moving>
const std::vector<Pair>& CellOrder<d>::collect(parallel::Team& team) {
  constexpr int cells_a_task = 8192;
  const int rows = count_[1] * count_[2], rows_a_task = std::max(1, cells_a_task / count_[0]);
  found_.resize((rows + rows_a_task - 1) / rows_a_task);
  team.for_each(static_cast<int>(found_.size()), [&](int task) {
    found_[task].clear();
    for (int row = task * rows_a_task; row < std::min(rows, (task + 1) * rows_a_task); ++row)
      needs_nearest_images_ ? search_row<true, moving>(row % count_[1], row / count_[1], found_[task])
                            : search_row<false, moving>(row % count_[1], row / count_[1], found_[task]);
  });
  pairs_.clear();
  for (const Near& found : found_) pairs_.insert(pairs_.end(), found.begin(), found.end());
  return pairs_;
}

template <int d>
const std::vector<Pair>& CellOrder<d>::pairs(parallel::Team& team) {
  return collect<false>(team);
}

template <int d>
const std::vector<Pair>& CellOrder<d>::pairs_that_meet(const Flight& flight, parallel::Team& team) {
  // Bound on rounding errors of the distance and of its rate. The error of the direction is that of the distance over
  // the distance, which is at least `near`; velocities are wrong by a few of their last digits.
  constexpr double last_digits = 8 * std::numeric_limits<float>::epsilon();
  double squares = 0;
  for (int s = 0; s < size(); ++s) {
    double square = 0;
    for (int k = 0; k < d; ++k) square += double{velocity_[k][s]} * velocity_[k][s];
    squares = std::max(squares, square);
  }
  const double relative_path = 2 * std::sqrt(squares) * flight.time;
  const double error = position_error_ + relative_path * (last_digits + 2 * position_error_ / flight.near);
  const double near = (flight.near + position_error_) * (1 + 1e-6);
  near_square_ = static_cast<float>(near * near);
  meeting_distance_ = static_cast<float>((flight.within + error) * (1 + 1e-6));
  time_ = static_cast<float>(flight.time);
  return collect<true>(team);
}

template class CellOrder<2>;
template class CellOrder<3>;

}  // namespace lichtenberg
