#include "solvers/periodic/columns.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

template <class Real>
void Columns<Real>::lay_out(int sources) {
  laid_out_for_ = sources;
  const auto [length_unit, together, widest, reach, part] = layout_;
  const double volume = part > 0 ? part : lengths_.x * lengths_.y * lengths_.z;
  const int n = std::max(1, sources);
  // There are at most four columns a source.
  const double edge = std::max(std::cbrt(together * volume / n), std::sqrt(lengths_.x * lengths_.y / (4.0 * n)));
  const double width = std::min(widest, edge);
  for (int k = 0; k < 2; ++k) {
    // The margin for rounded positions keeps sources within reach of one tile out of reach of the next tile but one.
    const int fit = static_cast<int>(lengths_[k] / (2 * reach) * (1 - 1e-4));
    tiles_[k] = std::max(1, fit / 2 * 2);
    const double tile = lengths_[k] / tiles_[k];
    columns_[k] = std::max({1, static_cast<int>(std::ceil(tile / widest)), static_cast<int>(std::round(tile / edge))});
  }
  before_ = {};
  for (int x = 0; x < count()[0]; ++x)
    before_[0].push_back(x / columns_[0] * tiles_[1] * columns_a_tile() + x % columns_[0] * columns_[1]);
  for (int y = 0; y < count()[1]; ++y) before_[1].push_back(y / columns_[1] * columns_a_tile() + y % columns_[1]);
  constexpr int bins_a_width = 4, most_bins = 128;  // sources of a small volume may disperse later
  bins_ = static_cast<int>(std::ceil(bins_a_width * lengths_.z / width));
  if (part > 0) bins_ = std::min(bins_, most_bins);
  none_.assign(bins_ + 1, 0);
}

/// Computes positions and columns of the sources from `first` to `last`.
template <class Real>
[[gnu::noinline]] void Columns<Real>::find_coordinates(const Sources& sources, int first, int last) {
  constexpr double all = sizeof(Real) == 4 ? 0x1p32 : 0x1p64;
  const double inverse_length[] = {1 / lengths_.x, 1 / lengths_.y, 1 / lengths_.z};
  const auto [x, y] = count();
  for (int i = first; i < last; ++i) {
    std::array<FixedPoint, 3>& coordinate = unsorted_[i];
    for (int k = 0; k < 3; ++k) {
      const double periods = sources.position[3 * i + k] * inverse_length[k], fraction = periods - std::floor(periods);
      // A fraction just below 1 may be rounded to 1.
      coordinate[k] = fraction < 1 ? static_cast<FixedPoint>(fraction * all) : 0;
    }
    column_[i] = number_of(part(coordinate[0], x), part(coordinate[1], y));
  }
}

/// Counts the sources of each column, and of each bin of the columns that have sources.
template <class Real>
void Columns<Real>::count_sources() {
  const auto [x, y] = count();
  begin_.assign(static_cast<std::size_t>(x) * y + 1, 0);
  row_.resize(begin_.size());
  for (const int column : column_) ++begin_[column + 1];
  int rows = 0;
  for (int column = 0; column < x * y; ++column) {
    row_[column] = rows;
    rows += begin_[column + 1] > 0;
    begin_[column + 1] += begin_[column];
  }
  first_.assign(static_cast<std::size_t>(rows) * bins_ + 1, 0);
  for (std::size_t i = 0; i < column_.size(); ++i) {
    bin_[i] = row_[column_[i]] * bins_ + part(unsorted_[i][2], bins_);
    ++first_[bin_[i] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

/// Stores the sources in the order of their bins.
template <class Real>
void Columns<Real>::store(const Sources& sources) {
  const int n = sources.size();
  const bool dipoles = !sources.dipole.empty();
  double largest = 0;
  for (const double charge : sources.charge) largest = std::max(largest, std::abs(charge));
  charge_unit_ = largest > 0 ? std::ldexp(1.0, std::ilogb(largest)) : 1;
  const double dipole_unit = charge_unit_ * layout_.length_unit;
  for (int k = 0; k < (dipoles ? 4 : 1); ++k) quantity_[k].resize(n + spare);
  next_.assign(first_.begin(), first_.end());
  total_charge_ = 0;
  for (int i = 0; i < n; ++i) {
    const int s = next_[bin_[i]]++;
    sorted_[i] = s;
    for (int k = 0; k < 3; ++k) coordinate_[k][s] = unsorted_[i][k];
    const double charge = sources.charge[i] / charge_unit_;
    quantity_[0][s] = static_cast<Real>(charge);
    total_charge_ += charge;
    for (int k = 0; k < 3 && dipoles; ++k)
      quantity_[1 + k][s] = static_cast<Real>(sources.dipole[3 * i + k] / dipole_unit);
  }
}

template <class Real>
void Columns<Real>::sort(const Sources& sources, parallel::Team& team) {
  constexpr int sources_a_task = 4096;
  const int n = sources.size();
  int not_finite = 0;
  for (const double x : sources.position) not_finite |= !(std::abs(x) < INFINITY);
  if (not_finite) throw Failure("the position of a charge is not finite");
  if (n != laid_out_for_) lay_out(n);
  unsorted_.resize(n), column_.resize(n), bin_.resize(n), sorted_.resize(n);
  for (auto& axis : coordinate_) axis.resize(n + spare);
  team.for_each((n + sources_a_task - 1) / sources_a_task, [&](int task) {
    find_coordinates(sources, task * sources_a_task, std::min(n, (task + 1) * sources_a_task));
  });
  count_sources();
  store(sources);
}

template class Columns<float>;
template class Columns<double>;

}  // namespace lichtenberg::periodic
