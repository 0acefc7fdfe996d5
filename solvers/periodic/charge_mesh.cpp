#include "solvers/periodic/charge_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "solvers/error.hpp"
#include "solvers/periodic/splines.hpp"

namespace lichtenberg::periodic {

namespace {

const Mesh& checked(const Mesh& mesh) {
  require_consistent({.lengths = mesh.lengths});
  if (mesh.order < 4 || mesh.order > 7)
    throw InputError(fmt::format("Splines of order {} are not available: 4 to 7 are.", mesh.order));
  for (int k = 0; k < 3; ++k) {
    if (mesh.points[k] < 2 * mesh.order)
      throw InputError(
          fmt::format("A mesh with {} points along an axis is too coarse for splines of order {}: {} are "
                      "needed.",
                      mesh.points[k], mesh.order, 2 * mesh.order));
  }
  return mesh;
}

/// Of cos(2 pi s), in powers of s^2.
constexpr int cosine_terms = 9;
constexpr std::array<double, cosine_terms> cosine_series = [] {
  std::array<double, cosine_terms> series{1};
  for (int k = 1; k < cosine_terms; ++k) series[k] = -series[k - 1] * 4 * M_PI * M_PI / (2 * k * (2 * k - 1));
  return series;
}();

using Four = Lanes<4>;

/// The sums of four times four numbers, adjacent ones first.
Four totals(const Four& a, const Four& b, const Four& c, const Four& d) {
  const Four ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

/// Rows that a place needs go on this far behind the end.
int halo(int order) { return order <= 4 ? 4 : 8; }

}  // namespace

template <class Work>
void ChargeMesh::with_order(Work&& work) const {
  switch (mesh_.order) {
    case 4:
      return work(std::integral_constant<int, 4>{});
    case 5:
      return work(std::integral_constant<int, 5>{});
    case 6:
      return work(std::integral_constant<int, 6>{});
    case 7:
      return work(std::integral_constant<int, 7>{});
  }
}

ChargeMesh::ChargeMesh(const Mesh& mesh, const Cloud& cloud)
    : mesh_(checked(mesh)),
      influence_(optimal_influence(mesh, cloud)),
      self_(cloud.potential(0)),
      background_(-cloud.background / mesh.volume()),
      grid_(mesh.points, halo(mesh.order)),
      over_spacing_{1 / mesh.spacing().x, 1 / mesh.spacing().y, 1 / mesh.spacing().z, -1} {
  // Half a spacing turns the first wave round; so does the mesh's lying back by half of an odd order.
  for (int k = 0; k < 3; ++k) {
    wave_[0][k] = influence_.self_wave[k][0] * (mesh.order % 2 == 0 ? -1 : 1);
    wave_[1][k] = influence_.self_wave[k][1];
  }
}

double ChargeMesh::reach() const {
  const Vec3 spacing = mesh_.spacing();
  return 0.5 * mesh_.order * std::max({spacing.x, spacing.y, spacing.z});
}

/// Where the points around a place are, and their weights.
template <int order>
struct ChargeMesh::Rows {
  using S = Spline<order>;
  std::array<std::ptrdiff_t, order> plane, row;
  std::array<double, 3> behind;  ///< the point before it, in spacings
  alignas(64) typename S::Row weight[3];

