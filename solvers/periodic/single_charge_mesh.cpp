#include "solvers/periodic/single_charge_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "solvers/error.hpp"
#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/splines.hpp"
#include "solvers/periodic/turn.hpp"

namespace lichtenberg::periodic {

namespace {

using Four = Lanes<4, float>;

int halo_of(int order) { return order <= 4 ? 4 : 8; }

template <int order>
using FloatSpline = Spline<order, float>;

}  // namespace

const Mesh& SingleChargeMesh::checked_even(const Mesh& mesh) {
  if (mesh.points[2] % 2 != 0)
    throw InputError(
        fmt::format("a mesh in single precision has an even number of points along z: {} are not", mesh.points[2]));
  return checked(mesh, 8);
}

SingleChargeMesh::SingleChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence)
    : mesh_(mesh),
      grid_(mesh.points, halo_of(mesh.order), influence.factor, cloud.cutoff),
      self_(static_cast<float>(cloud.potential(0) * cloud.cutoff)),
      background_(-cloud.background / mesh.volume() * cloud.cutoff) {
  const auto waves = waves_from_middle(influence, mesh.order);
  for (int k = 0; k < 4; ++k) {
    over_spacing_[k] = k < 3 ? static_cast<float>(cloud.cutoff / mesh.spacing()[k]) : -1;
    for (int n = 0; n < 2; ++n) wave_[n][k] = static_cast<float>(waves[n][k] * cloud.cutoff);
  }
}

double SingleChargeMesh::reach() const {
  const Vec3 spacing = mesh_.spacing();
  return 0.5 * mesh_.order * std::max({spacing.x, spacing.y, spacing.z});
}

/// Where the points around a place are, and their weights.
template <int order>
struct SingleChargeMesh::Rows {
  using S = FloatSpline<order>;
  std::array<std::ptrdiff_t, order> plane, row;
  std::array<float, 3> behind;  ///< the point before it, in spacings
  typename S::Row weight[3];

  Rows(const SingleConvolution& grid, const Columns& columns, int s) {
    std::array<int, 3> point;
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t spacings = static_cast<std::uint64_t>(columns.place(k)[s]) * grid.points()[k];
      point[k] = static_cast<int>(spacings >> 32);
      behind[k] = static_cast<float>(static_cast<std::int64_t>(spacings & 0xffffffff)) * 0x1p-32f;
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
void SingleChargeMesh::spread_charge(const Columns& columns, int s) {
  using S = FloatSpline<order>;
  const Rows<order> rows(grid_, columns, s);
  const typename S::Row z = columns.charge()[s] * rows.weight[2];
  for (int a = 0; a < order; ++a) {
    const typename S::Row along_z = rows.weight[0][a] * z;
    float* plane = grid_.data() + rows.plane[a];
    for (int b = 0; b < order; ++b) lanes<S::lanes>(&plane[rows.row[b]]) += rows.weight[1][b] * along_z;
  }
}

void SingleChargeMesh::spread(const Columns& columns, parallel::Team& team) {
  grid_.clear(team);
  total_ = columns.total_charge();
  with_order<8>(mesh_.order, [&](auto order) {
    columns.for_each_apart(team, [&] [[gnu::noinline]] (int first, int end) {
      for (int s = columns.first(first)[0]; s < columns.first(end)[0]; ++s) spread_charge<order>(columns, s);
    });
  });
}

template <int order>
void SingleChargeMesh::add_to(const Columns& columns, int s, float background, float* sum) const {
  using S = FloatSpline<order>;
  using Row = typename S::Row;
  const Rows<order> rows(grid_, columns, s);
  Row slope[3];
  for (int k = 0; k < 3; ++k) S::slopes(rows.behind[k], slope[k]);
  Row potential{}, along_x{}, along_y{};
  for (int a = 0; a < order; ++a) {
    const float* plane = grid_.data() + rows.plane[a];
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
  const Four& over_spacing = lanes<4>(over_spacing_.data());
  Four felt = -over_spacing * totals(half(rows.weight[2], along_x), half(rows.weight[2], along_y),
                                     half(slope[2], potential), half(rows.weight[2], potential));
  // What it sees of its own cloud, as in ChargeMesh.
  const float charge = columns.charge()[s];
  const Four behind = Four{rows.behind[0], rows.behind[1], rows.behind[2], 0.5f} - 0.5f;
  const Turn<float> turn(behind);
  const Four first = lanes<4>(wave_[0].data()), second = lanes<4>(wave_[1].data());
  const Four own = first * turn.cosine + second * turn.twice();
  Four off = turn.slope * behind * (first + 4 * second * turn.cosine) * over_spacing * charge;
  off[3] = background - charge * (self_ + own[0] + own[1] + own[2]);
  lanes<4>(sum) += felt + off;
}

void SingleChargeMesh::add(const Columns& columns, std::span<float> sums, parallel::Team& team) const {
  constexpr int charges_a_task = 512;
  const auto background = static_cast<float>(background_ * total_);
  with_order<8>(mesh_.order, [&](auto order) {
    team.for_each((columns.size() + charges_a_task - 1) / charges_a_task, [&] [[gnu::noinline]] (int task) {
      const int first = task * charges_a_task, end = std::min(columns.size(), first + charges_a_task);
      for (int s = first; s < end; ++s) add_to<order>(columns, s, background, &sums[4 * s]);
    });
  });
}

}  // namespace lichtenberg::periodic
