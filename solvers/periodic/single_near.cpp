#include "solvers/periodic/single_near.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/lanes.hpp"
#include "solvers/periodic/near.hpp"

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace lichtenberg::periodic {

namespace {

// As many others as the processor has lanes.
#if defined(__AVX512F__)
constexpr int width = 16;
#else
constexpr int width = 8;
#endif
constexpr int lowest_degree = 4, highest_degree = SingleNear::highest_degree;

using Many = Lanes<width, float>;
using Places = Lanes<width, std::int32_t>;

/// 1 / sqrt(x) to the digits of single precision: an estimate and Newton's step.
Many over_root(const Many& x) {
#if defined(__AVX512F__)
  const Many y = reinterpret_cast<Many>(_mm512_rsqrt14_ps(reinterpret_cast<__m512>(x)));
  return y * (1.5f - 0.5f * x * y * y);
#elif defined(__AVX__)
  const Many y = reinterpret_cast<Many>(_mm256_rsqrt_ps(reinterpret_cast<__m256>(x)));
  return y * (1.5f - 0.5f * x * y * y);
#else
  Many y;
  for (int k = 0; k < width; ++k) y[k] = 1 / std::sqrt(x[k]);
  return y;
#endif
}

Many magnitude(const Many& x) { return reinterpret_cast<Many>(reinterpret_cast<Places>(x) & 0x7fffffff); }

/// Those lanes of `x` of which `bits` has the bit, one behind the other; others may follow them.
void store_those(const Many& x, unsigned bits, float* to) {
#if defined(__AVX512F__)
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), reinterpret_cast<__m512>(x)));
#else
  for (int k = 0; k < width; ++k) {
    *to = x[k];
    to += bits >> k & 1;
  }
#endif
}

void store_those(const Places& x, unsigned bits, int* to) {
  store_those(reinterpret_cast<const Many&>(x), bits, reinterpret_cast<float*>(to));
}

/// A bit for each lane below 1.
unsigned below_one(const Many& x) {
#if defined(__AVX512F__)
  return _mm512_cmp_ps_mask(reinterpret_cast<__m512>(x), _mm512_set1_ps(1), _CMP_LT_OQ);
#else
  unsigned bits = 0;
  for (int k = 0; k < width; ++k) bits |= static_cast<unsigned>(x[k] < 1) << k;
  return bits;
#endif
}

using Eight = Lanes<SingleNear::together, float>;
using EightPlaces = Lanes<SingleNear::together, std::int32_t>;

/// 0, 1, 2 ...
template <class Numbers>
Numbers ascending() {
  Numbers numbers;
  for (std::size_t k = 0; k < sizeof(Numbers) / sizeof(numbers[0]); ++k) numbers[k] = static_cast<std::int32_t>(k);
  return numbers;
}
/// The sum over all lanes, four numbers at a time.
Lanes<4, float> quarters_of(const Many& of) {
#if defined(__AVX512F__)
  const Lanes<8, float> half = __builtin_shufflevector(of, of, 0, 1, 2, 3, 4, 5, 6, 7) +
                               __builtin_shufflevector(of, of, 8, 9, 10, 11, 12, 13, 14, 15);
#else
  const Lanes<8, float>& half = of;
#endif
  return __builtin_shufflevector(half, half, 0, 1, 2, 3) + __builtin_shufflevector(half, half, 4, 5, 6, 7);
}

/// Four numbers of each lane, together.
class Interleaved {
 public:
  explicit Interleaved(const Many (&of)[4]) {
#if defined(__AVX512F__)
    const auto low = [](const Many& a, const Many& b) {
      return __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    };
    const auto high = [](const Many& a, const Many& b) {
      return __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    };
    const auto store = [&](int row, const Many& a, const Many& b) {
      lanes<16>(&numbers_[32 * row]) =
          __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
      lanes<16>(&numbers_[32 * row + 16]) =
          __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
    };
    store(0, low(of[0], of[1]), low(of[2], of[3]));
    store(1, high(of[0], of[1]), high(of[2], of[3]));
#else
    for (int lane = 0; lane < width; ++lane)
      for (int k = 0; k < 4; ++k) numbers_[4 * lane + k] = of[k][lane];
#endif
  }
  const Lanes<4, float>& of(int lane) const {
#if defined(__AVX512F__)
    return lanes<4>(&numbers_[16 * (lane % 4) + 4 * (lane / 4)]);
#else
    return lanes<4>(&numbers_[4 * lane]);
#endif
  }

 private:
  alignas(64) float numbers_[4 * width];
};

}  // namespace

