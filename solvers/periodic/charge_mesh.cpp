#include "solvers/periodic/charge_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/self_term.hpp"

namespace lichtenberg::periodic {

namespace {

/// Number of weights in a row, padded with zeros to the width of a SIMD register.
constexpr int row_lanes(int order) { return order <= 4 ? 4 : 8; }
template <int order, class Real>
using Row = Pack<row_lanes(order), Real>;

/// Row of weights followed by the row of their slopes.
template <int order, class Real>
using Both = Pack<2 * row_lanes(order), Real>;

/// Returns the coefficients of the weights' polynomials and of their slopes.
template <class Real>
std::vector<Real> window_table(const Mesh& mesh) {
  const int lanes = row_lanes(mesh.order);
  const auto pieces = window_pieces(mesh.window, mesh.order);
  std::vector<Real> table(2 * lanes * pieces.size());
  for (std::size_t d = 0; d < pieces.size(); ++d)
    for (int c = 0; c < mesh.order; ++c) {
      table[2 * lanes * d + c] = static_cast<Real>(pieces[d][c]);
      if (d > 0) table[2 * lanes * (d - 1) + lanes + c] = static_cast<Real>(static_cast<double>(d) * pieces[d][c]);
    }
  return table;
}
template <class Real>
std::vector<Real> curvature_table(const Mesh& mesh) {
  const int lanes = row_lanes(mesh.order);
  const auto pieces = window_pieces(mesh.window, mesh.order);
  std::vector<Real> table(lanes * (pieces.size() - 2));
  for (std::size_t d = 2; d < pieces.size(); ++d)
    for (int c = 0; c < mesh.order; ++c)
      table[lanes * (d - 2) + c] = static_cast<Real>(static_cast<double>(d * (d - 1)) * pieces[d][c]);
  return table;
}

/// Evaluates polynomials at three positions; coefficients of successive powers are `stride` numbers apart.
template <int terms, class Numbers, class Real>
[[gnu::always_inline]] inline void polynomials(const std::vector<Real>& table, int stride, const std::array<Real, 3>& s,
                                               Numbers (&of)[3]) {
  const auto coefficients = [&](int d) -> const Numbers& {
    return *reinterpret_cast<const Numbers*>(&table[stride * d]);
  };
  for (int k = 0; k < 3; ++k) of[k] = coefficients(terms - 1);
#pragma GCC unroll 8
  for (int d = terms - 2; d >= 0; --d)
    for (int k = 0; k < 3; ++k) of[k] = of[k] * s[k] + coefficients(d);
}

/// Offsets of the mesh points around a position.
template <int order, class Real>
struct Rows {
  std::array<std::ptrdiff_t, order> plane, row;
  std::array<Real, 3> from_middle;  ///< Position relative to the middle between two points, in spacings

