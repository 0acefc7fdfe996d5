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

// As many numbers as the processor has lanes: those of a cluster's charges, each `beside` times for as many others.
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

constexpr int beside = width / SingleNear::together;
constexpr int rows = width / beside;  ///< of `beside` others make up as many as there are lanes
using Reaction = std::array<Many, rows>;

/// Of vectors with lanes for a cluster's charges, each `beside` times: the sums over its charges, one vector's behind
/// the other's.
[[gnu::always_inline]] inline Many over_charges(const Reaction& of) {
#if defined(__AVX512F__)
  const auto halves = [](const Many& a, const Many& b) {
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
           __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  };
  const auto quarters = [](const Many& a, const Many& b) {
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) +
           __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
  };
  const Many even = quarters(halves(of[0], of[2]), halves(of[4], of[6]));
  const Many odd = quarters(halves(of[1], of[3]), halves(of[5], of[7]));
  return __builtin_shufflevector(even, odd, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29) +
         __builtin_shufflevector(even, odd, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
#else
  Many sum{};
  for (int lane = 0; lane < width; ++lane)
    for (int k = lane % beside; k < width; k += beside) sum[lane] += of[lane / beside][k];
  return sum;
#endif
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
    for (int lane = 0; lane < width; ++lane) {
      const int i = lane / beside, s = cluster.first + std::min(i, cluster.size - 1);
      for (int k = 0; k < 3; ++k)
        at_[k][lane] = near.scale_[k] * static_cast<float>(nearest_image(columns.place(k)[s], cluster.centre[k]));
      charge_[lane] = i < cluster.size ? columns.charge()[s] : 0;
    }
  }

  void add_all(std::span<const NearColumn> columns) {
    for (const NearColumn& column : columns) add_column(column);
    act();
    add_own();
    for (int i = 0; i < cluster_.size; ++i)
      for (int lane = i * beside; lane < (i + 1) * beside; ++lane)
        for (int k = 0; k < 4; ++k) sums_[4 * (cluster_.first + i) + k] += sum_[k][lane];
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
      store_those(ascending() + s, bits, &number_[count_]);
      count_ += __builtin_popcount(bits);
      if (count_ > most) act();
    }
  }

  static Places ascending() {
    Places numbers;
    for (int k = 0; k < width; ++k) numbers[k] = k;
    return numbers;
  }

  /// `beside` numbers, and again.
  static Many repeated(const float* p) {
#if defined(__AVX512F__)
    long long both;
    __builtin_memcpy(&both, p, sizeof(both));
    return reinterpret_cast<Many>(Lanes<width / 2, long long>{} + both);
#else
    return Many{} + *p;
#endif
  }

  /// What the cluster and that which is gathered do to each other.
  void act() {
    fill_up();
    Many sum[4] = {sum_[0], sum_[1], sum_[2], sum_[3]};
    for (int block = 0; block < count_; block += width) {
      Reaction reaction[4];
#pragma GCC unroll 8
      for (int row = 0; row < rows; ++row) {
        const int c = block + row * beside;
        const Apart apart = from(c);
        const auto [field, potential] = interaction(apart.square, apart.square < 1);
        const Many charge = repeated(&near_by_[3][c]), here = charge * field, there = -charge_ * field;
        for (int k = 0; k < 3; ++k) {
          sum[k] += here * apart.along[k];
          reaction[k][row] = there * apart.along[k];
        }
        if constexpr (potentials) {
          sum[3] += charge * potential;
          reaction[3][row] = charge_ * potential;
        }
      }
      react(reaction, block);
    }
    for (int k = 0; k < 4; ++k) sum_[k] = sum[k];
    count_ = 0;
  }

  /// With what is beyond the cut-off, behind the last.
  void fill_up() {
    constexpr float far = 8;
    for (int k = 0; k < 4; ++k) lanes<width>(&near_by_[k][count_]) = Many{} + (k < 3 ? far : 0);
  }

  void react(const Reaction* reaction, int block) {
    const Many sums[4] = {over_charges(reaction[0]), over_charges(reaction[1]), over_charges(reaction[2]),
                          potentials ? over_charges(reaction[3]) : Many{}};
    const Interleaved on_others(sums);
    for (int k = 0; k < std::min(width, count_ - block); ++k)
      lanes<4>(&sums_[4 * number_[block + k]]) += on_others.of(k);
  }

  /// From others to the cluster's charges.
  struct Apart {
    Many square, along[3];
  };
  Apart from(int c) const {
    Apart apart{};
    for (int k = 0; k < 3; ++k) {
      apart.along[k] = at_[k] - repeated(&near_by_[k][c]);
      apart.square += apart.along[k] * apart.along[k];
    }
    return apart;
  }

  /// The cluster's charges with each other, each pair twice. Two at one place make the sums infinite.
  void add_own() {
    for (int j = 0; j < cluster_.size; ++j) {
      for (int k = 0; k < 3; ++k) near_by_[k][j] = at_[k][j * beside];
      near_by_[3][j] = charge_[j * beside];
    }
    count_ = cluster_.size;
    fill_up();
    for (int c = 0; c < cluster_.size; c += beside) {
      const Apart apart = from(c);
      Places other;
      for (int lane = 0; lane < width; ++lane) other[lane] = lane / beside == c + lane % beside ? 0 : -1;
      const auto [field, potential] = interaction(apart.square, other & (apart.square < 1));
      const Many charge = repeated(&near_by_[3][c]);
      for (int k = 0; k < 3; ++k) sum_[k] += charge * field * apart.along[k];
      if constexpr (potentials) sum_[3] += charge * potential;
    }
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
  Many at_[3], charge_;  ///< the cluster's charges, from its centre, in cut-offs
  Many sum_[4]{};
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
  Cluster cluster{.first = first};
  std::array<std::int32_t, 3> low{}, high{};
  for (; cluster.size < together && first + cluster.size < end; ++cluster.size) {
    auto lower = low, higher = high;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from_first = nearest_image(columns.place(k)[first + cluster.size], columns.place(k)[first]);
      lower[k] = std::min(low[k], from_first), higher[k] = std::max(high[k], from_first);
    }
    if (scale_[2] * (static_cast<float>(higher[2]) - static_cast<float>(lower[2])) > highest_) break;
    low = lower, high = higher;
  }
  for (int k = 0; k < 3; ++k) {
    const std::int32_t middle = low[k] / 2 + high[k] / 2;
    cluster.centre[k] = columns.place(k)[first] + static_cast<Turns>(middle);
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