/// Charges that follow each other in a column, and the box around them.
struct SingleNear::Cluster {
  int first = 0, size = 0;
  std::array<Turns, 3> centre;
  std::array<float, 3> half;  ///< of the box around them, in cut-offs
};

/// A column that may hold something near another's charges.
struct SingleNear::NearColumn {
  const int* first = nullptr;  ///< Columns::first of its bins
  float reach = 0;             ///< along z, of what is near, in Turns
};

/// What comes behind a cluster in the order of the columns and is near it, gathered some hundred at a time, and what
/// both do to each other.
template <int degree, bool potentials>
class SingleNear::Neighbourhood {
 public:
  Neighbourhood(const SingleNear& near, const Columns& columns, const Cluster& cluster, float* sums)
      : near_(near), columns_(columns), cluster_(cluster), sums_(sums) {
    std::copy_n(near.polynomial_.begin(), degree + 1, polynomial_.begin());
    std::copy_n(near.slope_.begin(), degree, slope_.begin());
    for (int k = 0; k < 3; ++k) {
      const auto* places = reinterpret_cast<const std::int32_t*>(columns.place(k) + cluster.first);
      const EightPlaces apart = lanes<together>(places) - static_cast<std::int32_t>(cluster.centre[k]);
      lanes<together>(at_[k].data()) = near.scale_[k] * __builtin_convertvector(apart, Eight);
    }
    lanes<together>(at_[3].data()) = lanes<together>(columns.charge() + cluster.first);
  }

  void add_all(std::span<const NearColumn> columns) {
    for (const NearColumn& column : columns) add_column(column);
    add_own();
    for (int i = 0; i < cluster_.size; ++i)
      lanes<4>(&sums_[4 * (cluster_.first + i)]) +=
          totals(quarters_of(sum_[i][0]), quarters_of(sum_[i][1]), quarters_of(sum_[i][2]), quarters_of(sum_[i][3]));
  }

 private:
  static constexpr int most = 512;

  /// What of a column is within its reach of the cluster's box along z.
  void add_column(const NearColumn& column) {
    const int bins = columns_.bins();
    const auto steps = static_cast<Turns>(
        static_cast<std::int64_t>(std::min(column.reach + cluster_.half[2] * (1.00001f / near_.scale_[2]), 0x1p31f)));
    const int low = part(cluster_.centre[2] - steps, bins), up = part(cluster_.centre[2] + steps, bins);
    if (low <= up && steps < (Turns{1} << 30)) {
      add(column.first[low], column.first[up + 1]);
    } else if (low <= up) {  // nearly all of it, or all
      add(column.first[0], column.first[bins]);
    } else {
      add(column.first[low], column.first[bins]);
      add(column.first[0], column.first[up + 1]);
    }
  }

  /// Those of some sorted charges that come behind the cluster and are within the cut-off of its box.
  void add(int first, int end) {
    for (int s = std::max(first, cluster_.first + cluster_.size); s < end; s += width) {
      Many apart[3], square{};
      for (int k = 0; k < 3; ++k) {
        const Places places = lanes<width>(reinterpret_cast<const std::int32_t*>(columns_.place(k) + s)) -
                              static_cast<std::int32_t>(cluster_.centre[k]);
        apart[k] = near_.scale_[k] * __builtin_convertvector(places, Many);
        const Many outside = magnitude(apart[k]) - cluster_.half[k];
        const Many beyond = outside > 0 ? outside : Many{};
        square += beyond * beyond;
      }
      const unsigned bits = below_one(square) & ((std::uint64_t{1} << std::min(end - s, width)) - 1);
      for (int k = 0; k < 3; ++k) store_those(apart[k], bits, &near_by_[k][count_]);
      store_those(lanes<width>(columns_.charge() + s), bits, &near_by_[3][count_]);
      store_those(ascending<Places>() + s, bits, &number_[count_]);
      count_ += __builtin_popcount(bits);
      if (count_ > most) act();
    }
  }

  /// What the cluster and that which is gathered do to each other.
  void act() {
    fill_up();
    for (int block = 0; block < count_; block += width) meet<false>(block);
    count_ = 0;
  }

  /// The same of what is gathered still, and of the cluster's charges with each other. Two at one place make the sums
  /// infinite.
  void add_own() {
    const int others = count_, mixed = others / width * width;
    for (int k = 0; k < 4; ++k) lanes<together>(&near_by_[k][others]) = lanes<together>(at_[k].data());
    lanes<together>(&number_[others]) = ascending<EightPlaces>() + cluster_.first;
    count_ += cluster_.size;
    fill_up();
    for (int block = 0; block < mixed; block += width) meet<false>(block);
    for (int block = mixed; block < count_; block += width) meet<true>(block);
  }

