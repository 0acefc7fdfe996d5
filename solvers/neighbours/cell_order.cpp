#include "solvers/neighbours/cell_order.hpp"

#include <algorithm>
#include <cmath>
#include <experimental/simd>
#include <limits>
#include <numeric>

namespace lichtenberg {
namespace {

namespace stdx = std::experimental;
/// Some more than there are in three cells, as a rule; how many are compared at once has no part in what is found.
constexpr int width = 8;
using Several = stdx::simd<float, stdx::simd_abi::deduce_t<float, width>>;

/// 0, 1, 2 ...
const Several lanes([](int lane) { return static_cast<float>(lane); });

}  // namespace

/// No more cells than four a particle, or one that flew far away would cost memory for nothing. Along a periodic axis
/// there are three or more, so that no two cells meet twice, or one alone.
template <int d>
void CellOrder<d>::lay_out(const Spheres<d>& spheres) {
  const int n = spheres.size(), most = std::max(1, static_cast<int>(std::pow(4.0 * n, 1.0 / d)));
  double longest = 0;
  folds_ = false;
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
    constexpr double rounding = 1e-9;  // more than moves a place against the cells' borders
    count_[k] = static_cast<int>(std::clamp(length / (range_ * (1 + rounding)), 1.0, static_cast<double>(most)));
    if (period_[k] > 0 && count_[k] < 3) count_[k] = 1, folds_ = true;
    cells_a_metre_[k] = count_[k] / length;
    longest = std::max(longest, length);
  }
  // Places are rounded by up to half of their last digit, and so is what they are turned by.
  const double within = (range_ + 4 * longest * std::numeric_limits<float>::epsilon()) * (1 + 1e-6);
  within_square_ = static_cast<float>(within * within);
}

template <int d>
int CellOrder<d>::column(double x, int k) const {
  return x > 0 ? static_cast<int>(std::min(x * cells_a_metre_[k], count_[k] - 1.0)) : 0;  // what is no number too
}

template <int d>
void CellOrder<d>::sort(const Spheres<d>& spheres, double range) {
  const int n = spheres.size();
  range_ = range;
  if (n > 0) lay_out(spheres);
  start_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
  for (auto* of : {&cell_, &particle_, &slot_}) of->resize(n);
  inside_.resize(n);
  for (auto& along : place_) along.resize(n + width);
  for (int i = 0; i < n; ++i) {
    int cell = 0;
    for (int k = d - 1; k >= 0; --k) {
      double x = spheres.position[i * d + k] - low_[k];
      if (period_[k] > 0 && !(x >= 0 && x < period_[k])) {
        x -= period_[k] * std::floor(x / period_[k]);
        if (!(x >= 0 && x < period_[k])) x = 0;
      }
      inside_[i][k] = static_cast<float>(x);
      cell = cell * count_[k] + column(x, k);
    }
    ++start_[(cell_[i] = cell) + 1];
  }
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  // Each cell's slots are filled from its start on; then starts are those of the cells after them.
  for (int i = 0; i < n; ++i) {
    const int slot = slot_[i] = start_[cell_[i]]++;
    particle_[slot] = i;
    for (int k = 0; k < d; ++k) place_[k][slot] = inside_[i][k];
  }
  std::copy_backward(start_.begin(), start_.end() - 1, start_.end());
  start_[0] = 0;
}

/// Half of the rows around a row: the other half have it among theirs.
template <int d>
auto CellOrder<d>::rows_beside(int y, int z) const -> std::vector<Row> {
  std::vector<Row> rows;
  const auto add = [&](int row_y, int row_z) {
    std::array<int, 3> at{0, row_y, row_z};
    Row row;
    for (int k = 1; k < d; ++k) {
      const int turn = at[k] < 0 ? -1 : at[k] >= count_[k] ? 1 : 0;
      if (turn != 0 && period_[k] == 0) return;
      at[k] -= turn * count_[k];
      row.turned[k] = static_cast<float>(turn * period_[k]);
    }
    row.first = (at[2] * count_[1] + at[1]) * count_[0];
    rows.push_back(row);
  };
  const int beside = count_[1] > 1 ? 1 : 0;
  if (beside) add(y + 1, z);
  if (count_[2] > 1)
    for (int step = -beside; step <= beside; ++step) add(y + step, z + 1);
  return rows;
}

/// `folded`: nearest images are looked for; else `turned` says where they are.
template <int d>
template <bool folded>
void CellOrder<d>::search(int slot, Span among, const std::array<float, d>& turned, Near& near) const {
  for (int first = among.first; first < among.last; first += width) {
    Several square = 0;
    for (int k = 0; k < d; ++k) {
      Several apart = Several(&place_[k][first], stdx::element_aligned) - (place_[k][slot] - turned[k]);
      if (folded && period_[k] > 0) {
        const float period = static_cast<float>(period_[k]);
        apart -= period * stdx::nearbyint(apart * (1 / period));
      }
      square += apart * apart;
    }
    auto is_near = square < within_square_ && lanes < static_cast<float>(among.last - first);
    if (stdx::none_of(is_near)) continue;
    for (int left = stdx::popcount(is_near); left > 0; --left) {
      const int lane = stdx::find_first_set(is_near), other = first + lane;
      near.push_back({std::min(slot, other), std::max(slot, other)});
      is_near[lane] = false;
    }
  }
}

template <int d>
template <bool folded>
void CellOrder<d>::search_row(int y, int z, Near& near) const {
  const int row = (z * count_[1] + y) * count_[0], columns = count_[0];
  const std::vector<Row> beside = rows_beside(y, z);
  const bool turns = period_[0] > 0 && columns > 1;
  std::array<float, d> behind{};
  behind[0] = static_cast<float>(period_[0]);
  const auto turned = [&](std::array<float, d> by, int turn) {
    by[0] = turn * behind[0];
    return by;
  };
  for (int x = 0; x < columns; ++x) {
    const int first = std::max(x - 1, 0), end = std::min(x + 2, columns);
    for (int s = start_[row + x]; s < start_[row + x + 1]; ++s) {
      search<folded>(s, {s + 1, start_[row + end]}, {}, near);
      if (turns && x == columns - 1) search<folded>(s, {start_[row], start_[row + 1]}, behind, near);
      for (const Row& other : beside) {
        const auto cells = [&](int from, int to) { return Span{start_[other.first + from], start_[other.first + to]}; };
        search<folded>(s, cells(first, end), other.turned, near);
        if (turns && x == 0) search<folded>(s, cells(columns - 1, columns), turned(other.turned, -1), near);
        if (turns && x == columns - 1) search<folded>(s, cells(0, 1), turned(other.turned, 1), near);
      }
    }
  }
}

template <int d>
const std::vector<Pair>& CellOrder<d>::pairs(parallel::Team& team) {
  constexpr int cells_a_task = 8192;
  const int rows = count_[1] * count_[2], rows_a_task = std::max(1, cells_a_task / count_[0]);
  found_.resize((rows + rows_a_task - 1) / rows_a_task);
  team.for_each(static_cast<int>(found_.size()), [&](int task) {
    found_[task].clear();
    for (int row = task * rows_a_task; row < std::min(rows, (task + 1) * rows_a_task); ++row)
      folds_ ? search_row<true>(row % count_[1], row / count_[1], found_[task])
             : search_row<false>(row % count_[1], row / count_[1], found_[task]);
  });
  pairs_.clear();
  for (const Near& found : found_) pairs_.insert(pairs_.end(), found.begin(), found.end());
  return pairs_;
}

template class CellOrder<2>;
template class CellOrder<3>;

}  // namespace lichtenberg
