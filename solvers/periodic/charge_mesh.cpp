#include "solvers/periodic/charge_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "solvers/error.hpp"
#include "solvers/periodic/splines.hpp"
#include "solvers/periodic/turn.hpp"

namespace lichtenberg::periodic {

namespace {

using Four = Lanes<4>;

Four from_middle(const std::array<double, 3>& behind) { return Four{behind[0], behind[1], behind[2], 0.5} - 0.5; }

/// Rows that a place needs go on this far behind the end.
int halo(int order) { return order <= 4 ? 4 : 8; }

}  // namespace

const Mesh& checked(const Mesh& mesh, int highest_order) {
  require_consistent({.lengths = mesh.lengths});
  if (mesh.order < 4 || mesh.order > highest_order)
    throw InputError(fmt::format("windows of order {} are not available: 4 to {} are", mesh.order, highest_order));
  for (int k = 0; k < 3; ++k) {
    if (mesh.points[k] < 2 * mesh.order)
      throw InputError(
          fmt::format("a mesh with {} points along an axis is too coarse for windows of order {}: {} are "
                      "needed",
                      mesh.points[k], mesh.order, 2 * mesh.order));
  }
  return mesh;
}

namespace {

const Mesh& with_splines(const Mesh& mesh) {
  if (mesh.window != Window::spline) throw InputError("a mesh in double precision has splines for windows");
  return checked(mesh, 7);
}

}  // namespace

template <class Work>
void ChargeMesh::with_constants(Kind kind, Work&& work) const {
  const auto with_kind = [&](auto order) {
    switch (kind) {
      case Kind::charges:
        return work(order, std::integral_constant<Kind, Kind::charges>{});
      case Kind::dipoles:
        return work(order, std::integral_constant<Kind, Kind::dipoles>{});
      case Kind::multipoles:
        return work(order, std::integral_constant<Kind, Kind::multipoles>{});
    }
  };
  with_order<7>(mesh_.order, with_kind);
}

ChargeMesh::ChargeMesh(const Mesh& mesh, const Cloud& cloud)
    : mesh_(with_splines(mesh)),
      influence_(optimal_influence(mesh, cloud)),
      wave_(waves_from_middle(influence_, mesh.order)),
      self_(cloud.potential(0)),
      self_field_(cloud.dipole_field),
      background_(-cloud.background / mesh.volume()),
      grid_(mesh.points, halo(mesh.order), influence_.factor, 1),
      over_spacing_{1 / mesh.spacing().x, 1 / mesh.spacing().y, 1 / mesh.spacing().z, -1} {}

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