  /// The cluster and as many as there are lanes; not twice with its own.
  template <bool may_be_own>
  [[gnu::always_inline]] void meet(int block) {
    const auto of = [&](int k) -> const Many& { return lanes<width>(&near_by_[k][block]); };
    const Many x = of(0), y = of(1), z = of(2), charge = of(3);
    const Places number = lanes<width>(&number_[block]) - cluster_.first;
    Many reaction[4]{};
    for (int i = 0; i < cluster_.size; ++i) {
      const Many along[3] = {at_[0][i] - x, at_[1][i] - y, at_[2][i] - z};
      const Many square = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
      Places within = square < 1;
      if constexpr (may_be_own) within &= number > i;
      const auto [field, potential] = interaction(square, within);
      const Many here = charge * field, there = at_[3][i] * field;
      for (int k = 0; k < 3; ++k) {
        sum_[i][k] += here * along[k];
        reaction[k] -= there * along[k];
      }
      if constexpr (potentials) {
        sum_[i][3] += charge * potential;
        reaction[3] += at_[3][i] * potential;
      }
    }
    const Interleaved on_others(reaction);
    for (int k = 0; k < std::min(width, count_ - block); ++k)
      lanes<4>(&sums_[4 * number_[block + k]]) += on_others.of(k);
  }

  /// With what is beyond the cut-off, behind the last.
  void fill_up() {
    constexpr float far = 8;
    for (int k = 0; k < 4; ++k) lanes<width>(&near_by_[k][count_]) = Many{} + (k < 3 ? far : 0);
  }

  /// 1/r less the cloud's potential, a polynomial in 2 r^2 - 1, and minus its slope over r.
  struct Interaction {
    Many field, potential;
  };
  [[gnu::always_inline]] Interaction interaction(const Many& square, const Places& within) const {
    const Many over = over_root(square), u = 2 * square - 1;
    Many slope = Many{} + slope_[degree - 1];
    for (int k = degree - 2; k >= 0; --k) slope = slope * u + slope_[k];
    const Many field = within ? over * over * over + slope : Many{};
    if constexpr (!potentials) return {field, Many{}};
    Many cloud = Many{} + polynomial_[degree];
    for (int k = degree - 1; k >= 0; --k) cloud = cloud * u + polynomial_[k];
    return {field, within ? over - cloud : Many{}};
  }

  const SingleNear& near_;
  const Columns& columns_;
  const Cluster cluster_;
  float* sums_;
  std::array<float, degree + 1> polynomial_;
  std::array<float, degree> slope_;
  alignas(64) std::array<std::array<float, together>, 4> at_;  ///< the cluster's places, from its centre and in
                                                               ///< cut-offs, and charges
  Many sum_[together][4]{};
  int count_ = 0;
  alignas(64) std::array<std::array<float, most + 3 * width>, 4> near_by_;  ///< the same of what is near
  alignas(64) std::array<int, most + 3 * width> number_;                    ///< of that, as it is sorted
};

SingleNear::SingleNear(Vec3 lengths, const Cloud& cloud)
    : highest_(static_cast<float>(std::min(longest_cutoff(lengths) / cloud.cutoff, 2.0))) {
  for (int k = 0; k < 3; ++k) scale_[k] = static_cast<float>(lengths[k] / cloud.cutoff * 0x1p-32);
  for (const double coefficient : cloud_polynomial(cloud)) {
    if (!polynomial_.empty())
      slope_.push_back(static_cast<float>(4 * cloud.cutoff * coefficient * static_cast<double>(polynomial_.size())));
    polynomial_.push_back(static_cast<float>(cloud.cutoff * coefficient));
  }
  if (polynomial_.size() > highest_degree + 1)
    throw InputError(
        fmt::format("the near part in single precision has polynomials up to degree {}: this cloud needs {}",
                    highest_degree, polynomial_.size() - 1));
}

double SingleNear::longest_cutoff(Vec3 lengths) { return std::min({lengths.x, lengths.y, lengths.z}) / 3; }

