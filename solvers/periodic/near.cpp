#include "solvers/periodic/near.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/near_lanes.hpp"

namespace lichtenberg::periodic {

/// Consecutive sources of a column, and the box around them.
template <class Real>
struct Near<Real>::Cluster {
  int first = 0, size = 0;
  std::array<FixedPoint, 3> centre;
  std::array<Real, 3> half;  ///< Half extents of the box, in units of the cut-off
};

/// Column whose sources may be near those of another column.
template <class Real>
struct Near<Real>::NearColumn {
  const int* first = nullptr;  ///< Columns::first of its bins
  Real reach = 0;              ///< Distance along z within which they may be near, as a fixed-point fraction of the box
};

/// Gathers the sources behind a cluster in the order of the columns that are near it, up to some hundred at a time, and
/// computes their interactions with the cluster.
template <class Real>
template <Kind kind, bool potentials>
class Near<Real>::Neighbourhood {
  static constexpr int n = width<Real>;
  using Many = periodic::Many<Real>;
  using Differences = periodic::Differences<Real>;
  /// Components of Columns::quantity that interact.
  static constexpr int first_quantity = kind == Kind::dipoles ? 1 : 0;
  static constexpr int quantities = kind == Kind::charges ? 1 : kind == Kind::dipoles ? 3 : 4;
  static constexpr int rows = 3 + quantities;
  /// Range of the kernels needed.
  static constexpr int first_kernel = kind == Kind::multipoles || (kind == Kind::charges && potentials) ? 0 : 1;
  static constexpr int last_kernel = kind == Kind::charges ? 1 : kind == Kind::dipoles ? 2 : 3;
  /// Number of the cluster's sources that are processed together.
  static constexpr int sources_at_once = kind == Kind::multipoles ? 2 : 4;
  static constexpr int fields = kind == Kind::multipoles ? 8 : 4;  ///< Numbers summed per source: FieldSums
  static constexpr int most = 512;
  static constexpr Real far = 8;  ///< Coordinate of padding sources: beyond the cut-off of every near source

 public:
  Neighbourhood(const Near& near, const Columns<Real>& columns, const FieldSums<Real>& sums)
      : near_(near), columns_(columns), table_(near.table(kind)), sums_(sums) {}

  void compute(const Cluster& cluster, std::span<const NearColumn> columns) {
    begin(cluster);
    for (const NearColumn& column : columns) add_column(column);
    add_own();
    for (int i = 0; i < cluster_.size; ++i)
      for (int f = 0; f < fields; f += 4) {
        const Many* sum = &sum_[i][f];
        lanes<4>(&(f == 0 ? sums_.field : sums_.force)[4 * (cluster_.first + i)]) +=
            totals(quarters_of(sum[0]), quarters_of(sum[1]), quarters_of(sum[2]), quarters_of(sum[3]));
      }
  }

 private:
  void begin(const Cluster& cluster) {
    cluster_ = cluster;
    const EightDifferences<Real> there =
        ascending<EightDifferences<Real>>() < static_cast<Difference<Real>>(cluster.size);
    for (int k = 0; k < 3; ++k) {
      const EightDifferences<Real> separation =
          differences<together, Real>(columns_.coordinate(k) + cluster.first, cluster.centre[k]);
      const Eight<Real> at = near_.scale_[k] * __builtin_convertvector(separation, Eight<Real>);
      lanes<together>(at_[k].data()) = there ? at : Eight<Real>{} - far;
    }
    for (int q = 0; q < quantities; ++q)
      lanes<together>(at_[3 + q].data()) = lanes<together>(columns_.quantity(first_quantity + q) + cluster.first);
    for (auto& sums : sum_)
      for (Many& sum : sums) sum = Many{};
  }

