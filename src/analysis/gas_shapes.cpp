#include "src/analysis/gas_shapes.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "src/analysis/fractal.hpp"
#include "src/analysis/gas_clusters.hpp"

namespace lichtenberg::analysis {
namespace {

/// Partners of each grain, in contiguous lists.
struct Partners {
  std::vector<int> begin, all;

  Partners(int grains, std::span<const Pair> pairs) : begin(grains + 1), all(2 * pairs.size()) {
    for (const Pair p : pairs) ++begin[p.i + 1], ++begin[p.j + 1];
    for (int i = 0; i < grains; ++i) begin[i + 1] += begin[i];
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (const Pair p : pairs) all[next[p.i]++] = p.j, all[next[p.j]++] = p.i;
  }
  std::span<const int> of(int grain) const {
    return std::span(all).subspan(begin[grain], begin[grain + 1] - begin[grain]);
  }
};

/// Grains of one cluster in the order of traversal, and their unwrapped positions.
struct Unwrapped {
  std::vector<int> grains;
  std::vector<Vec3> position;
  bool percolates = false;
};

/// Unwraps the cluster of grain `first`. `unwrapped`: [N], unwrapped positions of the visited grains; `visited`: [N],
/// visited grains.
Unwrapped unwrap(const Bodies& b, const Partners& partners, int first, std::vector<Vec3>& unwrapped,
                 std::vector<bool>& visited) {
  Unwrapped cluster{.grains = {first}};
  unwrapped[first] = grain_position(b, first), visited[first] = true;
  for (std::size_t n = 0; n < cluster.grains.size(); ++n) {
    const int i = cluster.grains[n];
    for (const int j : partners.of(i)) {
      const Vec3 step = b.box.difference(grain_position(b, j), grain_position(b, i)), there = unwrapped[i] + step;
      if (!visited[j]) {
        visited[j] = true, unwrapped[j] = there;
        cluster.grains.push_back(j);
      } else if (norm(unwrapped[j] - there) > 1e-6 * norm(b.box.lengths)) {  // different by a whole box length
        cluster.percolates = true;
      }
    }
  }
  for (const int i : cluster.grains) cluster.position.push_back(unwrapped[i]);
  return cluster;
}

/// Returns |sum of the dipoles|.
double net_dipole(std::span<const int> grains, std::span<const double> dipole) {
  Vec3 sum{};
  for (const int i : grains) sum += Vec3{dipole[3 * i], dipole[3 * i + 1], dipole[3 * i + 2]};
  return norm(sum);
}

ClusterShape shape_of(const Bodies& b, const Unwrapped& cluster, std::span<const double> dipole) {
  const auto n = static_cast<double>(cluster.grains.size());
  ClusterShape shape{.grains = static_cast<int>(cluster.grains.size()), .percolates = cluster.percolates};
  if (!dipole.empty()) shape.induced_dipole = net_dipole(cluster.grains, dipole);
  if (cluster.percolates) {
    shape.gyration = shape.charge_dipole = NAN;
    return shape;
  }
  Vec3 centre{}, charge_dipole{};
  for (const Vec3 position : cluster.position) centre += position / n;
  double squares = 0;
  for (std::size_t k = 0; k < cluster.position.size(); ++k) {
    const Vec3 from_centre = cluster.position[k] - centre;
    squares += norm2(from_centre);
    // The mean charge contributes nothing
    if (!b.charge.empty()) charge_dipole += b.charge[cluster.grains[k]] * from_centre;
  }
  shape.gyration = std::sqrt(squares / n);
  shape.charge_dipole = norm(charge_dipole);
  return shape;
}

/// Returns the sum over k >= first of k^-tau, by the Euler-Maclaurin formula after twenty terms: to 1e-14 for tau <=
/// 10.
double hurwitz_zeta(double tau, int first) {
  double sum = 0;
  const int terms = 20;
  for (int k = first; k < first + terms; ++k) sum += std::pow(k, -tau);
  const double x = first + terms, last = std::pow(x, -tau);
  return sum + last * (x / (tau - 1) + 0.5 + tau / (12 * x) - tau * (tau + 1) * (tau + 2) / (720 * x * x * x) +
                       tau * (tau + 1) * (tau + 2) * (tau + 3) * (tau + 4) / (30240 * std::pow(x, 5)));
}

}  // namespace

std::vector<ClusterShape> cluster_shapes(const Bodies& bodies, std::span<const Pair> pairs, int least,
                                         std::span<const double> dipole) {
  const Partners partners(bodies.size(), pairs);
  std::vector<Vec3> unwrapped(bodies.size());
  std::vector<bool> visited(bodies.size());
  std::vector<ClusterShape> shapes;
  for (int i = 0; i < bodies.size(); ++i) {
    if (visited[i]) continue;
    const Unwrapped cluster = unwrap(bodies, partners, i, unwrapped, visited);
    if (static_cast<int>(cluster.grains.size()) >= least) shapes.push_back(shape_of(bodies, cluster, dipole));
  }
  return shapes;
}

std::vector<double> mean_by_grains(std::span<const ClusterShape> shapes, double ClusterShape::*quantity) {
  std::vector<double> sum;
  std::vector<int> number;
  for (const ClusterShape& shape : shapes) {
    const auto size = static_cast<std::size_t>(shape.grains) + 1;
    if (sum.size() < size) sum.resize(size), number.resize(size);
    if (std::isfinite(shape.*quantity)) sum[shape.grains] += shape.*quantity, ++number[shape.grains];
  }
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] = number[n] > 0 ? sum[n] / number[n] : NAN;
  return sum;
}

std::optional<ClusterDimension> cluster_dimension(std::span<const ClusterShape> shapes, int least, bool as_balls) {
  constexpr std::size_t fewest = 5;
  std::vector<double> mass, radius;
  for (const ClusterShape& shape : shapes) {
    if (shape.grains < least || shape.percolates) continue;
    mass.push_back(shape.grains);
    radius.push_back(as_balls ? std::sqrt(shape.gyration * shape.gyration + 0.15) : shape.gyration);
  }
  if (mass.size() < fewest || std::ranges::max(mass) == std::ranges::min(mass)) return {};
  const PowerLaw law = fit_power_law(mass, radius);
  if (!(law.exponent > 0)) return {};
  const double dimension = 1 / law.exponent;
  return ClusterDimension{dimension, dimension * dimension * law.standard_error, std::ranges::min(radius),
                          std::ranges::max(radius), static_cast<int>(mass.size())};
}

std::optional<SizeExponent> size_exponent(std::span<const int> sizes, int least) {
  constexpr int fewest = 10;
  int count = 0, largest = 0;
  double logarithms = 0;
  for (const int size : sizes)
    if (size >= least) ++count, logarithms += std::log(size), largest = std::max(largest, size);
  if (count < fewest || largest == least) return {};
  const double mean = logarithms / count;
  const auto loss = [&](double tau) { return std::log(hurwitz_zeta(tau, least)) + tau * mean; };
  constexpr double smallest = 1 + 1e-6, steepest = 10;
  const double tau = boost::math::tools::brent_find_minima(loss, smallest, steepest, 40).first;
  const double step = 1e-3 * (tau - 1);
  if (tau < 1.01 || tau > steepest - 0.01) return {};  // no minimum inside the interval
  const double curvature = (loss(tau + step) - 2 * loss(tau) + loss(tau - step)) / (step * step);
  return SizeExponent{tau, 1 / std::sqrt(count * curvature), count};
}

}  // namespace lichtenberg::analysis
