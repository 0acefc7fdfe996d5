#include "src/theory/smoluchowski.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

/// Product of aggregates of two sizes: `share` of one in class `into` and the rest in the next class.
struct Merger {
  double rate = 0;  ///< K; for equal sizes K/2
  double share = 1;
  std::int32_t into = 0;  ///< -1: lost beyond the largest size
};

/// Returns all pairs of classes (i, j), j <= i, in rows of j.
std::vector<Merger> all_mergers(const Kernel& kernel, std::span<const double> sizes) {
  std::vector<Merger> mergers;
  mergers.reserve(sizes.size() * (sizes.size() + 1) / 2);
  for (std::size_t i = 0; i < sizes.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      Merger merger{.rate = kernel(sizes[i], sizes[j]) / (i == j ? 2 : 1)};
      const double size = sizes[i] + sizes[j];
      const auto above = std::ranges::upper_bound(sizes, size);
      merger.into = static_cast<std::int32_t>(above - sizes.begin()) - 1;
      if (above != sizes.end())
        merger.share = (*above - size) / (*above - *(above - 1));
      else if (size > sizes.back())
        merger.into = -1;
      mergers.push_back(merger);
    }
  return mergers;
}

/// Computes the rates of the numbers of all classes, and then that of the lost mass.
void merge(std::span<const Merger> mergers, std::span<const double> sizes, std::span<const double> y,
           std::span<double> rate) {
  std::ranges::fill(rate, 0.0);
  const Merger* merger = mergers.data();
  for (std::size_t i = 0; i < sizes.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j, ++merger) {
      const double flow = merger->rate * y[i] * y[j];
      rate[i] -= flow;
      rate[j] -= flow;
      if (merger->into < 0) {
        rate[sizes.size()] += flow * (sizes[i] + sizes[j]);
        continue;
      }
      rate[merger->into] += flow * merger->share;
      if (merger->share < 1) rate[merger->into + 1] += flow * (1 - merger->share);
    }
}

/// Computes the derivatives of the rates of merge() by all numbers, in columns of y.size() elements.
void merge_jacobian(std::span<const Merger> mergers, std::span<const double> sizes, std::span<const double> y,
                    std::span<double> matrix) {
  std::ranges::fill(matrix, 0.0);
  const Merger* merger = mergers.data();
  for (std::size_t i = 0; i < sizes.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j, ++merger)
      for (const auto& [by, slope] : {std::pair{i, merger->rate * y[j]}, {j, merger->rate * y[i]}}) {
        double* column = matrix.data() + by * y.size();
        column[i] -= slope;
        column[j] -= slope;
        if (merger->into < 0) {
          column[sizes.size()] += slope * (sizes[i] + sizes[j]);
          continue;
        }
        column[merger->into] += slope * merger->share;
        if (merger->share < 1) column[merger->into + 1] += slope * (1 - merger->share);
      }
}

Ode coagulation_ode(std::span<const Merger> mergers, std::span<const double> sizes, double most_lost) {
  Ode ode{.rates = [=](double, std::span<const double> y, std::span<double> rate) { merge(mergers, sizes, y, rate); },
          .absolute = {},
          .relative = 1e-8};
  for (const double size : sizes) ode.absolute.push_back(1e-13 / size);  // fraction of the mass
  ode.absolute.push_back(most_lost * 1e-3);
  ode.falls = {[most_lost](double, std::span<const double> y) { return most_lost - y.back(); }};
  return ode;
}

CoagulationSeries series_in_classes(const Kernel& kernel, std::span<const double> times, double ratio,
                                    const CoagulationOptions& options) {
  constexpr int one_by_one = 60;
  constexpr double most_lost = 1e-9;
  const std::vector<double> sizes = size_classes(one_by_one, ratio, options.largest);
  CoagulationSeries series{.ratio = ratio};
  for (const SizeDistribution& found : coagulate(kernel, sizes, times, most_lost, options.stiff)) {
    series.size.push_back(found.mean_size(sizes));
    series.number.push_back(found.moment(sizes, 0));
    series.lost = found.lost;
  }
  return series;
}

