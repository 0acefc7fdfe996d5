#include "solvers/periodic/sum_method.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/periodic/near.hpp"

namespace lichtenberg::periodic {

namespace {

/// Returns the multiples of 8 from 16 to 1024 without other prime factors than `primes`.
std::vector<int> numbers_of(std::initializer_list<int> primes) {
  std::vector<int> numbers;
  for (int n = 16; n <= 1024; n += 8) {
    int left = n;
    for (const int prime : primes)
      while (left % prime == 0) left /= prime;
    if (left == 1) numbers.push_back(n);
  }
  return numbers;
}

/// Returns the part of the points along axis k on rows that are transformed along other axes (Convolution::use). Along
/// y whole blocks of rows are transformed.
double used_part(const Mesh& mesh, const MeshRequest& request, int k) {
  constexpr int others_in_block = 15;
  const double used = request.open[k] ? request.lengths[k] / mesh.lengths[k] : request.used[k];
  const double margin = mesh.order + (k == 1 ? others_in_block : 0);
  return std::min(1.0, used + margin / mesh.points[k]);
}

}  // namespace

std::vector<int> quick_numbers() { return numbers_of({2, 3, 5}); }

SumMethod in_double_precision(double length, int lowest_order) {
  constexpr double pair = 6;
  const auto near = [](double density, double cutoff) {
    return pair * 0.5 * density * 4 * M_PI / 3 * std::pow(cutoff, 3);
  };
  return {quick_numbers(),
          {Window::spline},
          lowest_order,
          highest_double_order,
          0.5 * length,
          1.1,
          near,
          50,
          1.8,
          [](int) { return 0.55; },
          0.55};
}

SumMethod in_single_precision(double longest_cutoff, const std::vector<Window>& windows) {
  // Each charge of a cluster interacts with all charges within the cut-off of the cluster's box, a cube around
  // `together` charges. The search for these charges takes time too.
  constexpr double pair = 0.45, search = 15;
  const auto near = [](double density, double cutoff) {
    const double edge = std::cbrt(Near<float>::together / density), r = cutoff;
    const double volume = std::pow(edge, 3) + 6 * edge * edge * r + 3 * M_PI * edge * r * r + 4 * M_PI / 3 * r * r * r;
    return search + pair * 0.5 * density * volume;
  };
  // Large meshes do not fit into the second-level cache.
  const auto point = [](int points) { return points <= 100 ? 0.145 : 0.25; };
  return {quick_numbers(), windows, 4, 8, longest_cutoff, 1.05, near, 28, 1.1, point, 0.11};
}

SumMethod on_device(double length, const std::vector<Window>& windows) {
  constexpr double partner = 0.0036, skin = 0.5;
  const auto near = [](double density, double cutoff) {
    return partner * density * 4 * M_PI / 3 * std::pow(cutoff + skin, 3);
  };
  return {numbers_of({2, 3, 5, 7}),   windows, 4,   7, 0.5 * length, 1.05, near, 0.1, 0.006,
          [](int) { return 0.0025; }, 0.0025,  true};
}

// Transforms along z, x and y take a third of the time each. The rows along z are all that is used of the mesh in
// memory.
double work_on_mesh(const SumMethod& method, const Mesh& mesh, const MeshRequest& request) {
  const double points = static_cast<double>(mesh.points[0]) * mesh.points[1] * mesh.points[2];
  const double along_y = used_part(mesh, request, 1), rows = used_part(mesh, request, 0) * along_y;
  const double others = (rows + along_y + 1) / 3 - rows;
  const double point = method.point(mesh.points[2]);
  return points * std::log2(points) * (method.on_device ? point : rows * point + others * method.unused_point);
}

}  // namespace lichtenberg::periodic
