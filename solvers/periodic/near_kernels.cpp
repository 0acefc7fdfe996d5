#include "solvers/periodic/near_kernels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

namespace {

constexpr int lowest_degree = 4, highest_degree = 30;

/// Expands the cloud's potential in Chebyshev polynomials of 2 (r / cutoff)^2 - 1, with far more terms than needed.
std::vector<double> chebyshev_series(const Cloud& cloud) {
  constexpr int nodes = 48;
  std::vector<double> series(nodes);
  for (int node = 0; node < nodes; ++node) {
    const double angle = M_PI * (node + 0.5) / nodes;
    const double value = cloud.potential(cloud.cutoff * std::cos(angle / 2));
    for (int n = 0; n < nodes; ++n) series[n] += (n == 0 ? 1.0 : 2.0) / nodes * value * std::cos(n * angle);
  }
  return series;
}

/// Bound on the change of the force between two charges due to a Chebyshev polynomial of degree n, times a quarter of
/// the cut-off. The force is 4 r / cutoff^2 times the polynomial's slope, which is at most n^2.
double force_of_charges(double n) { return n * n; }

/// Like force_of_charges, for the derivatives of that force, which act between dipoles. A dipole counts as two charges
/// at a distance that follows from the cloud's potential and its curvature at the centre. Second and third derivatives
/// of the polynomial are at most n^2 (n^2 - 1) / 3 and n^2 (n^2 - 1) (n^2 - 4) / 15, each with a further factor 4 r /
/// cutoff^2.
double force_of_dipoles(double n, const Cloud& cloud) {
  const double distance = std::sqrt(cloud.potential(0) / (3 * cloud.dipole_field)) / cloud.cutoff;
  const double n2 = n * n, second = 4 * n2 * (n2 - 1) / 3, third = 16 * n2 * (n2 - 1) * (n2 - 4) / 15;
  return std::max({n2, distance * (n2 + second), distance * distance * (3 * second + third)});
}

/// Returns the lowest even degree that suffices. The neglected terms then change the force by less than a tenth of the
/// rms of Cloud::neglected, taken over the ball of the cut-off.
int sufficient_degree(const std::vector<double>& series, const Cloud& cloud, const auto& force) {
  const double volume = 4 * M_PI / 3 * std::pow(cloud.cutoff, 3);
  const double most = 0.1 * std::sqrt(cloud.neglected / volume) * cloud.cutoff / 4;
  int degree = highest_degree;
  for (double left = 0; degree > lowest_degree; --degree) {
    // Terms at the level of rounding do not count: keeping them improves nothing, since derivatives amplify their
    // errors.
    if (std::abs(series[degree]) > 5e-15 * std::abs(series[0])) left += std::abs(series[degree]) * force(degree);
    if (left > most) break;
  }
  return std::min(highest_degree, (degree + 1) / 2 * 2);
}

/// Integral over the ball of the cut-off of the squared force of the terms beyond a degree. With x = 2 (r / cutoff)^2 -
/// 1 this force is 4 r / cutoff^2 times the sum of a_n n U_(n-1)(x).
double neglected_beyond(int degree, const std::vector<double>& series, const Cloud& cloud) {
  constexpr int shells = 200;
  double neglected = 0;
  for (int shell = 0; shell < shells; ++shell) {
    const double part = (shell + 0.5) / shells, r = part * cloud.cutoff, x = 2 * part * part - 1;
    double force = 0, before = 0, now = 1;  // Chebyshev polynomials U_(n-2), U_(n-1)
    for (int n = 1; n <= highest_degree; ++n) {
      if (n > degree) force += series[n] * n * now;
      before = std::exchange(now, 2 * x * now - before);
    }
    force *= 4 * part / cloud.cutoff;
    neglected += 4 * M_PI * r * r * force * force * cloud.cutoff / shells;
  }
  return neglected;
}

std::vector<double> powers_of(const std::vector<double>& series, int degree) {
  std::vector<double> powers(degree + 1), before(degree + 1), now(degree + 1);
  before[0] = 1;  // T_0
  now[1] = 1;     // T_1
  for (int n = 0; n <= degree; ++n) {
    for (int k = 0; k <= degree; ++k) powers[k] += series[n] * before[k];
    auto after = before;
    for (int k = 0; k <= degree; ++k) after[k] = (k > 0 ? 2 * now[k - 1] : 0) - before[k];
    before = now;
    now = after;
  }
  return powers;
}

}  // namespace

std::vector<double> cloud_polynomial(const Cloud& cloud) {
  const auto series = chebyshev_series(cloud);
  int degree = lowest_degree;
  while (degree < highest_degree && neglected_beyond(degree, series, cloud) > 0.09 * cloud.neglected) ++degree;
  return powers_of(series, degree);
}

std::vector<double> cloud_polynomial(const Cloud& cloud, Kind kind) {
  const auto series = chebyshev_series(cloud);
  const auto force = [&](double n) { return kind == Kind::charges ? force_of_charges(n) : force_of_dipoles(n, cloud); };
  return powers_of(series, sufficient_degree(series, cloud, force));
}

double checked_cutoff(Vec3 lengths, double cutoff) {
  require_consistent({.lengths = lengths});
  for (int k = 0; k < 3; ++k)
    if (2 * cutoff > lengths[k])
      throw InputError(
          fmt::format("a cutoff of {} is more than half of the box's {}: a charge would meet two images of "
                      "one other",
                      cutoff, lengths[k]));
  return cutoff;
}

}  // namespace lichtenberg::periodic