  /// Adds the sources of a column within its reach of the cluster's box along z.
  void add_column(const NearColumn& column) {
    const int bins = columns_.bins();
    const Real reach = column.reach + cluster_.half[2] * (Real(1.00001) / near_.scale_[2]);
    const auto steps = static_cast<FixedPoint>(std::min(reach, whole_box<Real> / 2));
    const int low = part<FixedPoint>(cluster_.centre[2] - steps, bins),
              up = part<FixedPoint>(cluster_.centre[2] + steps, bins);
    if (low <= up && steps < (FixedPoint{1} << (bits_of<Real> - 2))) {
      add(column.first[low], column.first[up + 1]);
    } else if (low <= up) {  // The range covers nearly all of the column, or all of it
      add(column.first[0], column.first[bins]);
    } else {
      add(column.first[low], column.first[bins]);
      add(column.first[0], column.first[up + 1]);
    }
  }

  /// Adds the sorted sources from `first` to `end` that come behind the cluster and lie within the cut-off of its box.
  void add(int first, int end) {
    for (int s = std::max(first, cluster_.first + cluster_.size); s < end; s += n) {
      Many separation[3], square{};
      for (int k = 0; k < 3; ++k) {
        const Differences difference = differences<n, Real>(columns_.coordinate(k) + s, cluster_.centre[k]);
        separation[k] = near_.scale_[k] * __builtin_convertvector(difference, Many);
        const Many outside = magnitude<Real>(separation[k]) - cluster_.half[k];
        const Many beyond = outside > 0 ? outside : Many{};
        square += beyond * beyond;
      }
      const unsigned bits = below_one<Real>(square) & ((std::uint64_t{1} << std::min(end - s, n)) - 1);
      for (int k = 0; k < 3; ++k) store_selected<Real>(separation[k], bits, &near_by_[k][count_]);
      for (int q = 0; q < quantities; ++q)
        store_selected<Real>(lanes<n>(columns_.quantity(first_quantity + q) + s), bits, &near_by_[3 + q][count_]);
      const Differences number = ascending<Differences>() + static_cast<Difference<Real>>(s);
      store_selected<Real>(reinterpret_cast<const Many&>(number), bits, reinterpret_cast<Real*>(&number_[count_]));
      count_ += __builtin_popcount(bits);
      if (count_ > most) compute_interactions();
    }
  }

  /// Computes the interactions of the cluster with the gathered sources.
  void compute_interactions() {
    pad();
    for (int block = 0; block < count_; block += n) interact<false>(block);
    count_ = 0;
  }

  /// Computes the interactions with the remaining gathered sources, and those within the cluster. Two sources at the
  /// same position make the sums infinite.
  void add_own() {
    const int others = count_, mixed = others / n * n;
    for (int k = 0; k < rows; ++k) lanes<together>(&near_by_[k][others]) = lanes<together>(at_[k].data());
    lanes<together>(&number_[others]) =
        ascending<EightDifferences<Real>>() + static_cast<Difference<Real>>(cluster_.first);
    count_ += cluster_.size;
    pad();
    for (int block = 0; block < mixed; block += n) interact<false>(block);
    for (int block = mixed; block < count_; block += n) interact<true>(block);
    count_ = 0;
  }

  /// Computes the interactions of the cluster with one SIMD vector of other sources. Pairs within the cluster are
  /// counted once.
  template <bool may_be_own>
  [[gnu::always_inline]] void interact(int block) {
    Many other[rows], reaction[fields]{};
    for (int k = 0; k < rows; ++k) other[k] = lanes<n>(&near_by_[k][block]);
    const Differences number = lanes<n>(&number_[block]) - static_cast<Difference<Real>>(cluster_.first);
    for (int i = 0; i < cluster_.size; i += sources_at_once) {
      Many r[sources_at_once][3], square[sources_at_once], over[sources_at_once], b[4][sources_at_once];
      for (int m = 0; m < sources_at_once; ++m) {
        for (int k = 0; k < 3; ++k) r[m][k] = at_[k][i + m] - other[k];
        square[m] = r[m][0] * r[m][0] + r[m][1] * r[m][1] + r[m][2] * r[m][2];
        over[m] = inverse_sqrt(square[m]);
      }
      screened<first_kernel, last_kernel>(table_, table_.terms, square, over, b);
      for (int m = 0; m < sources_at_once; ++m) {
        Differences within = square[m] < 1;
        if constexpr (may_be_own) within &= number > static_cast<Difference<Real>>(i + m);
        Many kernel[4];
        for (int k = first_kernel; k <= last_kernel; ++k) kernel[k] = within ? b[k][m] : Many{};
        add_pairs(i + m, r[m], kernel, other + 3, reaction);
      }
    }
    const int count = std::min(n, count_ - block);
    for (int f = 0; f < fields; f += 4)
      add_lanes<Real>(reinterpret_cast<const Many(&)[4]>(reaction[f]), &number_[block], count,
                      (f == 0 ? sums_.field : sums_.force).data());
  }

