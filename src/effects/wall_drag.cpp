#include "src/effects/wall_drag.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::effects {
namespace {

double coth(double x) { return 1 / std::tanh(x); }

/// Number of terms after which exp(-(2 n + 1) alpha) is below rounding.
int terms_for(double alpha) { return static_cast<int>(20 / alpha) + 10; }

/// Coefficients k_n and A_n (n = 0 ... terms) of O'Neill's solution, A_n by elimination in its tridiagonal equations.
struct ONeillSeries {
  explicit ONeillSeries(double alpha);
  std::vector<double> k, a;
};

ONeillSeries::ONeillSeries(double alpha) {
  const int terms = terms_for(alpha);
  for (int n = 0; n <= terms + 1; ++n) k.push_back((n + 0.5) * coth((n + 0.5) * alpha) - coth(alpha));
  a.assign(terms + 2, 0);
  std::vector<double> above(terms + 1);  // of the eliminated matrix, over its diagonal
  for (int n = 1; n <= terms; ++n) {
    const double p = (2 * n - 1) * k[n - 1] - (2 * n - 3) * k[n], q = (2 * n + 5) * k[n] - (2 * n + 3) * k[n + 1];
    const double below = p * (n - 1) / (2 * n - 1);
    const double diagonal = -p * n / (2 * n + 1) - q * (n + 1) / (2 * n + 1) - below * above[n - 1];
    const double right =
        std::numbers::sqrt2 * (2 * coth((n + 0.5) * alpha) - coth((n - 0.5) * alpha) - coth((n + 1.5) * alpha));
    above[n] = q * (n + 2) / (2 * n + 3) / diagonal;
    a[n] = (right - below * a[n - 1]) / diagonal;
  }
  for (int n = terms - 1; n >= 1; --n) a[n] -= above[n] * a[n + 1];
}

// Tabulated gaps are exp(k / a_unit) for k = first ... last.
constexpr int a_unit = 16;
constexpr int first = -9 * a_unit - 6;  // below the logarithm of least_gap, -9.21, by more than one gap
constexpr int last = 7 * a_unit;        // beyond it, at gaps of 1000 radii, terms of the fourth order are below 1e-12

}  // namespace

double drag_towards_wall(double gap) {
  const double alpha = std::acosh(1 + gap);
  double sum = 0;
  for (int n = 1; n <= terms_for(alpha); ++n) {
    const double s = std::sinh((n + 0.5) * alpha), ratio = (2 * n + 1) * std::sinh(alpha);
    const double share =
        (2 * std::sinh((2 * n + 1) * alpha) + (2 * n + 1) * std::sinh(2 * alpha)) / (4 * s * s - ratio * ratio);
    sum += static_cast<double>(n) * (n + 1) / ((2.0 * n - 1) * (2 * n + 3)) * (share - 1);
  }
  return 4.0 / 3 * std::sinh(alpha) * sum;
}

double drag_along_wall(double gap) {
  const double alpha = std::acosh(1 + gap);
  const auto [k, a] = ONeillSeries(alpha);
  double sum = 0;
  for (int n = 0; n + 1 < static_cast<int>(a.size()); ++n) {
    const double before = n > 0 ? a[n - 1] : 0, after = a[n + 1], angle = (n + 0.5) * alpha;
    const double c = -2 * k[n] * ((n - 1) * before / (2 * n - 1) - a[n] + (n + 2) * after / (2 * n + 3));
    const double e = 2 * std::numbers::sqrt2 * std::exp(-angle) / std::sinh(angle) +
                     k[n] * (n * (n - 1) * before / (2 * n - 1) - (n + 1) * (n + 2) * after / (2 * n + 3));
    sum += e + n * (n + 1) * c;
  }
  return std::numbers::sqrt2 / 6 * std::sinh(alpha) * sum;
}

WallDrag::WallDrag() {
  for (int k = first; k <= last; ++k) {
    const double gap = std::exp(static_cast<double>(k) / a_unit);
    logarithm_.push_back({std::log(drag_towards_wall(gap) - 1), std::log(drag_along_wall(gap) - 1)});
  }
}

/// Interpolates with the polynomial of third degree through the four tabulated gaps around the gap. Its error in the
/// logarithm of the factor minus 1 is at most 3/128 h^4 times the fourth derivative, h = 1 / a_unit.
WallDrag::Factors WallDrag::at(double gap) const {
  const double position = a_unit * std::log(std::max(gap, least_gap)) - first;
  if (position > static_cast<double>(last - first) - 1) {
    const double x = 1 / (1 + gap);  // Lorentz 1907, Faxen 1922
    return {1 / (1 - 9.0 / 8 * x + x * x * x / 2), 1 / (1 - 9.0 / 16 * x + x * x * x / 8)};
  }
  const int k = static_cast<int>(position);
  const double t = position - k;
  const double weight[4] = {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
                            (t + 1) * t * (t - 1) / 6};
  double logarithm[2] = {};
  for (int j = 0; j < 4; ++j)
    for (int direction = 0; direction < 2; ++direction)
      logarithm[direction] += weight[j] * logarithm_[k - 1 + j][direction];
  return {1 + std::exp(logarithm[0]), 1 + std::exp(logarithm[1])};
}

}  // namespace lichtenberg::effects
