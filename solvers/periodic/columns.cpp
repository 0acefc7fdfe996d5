#include "solvers/periodic/columns.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

Columns::Columns(Vec3 lengths, int charges, int together, double widest, double reach) : lengths_(lengths) {
  const double volume = lengths.x * lengths.y * lengths.z;
  const double edge = std::cbrt(together * volume / std::max(1, charges)), width = std::min(widest, edge);
  for (int k = 0; k < 2; ++k) {
    // What is in reach of one tile must not be in reach of the next but one: places are rounded to single precision.
    const int fit = static_cast<int>(lengths[k] / (2 * reach) * (1 - 1e-4));
    tiles_[k] = std::max(1, fit / 2 * 2);
    const double tile = lengths[k] / tiles_[k];
    columns_[k] = std::max({1, static_cast<int>(std::ceil(tile / widest)), static_cast<int>(std::round(tile / edge))});
  }
  for (int x = 0; x < count()[0]; ++x)
    before_[0].push_back(x / columns_[0] * tiles_[1] * columns_a_tile() + x % columns_[0] * columns_[1]);
  for (int y = 0; y < count()[1]; ++y) before_[1].push_back(y / columns_[1] * columns_a_tile() + y % columns_[1]);
  constexpr int bins_a_width = 4;
  bins_ = static_cast<int>(std::ceil(bins_a_width * lengths.z / width));
}

/// Where they are, and which bins that is in.
[[gnu::noinline]] void Columns::place_charges(const Sources& sources, int first, int last) {
  constexpr double all = 0x1p32;
  const double turns[] = {1 / lengths_.x, 1 / lengths_.y, 1 / lengths_.z};
  const auto [x, y] = count();
  for (int i = first; i < last; ++i) {
    std::array<Turns, 3>& place = found_[i];
    for (int k = 0; k < 3; ++k) {
      const double turned = sources.position[3 * i + k] * turns[k];
      place[k] = static_cast<Turns>(static_cast<std::int64_t>((turned - std::floor(turned)) * all));
    }
    bin_[i] = number_of(part(place[0], x), part(place[1], y)) * bins_ + part(place[2], bins_);
  }
}

namespace {

bool are_finite(std::span<const double> values) {
  int others = 0;
  for (const double x : values) others |= !(std::abs(x) < INFINITY);
  return others == 0;
}

}  // namespace

void Columns::sort(const Sources& sources, parallel::Team& team) {
  constexpr int charges_a_task = 4096;
  const int n = sources.size();
  if (!are_finite(sources.position)) throw Failure("the place of a charge is no finite number");
  found_.resize(n), bin_.resize(n), sorted_.resize(n);
  for (auto& axis : place_) axis.resize(n + spare);
  charge_.resize(n + spare);
  team.for_each((n + charges_a_task - 1) / charges_a_task, [&](int task) {
    place_charges(sources, task * charges_a_task, std::min(n, (task + 1) * charges_a_task));
  });
  const auto [x, y] = count();
  first_.assign(static_cast<std::size_t>(x) * y * bins_ + 1, 0);
  for (const int bin : bin_) ++first_[bin + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  double largest = 0;
  for (const double charge : sources.charge) largest = std::max(largest, std::abs(charge));
  charge_unit_ = largest > 0 ? std::ldexp(1.0, std::ilogb(largest)) : 1;
  next_.assign(first_.begin(), first_.end());
  total_charge_ = 0;
  for (int i = 0; i < n; ++i) {
    const int s = next_[bin_[i]]++;
    sorted_[i] = s;
    for (int k = 0; k < 3; ++k) place_[k][s] = found_[i][k];
    const double charge = sources.charge[i] / charge_unit_;
    charge_[s] = static_cast<float>(charge);
    total_charge_ += charge;
  }
}

}  // namespace lichtenberg::periodic