/// Extrapolates to zero width; `fine` has classes of half the width of `coarse`.
CoagulationSeries extrapolated(const CoagulationSeries& coarse, CoagulationSeries fine) {
  const std::size_t common = std::min(coarse.size.size(), fine.size.size());
  fine.size.resize(common), fine.number.resize(common);
  for (std::size_t k = 0; k < common; ++k) {
    fine.size[k] += (fine.size[k] - coarse.size[k]) / 3;
    fine.number[k] += (fine.number[k] - coarse.number[k]) / 3;
  }
  return fine;
}

double largest_relative_difference(std::span<const double> a, std::span<const double> b) {
  double most = 0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) most = std::max(most, std::abs(a[k] / b[k] - 1));
  return most;
}

}  // namespace

Kernel flight_kernel(double beta) {
  return [power = 1 / beta](double i, double j) {
    const double diameters = std::cbrt(i) + std::cbrt(j);
    return diameters * diameters * std::pow(1 / i + 1 / j, power);
  };
}

double flight_exponent(double beta) { return 1 / (1.0 / 3 + 1 / beta); }

double flight_time(double beta, double size) {
  const double z = flight_exponent(beta);
  return z * std::expm1(std::log(size) / z) / std::pow(2, 1 + 1 / beta);
}

std::vector<double> size_classes(int single, double ratio, double largest) {
  std::vector<double> sizes;
  for (int size = 1; size <= single && size <= largest; ++size) sizes.push_back(size);
  while (sizes.back() * ratio <= largest) sizes.push_back(std::max(sizes.back() * ratio, sizes.back() + 1));
  return sizes;
}

double SizeDistribution::moment(std::span<const double> sizes, double power) const {
  double sum = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) sum += std::pow(sizes[k], power) * number[k];
  return sum;
}

double SizeDistribution::mean_size(std::span<const double> sizes) const { return moment(sizes, 2) / moment(sizes, 1); }

std::vector<SizeDistribution> coagulate(const Kernel& kernel, std::span<const double> sizes,
                                        std::span<const double> times, double most_lost, bool stiff) {
  const std::vector<Merger> mergers = all_mergers(kernel, sizes);
  std::vector<double> start(sizes.size() + 1);
  start[0] = 1;
  std::vector<SizeDistribution> found;
  Ode ode = coagulation_ode(mergers, sizes, most_lost);
  if (stiff) {
    ode.stiff = true, ode.relative = 1e-7;
    ode.jacobian = [&](double, std::span<const double> y, std::span<double> matrix) {
      merge_jacobian(mergers, sizes, y, matrix);
    };
  }
  for (const auto& y : integrate(ode, 0, start, times))
    found.push_back({times[found.size()], {y.begin(), y.end() - 1}, y.back()});
  return found;
}

std::vector<double> CoagulationSeries::relative_width() const {
  std::vector<double> width;
  for (std::size_t k = 0; k < size.size(); ++k) width.push_back(std::sqrt(std::max(size[k] * number[k] - 1, 0.0)));
  return width;
}

CoagulationSeries coagulation_series(const Kernel& kernel, std::span<const double> times,
                                     const CoagulationOptions& options) {
  constexpr double widest = 0.24, narrowest = 0.0075;
  CoagulationSeries plain = series_in_classes(kernel, times, 1 + widest, options), best;
  for (double width = widest / 2; width >= narrowest; width /= 2) {
    CoagulationSeries finer = series_in_classes(kernel, times, 1 + width, options);
    CoagulationSeries next = extrapolated(plain, finer);
    // The remaining error is of second order in the width or higher: at most a third of the last change.
    next.error = best.size.empty() ? INFINITY : largest_relative_difference(best.size, next.size) / 3;
    plain = std::move(finer), best = std::move(next);
    if (best.error <= options.tolerance) break;
  }
  return best;
}

}  // namespace lichtenberg::theory
