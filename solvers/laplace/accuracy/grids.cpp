#include "solvers/laplace/accuracy/grids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::laplace {
namespace {

constexpr int coarsest = 32;  ///< Units

}  // namespace

Grids::Grids(Vec2 size) : unit_(1) {
  constexpr int most = 2048;
  constexpr double rounding = 1e-9;  // Relative rounding error of sides written as decimal numbers
  const double aspect = std::min(size.x, size.y) / std::max(size.x, size.y);
  const auto whole = [&](int n) {
    const double across = aspect * n, nearest = std::round(across);
    return nearest >= 1 && std::abs(across - nearest) <= rounding * nearest;
  };
  while (unit_ <= most && !whole(unit_)) ++unit_;
  if (unit_ > most)
    throw InputError(fmt::format(
        "a box of {:g} m x {:g} m has no square cells: its sides must be to each other as whole numbers up to {}",
        size.x, size.y, most));
}

/// Returns the increment of the units: 16, and more on finer grids, for more halvings.
int Grids::step(int units) const { return std::clamp(static_cast<int>(std::bit_floor(unsigned(units) / 4)), 16, 64); }

int Grids::at_least(int cells) const {
  const int units = std::max((cells + unit_ - 1) / unit_, coarsest), by = step(units);
  return unit_ * ((units + by - 1) / by * by);
}

int Grids::at_most(int cells) const {
  const int units = cells / unit_;
  if (units < coarsest)
    throw InputError(
        fmt::format("square cells for a box of these proportions come in multiples of {} along the longer "
                    "side, and {} at most are possible here",
                    unit_ * coarsest, cells));
  return unit_ * (units / step(units) * step(units));
}

}  // namespace lichtenberg::laplace