  Rows(const Convolution<double>& grid, const double* over_spacing, const double* place) {
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

// A dipole's potential is mu.grad of a charge's by its own place, so it is spread with mu.grad of the weights.
template <int order, Kind kind>
void ChargeMesh::spread_source(const Tiles& tiles, int s) {
  using S = Spline<order>;
  using Row = typename S::Row;
  const double* charge = tiles.place_and_charge(s);
  const Rows<order> rows(grid_, over_spacing_.data(), charge);
  const auto row = [&](int a, int b) -> Row& { return lanes<S::lanes>(&grid_.data()[rows.plane[a] + rows.row[b]]); };
  if constexpr (kind == Kind::charges) {
    const Row z = charge[3] * rows.weight[2];
    for (int a = 0; a < order; ++a) {
      const Row along_z = rows.weight[0][a] * z;
      for (int b = 0; b < order; ++b) row(a, b) += rows.weight[1][b] * along_z;
    }
  } else {
    Row slope[3];
    const double* dipole = tiles.dipole(s);
    for (int k = 0; k < 3; ++k) {
      S::slopes(rows.behind[k], slope[k]);
      slope[k] *= dipole[k] * over_spacing_[k];
    }
    Row z = slope[2];
    if constexpr (kind == Kind::multipoles) z += charge[3] * rows.weight[2];
    for (int a = 0; a < order; ++a) {
      const Row along_z = rows.weight[0][a] * z + slope[0][a] * rows.weight[2];
      const Row moved_y = rows.weight[0][a] * rows.weight[2];
      for (int b = 0; b < order; ++b) row(a, b) += rows.weight[1][b] * along_z + slope[1][b] * moved_y;
    }
  }
}

void ChargeMesh::spread(const Tiles& tiles, Kind kind, parallel::Team& team) {
  grid_.clear(team);
  total_ = 0;
  for (int s = 0; s < tiles.size(); ++s) total_ += tiles.place_and_charge(s)[3];
  with_constants(kind, [&](auto order, auto constant) {
    tiles.for_each_apart(team, [&](int first, int end) {
      for (int s = first; s < end; ++s) spread_source<order, constant>(tiles, s);
    });
  });
}

void ChargeMesh::solve(parallel::Team& team) { grid_.apply(team); }

template <int order, Kind kind>
void ChargeMesh::add_to(const FeltSums& sums, const Tiles& tiles, int s) const {
  using S = Spline<order>;
  using Row = typename S::Row;
  constexpr bool forces = kind == Kind::multipoles;
  const double* charge = tiles.place_and_charge(s);
  const Rows<order> rows(grid_, over_spacing_.data(), charge);
  Row slope[3], curvature[3];
  for (int k = 0; k < 3; ++k) S::slopes(rows.behind[k], slope[k]);
  for (int k = 0; k < 3 && forces; ++k) S::curvatures(rows.behind[k], curvature[k]);
  Row potential{}, along_x{}, along_y{};  // and their like: potential and derivatives in the plane, for each z
  Row xx{}, xy{}, yy{};
  for (int a = 0; a < order; ++a) {
    const double* plane = grid_.data() + rows.plane[a];
    Row here{}, slope_y{}, curvature_y{};
    for (int b = 0; b < order; ++b) {
      const Row& row = lanes<S::lanes>(&plane[rows.row[b]]);
      here += rows.weight[1][b] * row;
      slope_y += slope[1][b] * row;
      if constexpr (forces) curvature_y += curvature[1][b] * row;
    }
    potential += rows.weight[0][a] * here;
    along_x += slope[0][a] * here;
    along_y += rows.weight[0][a] * slope_y;
    if constexpr (forces) {
      xx += curvature[0][a] * here;
      xy += slope[0][a] * slope_y;
      yy += rows.weight[0][a] * curvature_y;
    }
  }
  const auto half = [](const Row& weight, const Row& row) {
    const Row product = weight * row;
    if constexpr (S::lanes == 4)
      return product;
    else
      return Four(__builtin_shufflevector(product, product, 0, 1, 2, 3) +
                  __builtin_shufflevector(product, product, 4, 5, 6, 7));
  };
  double* sum = &sums.field[4 * s];
  const Four& over_spacing = lanes<4>(over_spacing_.data());
  const Four slopes = totals(half(rows.weight[2], along_x), half(rows.weight[2], along_y), half(slope[2], potential),
                             half(rows.weight[2], potential));
  lanes<4>(sum) -= slopes * over_spacing;
  if constexpr (kind != Kind::dipoles) take_self_off(sum, rows.behind, charge[3]);
  if constexpr (kind != Kind::charges) lanes<4>(sum) += self_field_ * lanes<4>(tiles.dipole(s));
  if constexpr (forces) {
    double* force = &sums.force[4 * s];
    const Four moment = lanes<4>(tiles.dipole(s)) * over_spacing;
    const Four straight =  // xx, yy, zz
        totals(half(rows.weight[2], xx), half(rows.weight[2], yy), half(curvature[2], potential), Four{});
    const Four across =  // yz, zx, xy
        totals(half(slope[2], along_y), half(slope[2], along_x), half(rows.weight[2], xy), Four{});
    const auto next = [](const Four& v) { return Four(__builtin_shufflevector(v, v, 1, 2, 0, 3)); };
    const auto last = [](const Four& v) { return Four(__builtin_shufflevector(v, v, 2, 0, 1, 3)); };
    lanes<4>(force) -=
        (charge[3] * slopes + straight * moment + last(across) * next(moment) + next(across) * last(moment)) *
        over_spacing;
    take_multipole_off(sum, force, rows.behind, charge[3], tiles.dipole(s));
  }
}

/// The potential of its own cloud, and the field that is half its slope: half, for the cloud moves with the charge.
void ChargeMesh::take_self_off(double* sum, const std::array<double, 3>& behind, double charge) const {
  const Four s = from_middle(behind);
  const Turn<> turn(s);
  const Four first = lanes<4>(wave_[0].data()), second = lanes<4>(wave_[1].data());
  const Four potential = first * turn.cosine + second * turn.twice();
  Four off = turn.slope * s * (first + 4 * second * turn.cosine) * lanes<4>(over_spacing_.data()) * charge;
  off[3] = background_ * total_ - charge * (self_ + potential[0] + potential[1] + potential[2]);
  lanes<4>(sum) += off;
}

/// With g the potential of a unit charge at its own place, its and a dipole's own energy is 1/2 q^2 g + 1/2 q mu.grad
/// g; the dipole's with itself is taken for the same everywhere, as its waves are 1 % of the error in a gas. What is
/// left of that energy's slopes after the potential and the field of the charge.
void ChargeMesh::take_multipole_off(double* sum, double* force, const std::array<double, 3>& behind, double charge,
                                    const double* dipole) const {
  const Four s = from_middle(behind), over_spacing = lanes<4>(over_spacing_.data()), mu = lanes<4>(dipole);
  const Turn<> turn(s);
  const Four first = lanes<4>(wave_[0].data()), second = lanes<4>(wave_[1].data());
  const Four half_slope = turn.slope * s * (first + 4 * second * turn.cosine) * over_spacing;
  const Four curvature =
      -4 * M_PI * M_PI * (first * turn.cosine + 4 * second * turn.twice()) * over_spacing * over_spacing;
  const Four along = mu * half_slope;
  sum[3] -= along[0] + along[1] + along[2];
  lanes<4>(force) += charge * (charge * half_slope + 0.5 * curvature * mu);
}

void ChargeMesh::add(const Tiles& tiles, Kind kind, const FeltSums& sums, parallel::Team& team) const {
  constexpr int charges_a_task = 512;
  with_constants(kind, [&](auto order, auto constant) {
    team.for_each((tiles.size() + charges_a_task - 1) / charges_a_task, [&](int task) {
      const int first = task * charges_a_task, end = std::min(tiles.size(), first + charges_a_task);
      for (int s = first; s < end; ++s) add_to<order, constant>(sums, tiles, s);
    });
  });
}

}  // namespace lichtenberg::periodic