  /// Adds the interactions of the cluster's i-th source with others; r points from them to it.
  [[gnu::always_inline]] void add_pairs(int i, const Many* r, const Many* b, const Many* other, Many* reaction) {
    Many* sum = sum_[i];
    if constexpr (kind == Kind::charges) {
      const Real charge = at_[3][i];
      const Many here = other[0] * b[1], there = charge * b[1];
      for (int k = 0; k < 3; ++k) {
        sum[k] += here * r[k];
        reaction[k] -= there * r[k];
      }
      if constexpr (potentials) {
        sum[3] += other[0] * b[0];
        reaction[3] += charge * b[0];
      }
    } else {
      const Many* from = other + quantities - 3;
      const auto mine = [&](int k) { return at_[rows - 3 + k][i]; };
      const Many along_other = from[0] * r[0] + from[1] * r[1] + from[2] * r[2];
      const Many along = mine(0) * r[0] + mine(1) * r[1] + mine(2) * r[2];
      Many radial = along_other * b[2], back = along * b[2];
      if constexpr (kind == Kind::multipoles) radial += other[0] * b[1], back -= at_[3][i] * b[1];
      for (int k = 0; k < 3; ++k) {
        sum[k] += radial * r[k] - b[1] * from[k];
        reaction[k] += back * r[k] - b[1] * mine(k);
      }
      if constexpr (kind == Kind::multipoles) {  // The force is (q + mu.grad) of the field
        const Real charge = at_[3][i];
        const Many both = mine(0) * from[0] + mine(1) * from[1] + mine(2) * from[2];
        const Many central = charge * radial - along * (other[0] * b[2] + along_other * b[3]) + both * b[2];
        sum[3] += other[0] * b[0] + along_other * b[1];
        reaction[3] += charge * b[0] - along * b[1];
        for (int k = 0; k < 3; ++k) {
          const Many force = central * r[k] + radial * mine(k) + back * from[k];
          sum[4 + k] += force;
          reaction[4 + k] -= force;
        }
      }
    }
  }

  /// Pads the last block with sources beyond the cut-off; their index does not matter.
  void pad() {
    for (int k = 0; k < rows; ++k) lanes<n>(&near_by_[k][count_]) = Many{} + (k < 3 ? far : Real{});
    lanes<n>(&number_[count_]) = Differences{} + static_cast<Difference<Real>>(cluster_.first);
  }

