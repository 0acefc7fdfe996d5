#include "src/analysis/gas_growth.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::analysis {
namespace {

/// Returns the power law in t + shift with the smallest deviation from the sizes.
ShiftedPower power_with(double shift, std::span<const double> time, std::span<const double> size) {
  const auto n = static_cast<double>(time.size());
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  const double x0 = std::log(time.back() + shift), y0 = std::log(size.back());  // differences avoid cancellation
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double a = std::log(time[k] + shift) - x0, b = std::log(size[k]) - y0;
    x += a / n, y += b / n, xx += a * a / n, xy += a * b / n, yy += b * b / n;
  }
  const double slope = (xy - x * y) / (xx - x * x), square = yy - y * y - slope * (xy - x * y);
  return {std::exp(y0 + y - slope * (x0 + x)), shift, slope, std::sqrt(std::max(square, 0.0))};
}

/// Returns ln S at a time, interpolated by the power of t between the two enclosing times.
double log_size_at(double t, std::span<const double> time, std::span<const double> size) {
  const auto after = std::ranges::lower_bound(time, t) - time.begin();
  if (after == 0) return std::log(size[0]);
  const double part = std::log(t / time[after - 1]) / std::log(time[after] / time[after - 1]);
  return (1 - part) * std::log(size[after - 1]) + part * std::log(size[after]);
}

void check_series(std::span<const double> time, std::span<const double> size) {
  bool fit = time.size() >= 5 && size.size() == time.size();
  for (std::size_t k = 0; fit && k < time.size(); ++k)
    fit = size[k] > 0 && time[k] > (k == 0 ? 0 : time[k - 1]) && std::isfinite(time[k]) && std::isfinite(size[k]);
  if (!fit)
    throw InputError(
        "the fit of a growth law needs at least five cluster sizes, all positive, at positive times in ascending "
        "order");
}

}  // namespace

std::vector<double> local_slopes(std::span<const double> time, std::span<const double> size, double p) {
  std::vector<double> slopes;
  for (std::size_t k = 0; k < time.size(); ++k)
    slopes.push_back(time[k] / p < time[0] ? NAN
                                           : (std::log(size[k]) - log_size_at(time[k] / p, time, size)) / std::log(p));
  return slopes;
}

std::optional<ShiftedPower> fit_growth(std::span<const double> time, std::span<const double> size) {
  check_series(time, size);
  // The variable is the time from the singularity to the first point. A scan precedes Brent's method, because several
  // minima are possible.
  const auto scatter = [&](double log_first) {
    return power_with(std::exp(log_first) - time.front(), time, size).scatter;
  };
  const double low = std::log(1e-6 * time.front()), high = std::log(10 * time.back());
  constexpr int points = 200;
  const double step = (high - low) / points;
  int best = 0;
  for (int k = 1; k <= points; ++k)
    if (scatter(low + k * step) < scatter(low + best * step)) best = k;
  if (best == 0 || best == points) return {};
  const auto found =
      boost::math::tools::brent_find_minima(scatter, low + (best - 1) * step, low + (best + 1) * step, 40);
  return power_with(std::exp(found.first) - time.front(), time, size);
}

}  // namespace lichtenberg::analysis
