#include "solvers/laplace/multipole/cells.hpp"

#include <algorithm>
#include <limits>

namespace lichtenberg::laplace::multipole {

namespace {

/// Upper bound of `separation`: the multipoles of a cell converge like its powers.
constexpr double largest_separation = 0.6;

int floor_divide(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

}  // namespace

Cells::Cells(const Mirrors& mirrors, const std::vector<Source>& disks)
    : bounded_(mirrors.bounded), size_(mirrors.size), side_sign_(mirrors.side_sign) {
  if (!bounded_) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double x_low = infinity, x_high = -infinity, y_low = infinity, y_high = -infinity;
    for (const Source& s : disks) {
      x_low = std::min(x_low, s.centre.real() - s.radius);
      x_high = std::max(x_high, s.centre.real() + s.radius);
      y_low = std::min(y_low, s.centre.imag() - s.radius);
      y_high = std::max(y_high, s.centre.imag() + s.radius);
    }
    origin = {x_low, y_low};
    size_ = {x_high - x_low, y_high - y_low};
  }
  // About one disk per cell.
  const double step = std::sqrt(size_.x * size_.y / static_cast<double>(std::max<std::size_t>(1, disks.size())));
  nx = std::max(1, static_cast<int>(std::lround(size_.x / step)));
  ny = std::max(1, static_cast<int>(std::lround(size_.y / step)));
  width = size_.x / nx;
  height = size_.y / ny;

  members_.resize(static_cast<std::size_t>(nx) * ny);
  double reach = 0.5 * std::hypot(width, height);  // Extent of a point charge
  for (std::size_t s = 0; s < disks.size(); ++s) {
    const int cell = cell_of(disks[s].centre);
    members_[cell].push_back(static_cast<int>(s));
    reach = std::max(reach, std::abs(disks[s].centre - centre(cell)) + disks[s].radius);
  }
  const auto distance = [&] { return (window + 1) * std::min(width, height) - reach; };
  while (reach > largest_separation * distance()) ++window;
  separation = reach / distance();
}

int Cells::cell_of(Complex z) const {
  const int i = static_cast<int>((z.real() - origin.real()) / width);
  const int j = static_cast<int>((z.imag() - origin.imag()) / height);
  return std::clamp(j, 0, ny - 1) * nx + std::clamp(i, 0, nx - 1);
}

bool Cells::contains(Complex z) const {
  const Complex p = z - origin;
  return p.real() >= 0 && p.real() <= size_.x && p.imag() >= 0 && p.imag() <= size_.y;
}

Cells::ImageCell Cells::image_cell(int i, int n, double length, int sign_low, int period_sign) const {
  if (!bounded_) return {i >= 0 && i < n ? i : -1, false, 0, 1};
  const int period = floor_divide(i, 2 * n), r = i - 2 * n * period;
  const auto sign = [&](int periods) { return periods % 2 == 0 ? 1.0 : static_cast<double>(period_sign); };
  if (r < n) return {r, false, 2 * length * period, sign(period)};
  return {2 * n - 1 - r, true, 2 * length * (period + 1), sign_low * sign(period + 1)};
}

}  // namespace lichtenberg::laplace::multipole
