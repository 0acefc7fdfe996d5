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

/// Weights of a row of points, zeros behind the last, and with their slopes behind them: as wide as vectors of numbers
/// that processors have.
template <int order>
constexpr int lanes_of = order <= 4 ? 4 : 8;
template <int order>
using Row = Lanes<lanes_of<order>, float>;
template <int order>
using Both = Lanes<2 * lanes_of<order>, float>;

template <int order>
Row<order> low_half(const Both<order>& both) {
  if constexpr (order <= 4)
    return __builtin_shufflevector(both, both, 0, 1, 2, 3);
  else
    return __builtin_shufflevector(both, both, 0, 1, 2, 3, 4, 5, 6, 7);
}
template <int order>
Row<order> high_half(const Both<order>& both) {
  if constexpr (order <= 4)
    return __builtin_shufflevector(both, both, 4, 5, 6, 7);
  else
    return __builtin_shufflevector(both, both, 8, 9, 10, 11, 12, 13, 14, 15);
}
template <int order>
Both<order> joined(const Row<order>& low, const Row<order>& high) {
  if constexpr (order <= 4)
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  else
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}
std::vector<float> table_of(const Mesh& mesh) {
  const int lanes = mesh.order <= 4 ? 4 : 8;
  const auto pieces = window_pieces(mesh.window, mesh.order);
  std::vector<float> table(2 * lanes * pieces.size());
  for (std::size_t d = 0; d < pieces.size(); ++d)
    for (int c = 0; c < mesh.order; ++c) {
      table[2 * lanes * d + c] = static_cast<float>(pieces[d][c]);
      if (d > 0) table[2 * lanes * (d - 1) + lanes + c] = static_cast<float>(static_cast<double>(d) * pieces[d][c]);
    }
  return table;
}

/// Rows, or rows with their slopes, at three places between points.
template <class Numbers, int order>
[[gnu::always_inline]] inline void polynomials(const std::vector<float>& table, const std::array<float, 3>& s,
                                               Numbers (&of)[3]) {
  constexpr int numbers = sizeof(Numbers) / sizeof(float);
  const auto coefficients = [&](int d) -> const Numbers& { return lanes<numbers>(&table[2 * lanes_of<order> * d]); };
  for (int k = 0; k < 3; ++k) of[k] = coefficients(order - 1);
#pragma GCC unroll 8
  for (int d = order - 2; d >= 0; --d)
    for (int k = 0; k < 3; ++k) of[k] = of[k] * s[k] + coefficients(d);
}

/// Where the points around a place are.
template <int order>
struct Rows {
  std::array<std::ptrdiff_t, order> plane, row;
  std::array<float, 3> from_middle;  ///< between two points, in spacings

  Rows(const Convolution<float>& grid, const Columns& columns, int s) {
    std::array<int, 3> point;
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t spacings = static_cast<std::uint64_t>(columns.place(k)[s]) * grid.points()[k];
      point[k] = static_cast<int>(spacings >> 32);
      from_middle[k] =
          static_cast<float>(static_cast<std::int32_t>(static_cast<std::uint32_t>(spacings) ^ 0x80000000u)) * 0x1p-32f;
    }
    for (int c = 0; c < order; ++c) {
      plane[c] = wrapped(point[0] + c, grid.points()[0]) * grid.plane() + point[2];
      row[c] = wrapped(point[1] + c, grid.points()[1]) * grid.row();
    }
  }
  static int wrapped(int point, int points) { return point < points ? point : point - points; }
};

/// Of the points around a place, summed over x and y with their weights: numbers along z, slopes by spacings.
template <int order>
struct AlongZ {
  Row<order> potential, slope_x, slope_y;
};

/// `x` and `y`: weights, and slopes.
template <int order>
[[gnu::always_inline]] inline AlongZ<order> summed_across(const Convolution<float>& grid, const Rows<order>& rows,
                                                          const Both<order>& x, const Both<order>& y) {
  Both<order> along_y[order];
#pragma GCC unroll 8
  for (int b = 0; b < order; ++b)
    along_y[b] = joined<order>(Row<order>{} + y[b], Row<order>{} + y[lanes_of<order> + b]);
  Both<order> here_and_slope_y{};
  Row<order> slope_x{};
#pragma GCC unroll 8
  for (int a = 0; a < order; ++a) {
    const float* plane = grid.data() + rows.plane[a];
    Both<order> in_plane{};
#pragma GCC unroll 8
    for (int b = 0; b < order; ++b) {
      const Row<order>& row = lanes<lanes_of<order>>(&plane[rows.row[b]]);
      in_plane += along_y[b] * joined<order>(row, row);
    }
    here_and_slope_y += x[a] * in_plane;
    slope_x += x[lanes_of<order> + a] * low_half<order>(in_plane);
  }
  return {low_half<order>(here_and_slope_y), slope_x, high_half<order>(here_and_slope_y)};
}

/// Slopes of the potential by spacings along x, y, z, and the potential; `z`: weights, and slopes.
template <int order>
[[gnu::always_inline]] inline Four summed_along(const AlongZ<order>& of, const Both<order>& z) {
  const Row<order> weight = low_half<order>(z), slope = high_half<order>(z);
  const auto half = [](const Row<order>& by, const Row<order>& row) {
    const Row<order> product = by * row;
    if constexpr (order <= 4)
      return product;
    else
      return Four(__builtin_shufflevector(product, product, 0, 1, 2, 3) +
                  __builtin_shufflevector(product, product, 4, 5, 6, 7));
  };
  return totals(half(weight, of.slope_x), half(weight, of.slope_y), half(slope, of.potential),
                half(weight, of.potential));
}

}  // namespace

const Mesh& SingleChargeMesh::checked_even(const Mesh& mesh) {
  if (mesh.points[2] % 2 != 0)
    throw InputError(
        fmt::format("a mesh in single precision has an even number of points along z: {} are not", mesh.points[2]));
  return checked(mesh, 8);
}

SingleChargeMesh::SingleChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence)
    : mesh_(mesh),
      window_(table_of(mesh)),
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

template <int order>
void SingleChargeMesh::spread_charge(const Columns& columns, int s) {
  const Rows<order> rows(grid_, columns, s);
  Row<order> weight[3];
  polynomials<Row<order>, order>(window_, rows.from_middle, weight);
  const Row<order> z = columns.charge()[s] * weight[2];
#pragma GCC unroll 8
  for (int a = 0; a < order; ++a) {
    const Row<order> along_z = weight[0][a] * z;
    float* plane = grid_.data() + rows.plane[a];
#pragma GCC unroll 8
    for (int b = 0; b < order; ++b) lanes<lanes_of<order>>(&plane[rows.row[b]]) += weight[1][b] * along_z;
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
  const Rows<order> rows(grid_, columns, s);
  Both<order> both[3];  // weights, and slopes
  polynomials<Both<order>, order>(window_, rows.from_middle, both);
  const AlongZ<order> line = summed_across(grid_, rows, both[0], both[1]);
  const Four& over_spacing = lanes<4>(over_spacing_.data());
  const Four felt = -over_spacing * summed_along<order>(line, both[2]);
  // What it sees of its own cloud, as in ChargeMesh.
  const float charge = columns.charge()[s];
  const Four place{rows.from_middle[0], rows.from_middle[1], rows.from_middle[2], 0};
  const Turn<float> turn(place);
  const Four first = lanes<4>(wave_[0].data()), second = lanes<4>(wave_[1].data());
  const Four own = first * turn.cosine + second * turn.twice();
  Four off = turn.slope * place * (first + 4 * second * turn.cosine) * over_spacing * charge;
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