  const Near& near_;
  const Columns<Real>& columns_;
  const Table table_;
  const FieldSums<Real> sums_;
  Cluster cluster_;
  /// Positions of the cluster's sources relative to its centre, in units of the cut-off, and their quantities.
  alignas(64) std::array<std::array<Real, together>, rows> at_;
  Many sum_[together][fields];
  int count_ = 0;
  /// Positions and quantities of the gathered sources, and their index in the order of the columns.
  alignas(64) std::array<std::array<Real, most + 3 * n>, rows> near_by_;
  alignas(64) std::array<Difference<Real>, most + 3 * n> number_;
};

template <class Real>
Near<Real>::Near(Vec3 lengths, const Cloud& cloud)
    : cutoff_(checked_cutoff(lengths, cloud.cutoff)), widest_(std::min({lengths.x, lengths.y, lengths.z}) / 3) {
  if (cutoff_ > longest_cutoff(lengths))
    throw InputError(fmt::format("a cut-off of {} is more than a third of the box of {} x {} x {}", cutoff_, lengths.x,
                                 lengths.y, lengths.z));
  for (int k = 0; k < 3; ++k) {
    // This bound ensures that each source within the cut-off of a cluster has the same nearest image for all of its
    // sources.
    const double longest = lengths[k] / cutoff_ - 2;
    longest_[k] = static_cast<Real>(k < 2 ? longest : std::min({longest, widest_ / cutoff_, 2.0}));
    scale_[k] = static_cast<Real>(lengths[k] / cutoff_ / whole_box<Real>);
  }
  const auto table_of = [&](std::vector<double> polynomial) {
    if (polynomial.size() > highest_degree + 1)
      throw InputError(
          fmt::format("the near part in single precision has polynomials up to degree {}: this cloud needs {}",
                      highest_degree, polynomial.size() - 1));
    for (double& coefficient : polynomial) coefficient *= cutoff_;
    return Table(polynomial, 2);
  };
  if constexpr (sizeof(Real) == 4) {
    charge_kernels_ = table_of(cloud_polynomial(cloud));
  } else {
    charge_kernels_ = table_of(cloud_polynomial(cloud, Kind::charges));
    dipole_kernels_ = table_of(cloud_polynomial(cloud, Kind::dipoles));
  }
}

template <class Real>
double Near<Real>::longest_cutoff(Vec3 lengths) {
  return std::min({lengths.x, lengths.y, lengths.z}) / (sizeof(Real) == 4 ? 3 : 2);
}

template <class Real>
typename Columns<Real>::Layout Near<Real>::layout(double reach, double volume) const {
  return {.length_unit = cutoff_,
          .together = together,
          .widest = widest_,
          .reach = std::max(cutoff_, reach),
          .volume = volume};
}

template <class Real>
bool Near<Real>::too_long(const std::array<Difference<Real>, 3>& low,
                          const std::array<Difference<Real>, 3>& high) const {
  for (int k = 0; k < 3; ++k)
    if (scale_[k] * (static_cast<Real>(high[k]) - static_cast<Real>(low[k])) > longest_[k]) return true;
  return false;
}

/// Makes a cluster of sources from `first` on, up to `together` of them, as long as its box does not exceed the largest
/// extents.
template <class Real>
typename Near<Real>::Cluster Near<Real>::cluster_from(const Columns<Real>& columns, int first, int end) const {
  Cluster cluster{.first = first, .size = std::min(together, end - first), .centre = {}, .half = {}};
  std::array<Difference<Real>, 3> low{}, high{};
  const auto there = ascending<EightDifferences<Real>>() < static_cast<Difference<Real>>(cluster.size);
  for (int k = 0; k < 3; ++k) {
    const Coordinate<Real>* coordinates = columns.coordinate(k) + first;
    const EightDifferences<Real> from_first =
        there ? differences<together, Real>(coordinates, *coordinates) : EightDifferences<Real>{};
    for (int n = 0; n < together; ++n)
      low[k] = std::min(low[k], from_first[n]), high[k] = std::max(high[k], from_first[n]);
  }
  if (!too_long(low, high)) return boxed(columns, cluster, low, high);
  low = high = {};
  cluster.size = 0;
  for (; cluster.size < together && first + cluster.size < end; ++cluster.size) {
    auto lower = low, higher = high;
    for (int k = 0; k < 3; ++k) {
      const auto from_first =
          static_cast<Difference<Real>>(columns.coordinate(k)[first + cluster.size] - columns.coordinate(k)[first]);
      lower[k] = std::min(low[k], from_first), higher[k] = std::max(high[k], from_first);
    }
    if (too_long(lower, higher)) break;
    low = lower, high = higher;
  }
  return boxed(columns, cluster, low, high);
}

/// Sets centre and half extents of the cluster's box, given `low` and `high` relative to its first source.
template <class Real>
typename Near<Real>::Cluster Near<Real>::boxed(const Columns<Real>& columns, Cluster cluster,
                                               const std::array<Difference<Real>, 3>& low,
                                               const std::array<Difference<Real>, 3>& high) const {
  constexpr Real half = 0.5, more = 1.00001;
  for (int k = 0; k < 3; ++k) {
    const Difference<Real> middle = low[k] / 2 + high[k] / 2;
    cluster.centre[k] = columns.coordinate(k)[cluster.first] + static_cast<FixedPoint>(middle);
    cluster.half[k] = scale_[k] * (half * (static_cast<Real>(high[k]) - static_cast<Real>(low[k])) + 2) * more;
  }
  return cluster;
}

/// Returns the column itself and those behind it that may contain sources near its own.
template <class Real>
std::vector<typename Near<Real>::NearColumn> Near<Real>::columns_near(const Columns<Real>& columns, int column) const {
  constexpr Real more = 1.00001, less = 0.99999;
  const auto [across, down] = columns.count();
  const auto [x, y] = columns.column(column);
  // Number of columns to visit along an axis: those within the cut-off, or all.
  const auto steps = [&](int k, int count) {
    return std::min(count, 2 * static_cast<int>(static_cast<Real>(count) / (scale_[k] * whole_box<Real>)+1) + 3);
  };
  const auto gap = [&](int k, int away, int count) {
    const Real wide = scale_[k] * whole_box<Real> / static_cast<Real>(count);
    return static_cast<Real>(std::max(0, std::min(std::abs(away), count - std::abs(away)) - 1)) * wide * less;
  };
  std::vector<NearColumn> near;
  const int steps_x = steps(0, across), steps_y = steps(1, down);
  for (int a = -(steps_x / 2); a < steps_x - steps_x / 2; ++a) {
    const Real dx = gap(0, a, across);
    for (int b = -(steps_y / 2); b < steps_y - steps_y / 2 && dx < 1; ++b) {
      const Real dy = gap(1, b, down), left = 1 - dx * dx - dy * dy;
      const int other = columns.number_of((x + a + across) % across, (y + b + down) % down);
      const bool occupied = columns.begin(other) < columns.begin(other + 1);
      if (left > 0 && other >= column && occupied)
        near.push_back({columns.first(other), std::sqrt(left) * more / scale_[2]});
    }
  }
  return near;
}

template <class Real>
template <Kind kind, bool potentials>
[[gnu::noinline]] void Near<Real>::compute_column(const Columns<Real>& columns, int column,
                                                  const FieldSums<Real>& sums) const {
  if (columns.begin(column) == columns.begin(column + 1)) return;
  const std::vector<NearColumn> near = columns_near(columns, column);
  Neighbourhood<kind, potentials> neighbourhood(*this, columns, sums);
  const int end = columns.begin(column + 1);
  for (int s = columns.begin(column); s < end;) {
    const Cluster cluster = cluster_from(columns, s, end);
    neighbourhood.compute(cluster, near);
    s += cluster.size;
  }
}

template <class Real>
template <Kind kind, bool potentials>
void Near<Real>::compute_as(const Columns<Real>& columns, const FieldSums<Real>& sums, parallel::Team& team) const {
  columns.for_each_tile(team, [&](int first, int end) {
    for (int column = first; column < end; ++column) compute_column<kind, potentials>(columns, column, sums);
  });
}

template <class Real>
void Near<Real>::compute(const Columns<Real>& columns, Kind kind, bool potentials, const FieldSums<Real>& sums,
                         parallel::Team& team) const {
  std::ranges::fill(sums.field, Real{});
  std::ranges::fill(sums.force, Real{});
  if (kind == Kind::charges)
    return potentials ? compute_as<Kind::charges, true>(columns, sums, team)
                      : compute_as<Kind::charges, false>(columns, sums, team);
  if constexpr (sizeof(Real) == 8)
    kind == Kind::dipoles ? compute_as<Kind::dipoles, false>(columns, sums, team)
                          : compute_as<Kind::multipoles, true>(columns, sums, team);
  else
    throw InputError("there are no dipoles on a mesh in single precision");
}

template class Near<float>;
template class Near<double>;

}  // namespace lichtenberg::periodic