/// As many charges from `first` on as are not too far apart along z.
SingleNear::Cluster SingleNear::cluster_from(const Columns& columns, int first, int end) const {
  Cluster cluster{.first = first, .size = std::min(together, end - first)};
  std::array<std::int32_t, 3> low{}, high{};
  const EightPlaces there = ascending<EightPlaces>() < cluster.size;
  for (int k = 0; k < 3; ++k) {
    const auto* places = reinterpret_cast<const std::int32_t*>(columns.place(k)) + first;
    const EightPlaces from_first = there ? lanes<together>(places) - *places : EightPlaces{};
    for (int n = 0; n < together; ++n)
      low[k] = std::min(low[k], from_first[n]), high[k] = std::max(high[k], from_first[n]);
  }
  if (!(scale_[2] * (static_cast<float>(high[2]) - static_cast<float>(low[2])) > highest_))
    return boxed(columns, cluster, low, high);
  low = high = {};
  cluster.size = 0;
  for (; cluster.size < together && first + cluster.size < end; ++cluster.size) {
    auto lower = low, higher = high;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from_first = nearest_image(columns.place(k)[first + cluster.size], columns.place(k)[first]);
      lower[k] = std::min(low[k], from_first), higher[k] = std::max(high[k], from_first);
    }
    if (scale_[2] * (static_cast<float>(higher[2]) - static_cast<float>(lower[2])) > highest_) break;
    low = lower, high = higher;
  }
  return boxed(columns, cluster, low, high);
}

/// With the box that reaches from `low` to `high`, seen from the first.
SingleNear::Cluster SingleNear::boxed(const Columns& columns, Cluster cluster, const std::array<std::int32_t, 3>& low,
                                      const std::array<std::int32_t, 3>& high) const {
  for (int k = 0; k < 3; ++k) {
    const std::int32_t middle = low[k] / 2 + high[k] / 2;
    cluster.centre[k] = columns.place(k)[cluster.first] + static_cast<Turns>(middle);
    cluster.half[k] = scale_[k] * (0.5f * (static_cast<float>(high[k]) - static_cast<float>(low[k])) + 2) * 1.00001f;
  }
  return cluster;
}

/// Of those that come behind the column and of itself.
std::vector<SingleNear::NearColumn> SingleNear::columns_near(const Columns& columns, int column) const {
  const auto [across, down] = columns.count();
  const auto [x, y] = columns.column(column);
  // Columns to either side, or all of them.
  const auto steps = [&](int k, int count) {
    return std::min(count, 2 * static_cast<int>(static_cast<float>(count) / (scale_[k] * 0x1p32f) + 1) + 3);
  };
  const auto gap = [&](int k, int away, int count) {
    const float wide = scale_[k] * 0x1p32f / static_cast<float>(count);
    return static_cast<float>(std::max(0, std::min(std::abs(away), count - std::abs(away)) - 1)) * wide * 0.99999f;
  };
  std::vector<NearColumn> near;
  const int steps_x = steps(0, across), steps_y = steps(1, down);
  for (int a = -(steps_x / 2); a < steps_x - steps_x / 2; ++a) {
    const float dx = gap(0, a, across);
    for (int b = -(steps_y / 2); b < steps_y - steps_y / 2 && dx < 1; ++b) {
      const float dy = gap(1, b, down), left = 1 - dx * dx - dy * dy;
      const int other = columns.number_of((x + a + across) % across, (y + b + down) % down);
      if (left > 0 && other >= column) near.push_back({columns.first(other), std::sqrt(left) * 1.00001f / scale_[2]});
    }
  }
  return near;
}

template <int degree, bool potentials>
[[gnu::noinline]] void SingleNear::compute_column(const Columns& columns, int column, float* sums) const {
  const std::vector<NearColumn> near = columns_near(columns, column);
  const int end = columns.first(column)[columns.bins()];
  for (int s = columns.first(column)[0]; s < end;) {
    const Cluster cluster = cluster_from(columns, s, end);
    Neighbourhood<degree, potentials>(*this, columns, cluster, sums).add_all(near);
    s += cluster.size;
  }
}

template <int degree>
void SingleNear::compute_by_degree(const Columns& columns, bool potentials, float* sums, parallel::Team& team) const {
  if (degree < static_cast<int>(polynomial_.size()) - 1) {
    if constexpr (degree < highest_degree) compute_by_degree<degree + 1>(columns, potentials, sums, team);
    return;
  }
  columns.for_each_apart(team, [&](int first, int end) {
    for (int column = first; column < end; ++column)
      potentials ? compute_column<degree, true>(columns, column, sums)
                 : compute_column<degree, false>(columns, column, sums);
  });
}

void SingleNear::compute(const Columns& columns, bool potentials, std::span<float> sums, parallel::Team& team) const {
  std::ranges::fill(sums, 0.0f);
  compute_by_degree<lowest_degree>(columns, potentials, sums.data(), team);
}

}  // namespace lichtenberg::periodic