  Rows(const Convolution<Real>& grid, const Columns<Real>& columns, int s) {
    using FixedPoint = Coordinate<Real>;
    constexpr FixedPoint half = FixedPoint{1} << (bits_of<Real> - 1);
    std::array<int, 3> point;
    for (int k = 0; k < 3; ++k) {
      const InParts<FixedPoint> at(columns.coordinate(k)[s], grid.points()[k]);
      point[k] = at.part;
      from_middle[k] = static_cast<Real>(static_cast<Difference<Real>>(at.rest ^ half)) *
                       (sizeof(Real) == 4 ? Real(0x1p-32) : Real(0x1p-64));
    }
    for (int c = 0; c < order; ++c) {
      plane[c] = wrapped(point[0] + c, grid.points()[0]) * grid.plane() + point[2];
      row[c] = wrapped(point[1] + c, grid.points()[1]) * grid.row();
    }
  }
  static int wrapped(int point, int points) { return point < points ? point : point - points; }
};

/// Mesh values around a position, summed over x and y with the weights: potential and its derivatives in the plane for
/// each z, per spacing.
template <int order, class Real>
struct AlongZ {
  Row<order, Real> potential, x, y, xx, xy, yy;
};

/// Sums over x and y. `w`: weights and slopes of the axes; `curvature`: second derivatives of the weights along x and
/// y, null if not needed.
template <int order, class Real>
[[gnu::always_inline]] inline AlongZ<order, Real> summed_across(const Convolution<Real>& grid,
                                                                const Rows<order, Real>& rows,
                                                                const Both<order, Real> (&w)[3],
                                                                const Row<order, Real>* curvature) {
  using R = Row<order, Real>;
  using B = Both<order, Real>;
  constexpr int lanes_of = row_lanes(order);
  const B &x = w[0], &y = w[1];
  B along_y[order];
#pragma GCC unroll 8
  for (int b = 0; b < order; ++b) along_y[b] = packed<B>(R{} + y[b], R{} + y[lanes_of + b]);
  B here_and_slope_y{};
  R slope_x{}, xx{}, xy{}, yy{};
#pragma GCC unroll 8
  for (int a = 0; a < order; ++a) {
    const Real* plane = grid.data() + rows.plane[a];
    B in_plane{};
    R bent{};
#pragma GCC unroll 8
    for (int b = 0; b < order; ++b) {
      const R& row = pack_at<R>(&plane[rows.row[b]]);
      in_plane += along_y[b] * packed<B>(row, row);
      if (curvature) bent += curvature[1][b] * row;
    }
    here_and_slope_y += x[a] * in_plane;
    slope_x += x[lanes_of + a] * low_half(in_plane);
    if (!curvature) continue;
    xx += curvature[0][a] * low_half(in_plane);
    xy += x[lanes_of + a] * high_half(in_plane);
    yy += x[a] * bent;
  }
  return {low_half(here_and_slope_y), slope_x, high_half(here_and_slope_y), xx, xy, yy};
}

/// Returns the product of two rows, reduced to four numbers.
template <class R>
[[gnu::always_inline]] inline auto quarter(const R& by, const R& row) {
  const R product = by * row;
  if constexpr (count_of<R> == 4)
    return product;
  else
    return low_half(product) + high_half(product);
}

/// Computes the self term of four axes. cos(2 pi s) and half of its derivative are Taylor series. At the mesh points,
/// half a spacing from the middle, their errors are 1.4e-7 and 2.4e-6 (single precision: 1.0e-4 and 1.4e-3). This
/// suffices, since the self term is itself an error of the mesh.
template <class Real>
SelfTerm<Lanes<4, Real>> self_term_by_series(const Lanes<4, Real>& s, const Lanes<4, Real>& first,
                                             const Lanes<4, Real>& second, const Lanes<4, Real>& inverse_spacing) {
  constexpr int terms = sizeof(Real) == sizeof(double) ? 9 : 7;
  constexpr auto series = [] {  // Powers of s^2
    std::array<Real, terms> of{};
    double term = 1;
    for (int k = 0; k < terms; term *= -4 * M_PI * M_PI / ((2 * k + 2) * (2 * k + 1)), ++k)
      of[k] = static_cast<Real>(term);
    return of;
  }();
  const Lanes<4, Real> s2 = s * s;
  Lanes<4, Real> cosine{}, slope{};
  for (int term = terms - 1; term >= 0; --term) {
    slope = slope * s2 + cosine;
    cosine = cosine * s2 + series[term];
  }
  return self_term<Real, Lanes<4, Real>>(cosine, slope * s, first, second, inverse_spacing);
}

const Mesh& checked_for(const Mesh& mesh, bool single) {
  if (single && mesh.points[2] % 2 != 0)
    throw InputError(
        fmt::format("a mesh in single precision has an even number of points along z: {} are not", mesh.points[2]));
  if (!single && mesh.window != Window::spline) throw InputError("a mesh in double precision has splines for windows");
  return checked(mesh, single ? 8 : 7);
}

template <int order>
using OrderConstant = std::integral_constant<int, order>;
template <Kind kind>
using KindConstant = std::integral_constant<Kind, kind>;

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

double reach_of(const Mesh& mesh) {
  const Vec3 spacing = mesh.spacing();
  return 0.5 * mesh.order * std::max({spacing.x, spacing.y, spacing.z});
}

template <class Real>
ChargeMesh<Real>::ChargeMesh(const Mesh& mesh, const Cloud& cloud)
    : ChargeMesh(mesh, cloud, optimal_influence(checked_for(mesh, sizeof(Real) == 4), cloud)) {}

template <class Real>
ChargeMesh<Real>::ChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence)
    : mesh_(mesh),
      window_(window_table<Real>(mesh)),
      curvature_(curvature_table<Real>(mesh)),
      grid_(mesh.points, row_lanes(mesh.order), influence.factor, cloud.cutoff),
      self_(static_cast<Real>(cloud.potential(0) * cloud.cutoff)),
      self_field_(static_cast<Real>(cloud.dipole_field * std::pow(cloud.cutoff, 3))),
      background_(mesh.open.any() ? 0 : -cloud.background / mesh.volume() * cloud.cutoff) {
  const auto waves = waves_from_middle(influence, mesh.order);
  for (int k = 0; k < 4; ++k) {
    inverse_spacing_[k] = k < 3 ? static_cast<Real>(cloud.cutoff / mesh.spacing()[k]) : -1;
    for (int n = 0; n < 2; ++n) wave_[n][k] = static_cast<Real>(waves[n][k] * cloud.cutoff);
  }
}

/// Calls work(order, kind) with compile-time constants.
template <class Real>
template <class Work>
void ChargeMesh<Real>::with_constants(Kind kind, const Work& work) const {
  const auto with_kind = [&](auto order) {
    if (kind == Kind::charges) return work(order, KindConstant<Kind::charges>{});
    if constexpr (sizeof(Real) == 8)
      kind == Kind::dipoles ? work(order, KindConstant<Kind::dipoles>{})
                            : work(order, KindConstant<Kind::multipoles>{});
  };
  switch (mesh_.order) {
    case 4:
      return with_kind(OrderConstant<4>{});
    case 5:
      return with_kind(OrderConstant<5>{});
    case 6:
      return with_kind(OrderConstant<6>{});
    case 7:
      return with_kind(OrderConstant<7>{});
    default:
      if constexpr (sizeof(Real) == 4) with_kind(OrderConstant<8>{});
  }
}

// The potential of a dipole is mu.grad of that of a charge, with respect to the source's position. A dipole is
// therefore spread with mu.grad of the weights.
template <class Real>
template <int order, Kind kind>
void ChargeMesh<Real>::spread_source(const Columns<Real>& columns, int s) {
  using R = Row<order, Real>;
  constexpr int lanes_of = row_lanes(order);
  const Rows<order, Real> rows(grid_, columns, s);
  Real* data = grid_.data();
  const std::ptrdiff_t *planes = rows.plane.data(), *in_plane = rows.row.data();
  const auto row = [&](int a, int b) -> R& { return pack_at<R>(&data[planes[a] + in_plane[b]]); };
  if constexpr (kind == Kind::charges) {
    R weight[3];
    polynomials<order>(window_, 2 * lanes_of, rows.from_middle, weight);
    const R z = columns.charge()[s] * weight[2];
#pragma GCC unroll 8
    for (int a = 0; a < order; ++a) {
      const R along_z = weight[0][a] * z;
#pragma GCC unroll 8
      for (int b = 0; b < order; ++b) row(a, b) += weight[1][b] * along_z;
    }
  } else {
    Both<order, Real> both[3];
    polynomials<order>(window_, 2 * lanes_of, rows.from_middle, both);
    R weight[3], slope[3];
    for (int k = 0; k < 3; ++k) {
      weight[k] = low_half(both[k]);
      slope[k] = high_half(both[k]) * (columns.quantity(1 + k)[s] * inverse_spacing_[k]);
    }
    R z = slope[2];
    if constexpr (kind == Kind::multipoles) z += columns.charge()[s] * weight[2];
#pragma GCC unroll 8
    for (int a = 0; a < order; ++a) {
      const R along_z = weight[0][a] * z + slope[0][a] * weight[2];
      const R moved_y = weight[0][a] * weight[2];
#pragma GCC unroll 8
      for (int b = 0; b < order; ++b) row(a, b) += weight[1][b] * along_z + slope[1][b] * moved_y;
    }
  }
}

/// Marks the rows of the mesh on which the sources of a column are spread.
template <class Real>
void ChargeMesh<Real>::use_rows(const Columns<Real>& columns, int column) {
  const auto [nx, ny, nz] = mesh_.points;
  const auto [across, down] = columns.count();
  const auto [x, y] = columns.column(column);
  const auto first = [](int part, int parts, int points) {
    return static_cast<int>(std::int64_t{part} * points / parts);
  };
  const int end_x = first(x + 1, across, nx) + mesh_.order, end_y = first(y + 1, down, ny) + mesh_.order;
  for (int a = first(x, across, nx); a < end_x; ++a)
    for (int b = first(y, down, ny); b < end_y; ++b) grid_.use(a % nx, b % ny);
}

template <class Real>
void ChargeMesh<Real>::spread(const Columns<Real>& columns, Kind kind, parallel::Team& team) {
  grid_.clear(team);
  for (int column = 0; column < columns.count()[0] * columns.count()[1]; ++column)
    if (columns.begin(column) < columns.begin(column + 1)) use_rows(columns, column);
  total_ = kind == Kind::dipoles ? 0 : columns.total_charge();
  with_constants(kind, [&](auto order, auto constant) {
    columns.for_each_tile(team, [&] [[gnu::noinline]] (int first, int end) {
      for (int s = columns.begin(first); s < columns.begin(end); ++s) spread_source<order, constant>(columns, s);
    });
  });
}

template <class Real>
template <int order, Kind kind>
void ChargeMesh<Real>::add_to(const FieldSums<Real>& sums, const Columns<Real>& columns, int s) const {
  using R = Row<order, Real>;
  constexpr int lanes_of = row_lanes(order);
  constexpr bool forces = kind == Kind::multipoles;
  const Rows<order, Real> rows(grid_, columns, s);
  Both<order, Real> both[3];
  polynomials<order>(window_, 2 * lanes_of, rows.from_middle, both);
  R curvature[3];
  if constexpr (forces) polynomials<order - 2>(curvature_, lanes_of, rows.from_middle, curvature);
  const AlongZ<order, Real> line = summed_across<order>(grid_, rows, both, forces ? curvature : nullptr);
  const R weight = low_half(both[2]), slope = high_half(both[2]);
  const Four& inverse_spacing = lanes<4>(inverse_spacing_.data());
  const Four slopes = totals(quarter(weight, line.x), quarter(weight, line.y), quarter(slope, line.potential),
                             quarter(weight, line.potential));
  const Four field = -inverse_spacing * slopes;
  const Four from_middle{rows.from_middle[0], rows.from_middle[1], rows.from_middle[2], 0};
  const auto own = own_part<kind>(columns, s, from_middle);
  lanes<4>(&sums.field[4 * s]) += field + own.field;
  if constexpr (forces) {
    const Four mu = moment_of(columns, s) * inverse_spacing;
    const Four straight =  // Derivatives xx, yy, zz
        totals(quarter(weight, line.xx), quarter(weight, line.yy), quarter(curvature[2], line.potential), Four{});
    const Four across =  // Derivatives yz, zx, xy
        totals(quarter(slope, line.y), quarter(slope, line.x), quarter(weight, line.xy), Four{});
    const auto next = [](const Four& v) { return Four(__builtin_shufflevector(v, v, 1, 2, 0, 3)); };
    const auto last = [](const Four& v) { return Four(__builtin_shufflevector(v, v, 2, 0, 1, 3)); };
    const Four by_spacings =
        columns.charge()[s] * slopes + straight * mu + last(across) * next(mu) + next(across) * last(mu);
    lanes<4>(&sums.force[4 * s]) += own.force - by_spacings * inverse_spacing;
  }
}

/// Returns the correction of field and force for a source's own cloud. With g the potential of a unit charge's cloud at
/// its position, the energy of a charge and its dipole is 1/2 q^2 g + 1/2 q mu.grad g, so the field is half the slope
/// of g. The energy of the dipole with itself is taken as independent of position.
template <class Real>
template <Kind kind>
[[gnu::always_inline]] inline auto ChargeMesh<Real>::own_part(const Columns<Real>& columns, int s,
                                                              const Four& from_middle) const -> Own {
  if (kind == Kind::dipoles) return {self_field_ * moment_of(columns, s), Four{}};
  const Real charge = columns.charge()[s];
  const auto own = self_term_by_series<Real>(from_middle, lanes<4>(wave_[0].data()), lanes<4>(wave_[1].data()),
                                             lanes<4>(inverse_spacing_.data()));
  Four field = own.half_slope * charge;
  field[3] = static_cast<Real>(background_ * total_) -
             charge * (self_ + own.potential[0] + own.potential[1] + own.potential[2]);
  if constexpr (kind == Kind::multipoles) {
    constexpr Real half = 0.5;
    const Four moment = moment_of(columns, s), along = moment * own.half_slope;
    field[3] -= along[0] + along[1] + along[2];
    field += self_field_ * moment;
    return {field, charge * (charge * own.half_slope + half * own.curvature * moment)};
  }
  return {field, Four{}};
}

template <class Real>
void ChargeMesh<Real>::add(const Columns<Real>& columns, Kind kind, const FieldSums<Real>& sums,
                           parallel::Team& team) const {
  constexpr int sources_a_task = 512;
  with_constants(kind, [&](auto order, auto constant) {
    team.for_each((columns.size() + sources_a_task - 1) / sources_a_task, [&] [[gnu::noinline]] (int task) {
      const int first = task * sources_a_task, end = std::min(columns.size(), first + sources_a_task);
      for (int s = first; s < end; ++s) add_to<order, constant>(sums, columns, s);
    });
  });
}

template class ChargeMesh<float>;
template class ChargeMesh<double>;

}  // namespace lichtenberg::periodic