  Rows(const Convolution& grid, const double* over_spacing, const double* place) {
    std::array<int, 3> point;
    for (int k = 0; k < 3; ++k) {
      const double spacings = place[k] * over_spacing[k];
      // Rounding may have put it at the box's far end, or a little outside.
      point[k] = std::clamp(static_cast<int>(spacings), 0, grid.points()[k] - 1);
      behind[k] = spacings - point[k];
      S::weights(behind[k], weight[k]);
    }
    for (int c = 0; c < order; ++c) {
      plane[c] = wrapped(point[0] + c, grid.points()[0]) * grid.plane() + point[2];
      row[c] = wrapped(point[1] + c, grid.points()[1]) * grid.row();
    }
  }
  static int wrapped(int point, int points) { return point < points ? point : point - points; }
};

template <int order>
void ChargeMesh::spread_charge(const double* charge) {
  using S = Spline<order>;
  const Rows<order> rows(grid_, over_spacing_.data(), charge);
  const typename S::Row z = charge[3] * rows.weight[2];
  for (int a = 0; a < order; ++a) {
    const typename S::Row along_z = rows.weight[0][a] * z;
    double* plane = grid_.data() + rows.plane[a];
    for (int b = 0; b < order; ++b) lanes<S::lanes>(&plane[rows.row[b]]) += rows.weight[1][b] * along_z;
  }
}

void ChargeMesh::spread(const Tiles& tiles, parallel::Team& team) {
  grid_.clear(team);
  total_ = 0;
  for (int s = 0; s < tiles.size(); ++s) total_ += tiles.place_and_charge(s)[3];
  with_order([&](auto order) {
    tiles.for_each_apart(team, [&](int first, int end) {
      for (int s = first; s < end; ++s) spread_charge<order>(tiles.place_and_charge(s));
    });
  });
}

void ChargeMesh::solve(parallel::Team& team) { grid_.apply(influence_.factor, team); }

template <int order>
void ChargeMesh::add_to(double* sum, const double* charge) const {
  using S = Spline<order>;
  using Row = typename S::Row;
  const Rows<order> rows(grid_, over_spacing_.data(), charge);
  Row slope[3];
  for (int k = 0; k < 3; ++k) S::slopes(rows.behind[k], slope[k]);
  Row potential{}, along_x{}, along_y{};  // and their like: potential and derivatives in the plane, for each z
  for (int a = 0; a < order; ++a) {
    const double* plane = grid_.data() + rows.plane[a];
    Row here{}, slope_y{};
    for (int b = 0; b < order; ++b) {
      const Row& row = lanes<S::lanes>(&plane[rows.row[b]]);
      here += rows.weight[1][b] * row;
      slope_y += slope[1][b] * row;
    }
    potential += rows.weight[0][a] * here;
    along_x += slope[0][a] * here;
    along_y += rows.weight[0][a] * slope_y;
  }
  const auto half = [](const Row& weight, const Row& row) {
    const Row product = weight * row;
    if constexpr (S::lanes == 4)
      return product;
    else
      return Four(__builtin_shufflevector(product, product, 0, 1, 2, 3) +
                  __builtin_shufflevector(product, product, 4, 5, 6, 7));
  };
  lanes<4>(sum) -= totals(half(rows.weight[2], along_x), half(rows.weight[2], along_y), half(slope[2], potential),
                          half(rows.weight[2], potential)) *
                   lanes<4>(over_spacing_.data());
  take_self_off(sum, rows.behind, charge[3]);
}

/// The potential of its own cloud, and the field that is half its slope: half, for the cloud moves with the charge.
void ChargeMesh::take_self_off(double* sum, const std::array<double, 3>& behind, double charge) const {
  // cos and sin of 2 pi times the distance from the middle between two points, by their Taylor series: off by 2e-7
  // at the points, of an effect that is itself an error of the mesh.
  const Four s = Four{behind[0], behind[1], behind[2], 0.5} - 0.5, s2 = s * s;
  Four cosine{}, slope{};
  for (int term = cosine_terms - 1; term >= 0; --term) {
    slope = slope * s2 + cosine;
    cosine = cosine * s2 + cosine_series[term];
  }
  const Four first = lanes<4>(wave_[0].data()), second = lanes<4>(wave_[1].data());
  const Four potential = first * cosine + second * (2 * cosine * cosine - 1);
  Four off = slope * s * (first + 4 * second * cosine) * lanes<4>(over_spacing_.data()) * charge;
  off[3] = background_ * total_ - charge * (self_ + potential[0] + potential[1] + potential[2]);
  lanes<4>(sum) += off;
}

void ChargeMesh::add(const Tiles& tiles, FieldAndPotential sum, parallel::Team& team) const {
  constexpr int charges_a_task = 512;
  with_order([&](auto order) {
    team.for_each((tiles.size() + charges_a_task - 1) / charges_a_task, [&](int task) {
      const int first = task * charges_a_task, end = std::min(tiles.size(), first + charges_a_task);
      for (int s = first; s < end; ++s) add_to<order>(&sum[4 * s], tiles.place_and_charge(s));
    });
  });
}

}  // namespace lichtenberg::periodic
