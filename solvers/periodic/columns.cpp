#include "solvers/periodic/columns.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

Columns::Columns(Vec3 lengths, int charges, int together, double widest, double reach) : lengths_(lengths) {
  const double volume = lengths.x * lengths.y * lengths.z;
  const double width = std::min(widest, std::cbrt(together * volume / std::max(1, charges)));
  for (int k = 0; k < 2; ++k) {
    // What is in reach of one tile must not be in reach of the next but one: places are rounded to single precision.
    const int fit = static_cast<int>(lengths[k] / (2 * reach) * (1 - 1e-4));
    tiles_[k] = std::max(1, fit / 2 * 2);
    columns_[k] = static_cast<int>(std::ceil(lengths[k] / tiles_[k] / width));
  }
  constexpr int bins_a_width = 4;
  bins_ = static_cast<int>(std::ceil(bins_a_width * lengths.z / width));
}

/// Where it is, and which bin that is in.
[[gnu::noinline]] void Columns::place_charge(const Sources& sources, int i) {
  constexpr double all = 0x1p32;
  std::array<Turns, 3>& place = found_[i];
  for (int k = 0; k < 3; ++k) {
    const double turned = sources.position[3 * i + k] / lengths_[k];
    place[k] = static_cast<Turns>(static_cast<std::uint64_t>((turned - std::floor(turned)) * all));
  }
  const auto [x, y] = count();
  bin_[i] = number_of(part(place[0], x), part(place[1], y)) * bins_ + part(place[2], bins_);
}

void Columns::sort(const Sources& sources, parallel::Team& team) {
  constexpr int charges_a_task = 4096;
  const int n = sources.size();
  if (!std::ranges::all_of(sources.position, [](double x) { return std::isfinite(x); }))
    throw Failure("the place of a charge is no finite number");
  found_.resize(n), bin_.resize(n), sorted_.resize(n);
  for (auto& axis : place_) axis.resize(n + spare);
  charge_.resize(n + spare);
  team.for_each((n + charges_a_task - 1) / charges_a_task, [&](int task) {
    for (int i = task * charges_a_task; i < std::min(n, (task + 1) * charges_a_task); ++i) place_charge(sources, i);
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
