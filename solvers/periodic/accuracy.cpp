#include "solvers/periodic/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

namespace {

/// Of the force between unit charges, squared, over all space from contact on.
double force2(double contact) { return 4 * M_PI / contact; }

// Nanoseconds on one core, from validation/benchmarks/periodic.cpp: a pair within the cutoff; a charge, and each row of
// the mesh that it meets; a point of the mesh for each doubling of their number, there and back.
constexpr double pair_cost = 6, charge_cost = 50, row_cost = 1.8, point_cost = 0.55;

double work(int charges, const Mesh& mesh, double cutoff) {
  const double pairs = 0.5 * charges * charges / mesh.volume() * 4 * M_PI / 3 * std::pow(cutoff, 3);
  const double points = static_cast<double>(mesh.points[0]) * mesh.points[1] * mesh.points[2];
  return pair_cost * pairs + charges * (charge_cost + row_cost * mesh.order * mesh.order) +
         point_cost * points * std::log2(points);
}

/// Numbers up to 1024 that FFTW's estimated plans are quick for: others nearby, multiples of 15 most of all, take up to
/// three times as long.
std::vector<int> quick_numbers() {
  std::vector<int> numbers;
  for (int n = 16; n <= 1024; n += 8) {
    int left = n;
    for (const int prime : {2, 3, 5, 7})
      while (left % prime == 0) left /= prime;
    if (left == 1 && n % 15 != 0) numbers.push_back(n);
  }
  return numbers;
}

/// With spacings of at most that of `along_longest` points along the longest side, if there are so many.
std::optional<Mesh> mesh_of(int along_longest, const std::vector<int>& numbers, Vec3 lengths, int order) {
  const double longest = std::max({lengths.x, lengths.y, lengths.z});
  Mesh mesh{lengths, {}, order};
  for (int k = 0; k < 3; ++k) {
    const auto points = std::ranges::lower_bound(numbers, lengths[k] / longest * along_longest * (1 - 1e-12));
    if (points == numbers.end()) return {};
    mesh.points[k] = *points;
  }
  return mesh;
}

/// The same spacings in a small box, where the same error is found with less work.
Mesh sample_of(const Mesh& mesh) {
  Mesh sample = mesh;
  for (int k = 0; k < 3; ++k) {
    sample.points[k] = std::min(mesh.points[k], 16);
    sample.lengths[k] = mesh.spacing()[k] * sample.points[k];
  }
  return sample;
}

/// The lowest band limit that loses no more than `most`; the loss falls with it.
double band_limit_for(double most, double cutoff) {
  double low = 1, high = 100;
  while (high - low > 1e-3) {
    const double middle = 0.5 * (low + high);
    (prolate_cloud(middle, cutoff).lost > most ? low : high) = middle;
  }
  return high;
}

/// The coarsest mesh whose error is no more than `most`.
std::optional<Mesh> coarsest(const Cloud& cloud, double most, const std::vector<int>& numbers, Vec3 lengths,
                             int order) {
  const auto fine_enough = [&](int number) {
    const auto mesh = mesh_of(number, numbers, lengths, order);
    return mesh && mesh_error(sample_of(*mesh), cloud) <= most;
  };
  const auto number = std::ranges::partition_point(numbers, [&](int n) { return !fine_enough(n); });
  return number == numbers.end() ? std::nullopt : mesh_of(*number, numbers, lengths, order);
}

}  // namespace

double random_force(double charge2, double charges, double volume, double contact) {
  return charge2 * std::sqrt(force2(contact) / (charges * volume));
}

double relative_error(const Mesh& mesh, const Cloud& cloud, double contact) {
  return std::sqrt((cloud.lost + mesh_error(mesh, cloud)) / force2(contact));
}

MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order) {
  require_consistent({.lengths = lengths});
  if (!(contact > 0))
    throw InputError(fmt::format("Charges come as near as {} to each other: it must be positive.", contact));
  if (!(accuracy >= 1e-8 && accuracy <= 0.1))
    throw InputError(fmt::format("An accuracy of {} cannot be asked of a mesh: 1e-8 to 0.1 can.", accuracy));
  const double most = 0.5 * accuracy * accuracy * force2(contact);  // for near part and mesh each
  const double shortest = std::min({lengths.x, lengths.y, lengths.z});
  const auto numbers = quick_numbers();
  MeshChoice best;
  double least = INFINITY;
  for (double cutoff = 0.5 * shortest; cutoff > contact; cutoff /= 1.1) {
    const double band_limit = band_limit_for(most, cutoff);
    const Cloud cloud = prolate_cloud(band_limit, cutoff);
    for (int order = lowest_order; order <= 7; ++order) {
      const auto mesh = coarsest(cloud, most, numbers, lengths, order);
      if (!mesh || work(charges, *mesh, cutoff) >= least) continue;
      least = work(charges, *mesh, cutoff);
      best = {*mesh, band_limit, cutoff};
    }
  }
  if (!std::isfinite(least))
    throw InputError(
        fmt::format("No mesh of up to 1024 points along a side reaches an accuracy of {} in a box of {} x "
                    "{} x {} with a cutoff of up to half of it.",
                    accuracy, lengths.x, lengths.y, lengths.z));
  best.error = relative_error(best.mesh, prolate_cloud(best.band_limit, best.cutoff), contact);
  return best;
}

}  // namespace lichtenberg::periodic
