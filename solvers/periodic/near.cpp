#include "solvers/periodic/near.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/periodic/lanes.hpp"

namespace lichtenberg::periodic {

namespace {

/// Charges.
constexpr int ahead = 8;
constexpr int lowest_degree = 4, highest_degree = 30;

/// Of the smooth part as a series of Chebyshev polynomials of 2 (r / cutoff)^2 - 1, with far more terms than needed.
std::vector<double> chebyshev_series(const Cloud& cloud) {
  constexpr int nodes = 48;
  std::vector<double> series(nodes);
  for (int node = 0; node < nodes; ++node) {
    const double angle = M_PI * (node + 0.5) / nodes;
    const double value = cloud.potential(cloud.cutoff * std::cos(angle / 2));
    for (int n = 0; n < nodes; ++n) series[n] += (n == 0 ? 1.0 : 2.0) / nodes * value * std::cos(n * angle);
  }
  return series;
}

/// The largest change of the force between two charges that a Chebyshev polynomial of degree n makes, times a quarter
/// of the cutoff: the force is 4 r / cutoff^2 times its slope, which is n^2 at most.
double force_of_charges(double n) { return n * n; }

/// The same of the derivatives of that force, which act between dipoles, in units of the charges' potential and its
/// curvature in the middle: a dipole is as two charges so far apart. Second and third derivatives of the polynomial are
/// n^2 (n^2 - 1) / 3 and n^2 (n^2 - 1) (n^2 - 4) / 15 at most, each with 4 r / cutoff^2 more.
double force_of_dipoles(double n, const Cloud& cloud) {
  const double apart = std::sqrt(cloud.potential(0) / (3 * cloud.dipole_field)) / cloud.cutoff;
  const double n2 = n * n, second = 4 * n2 * (n2 - 1) / 3, third = 16 * n2 * (n2 - 1) * (n2 - 4) / 15;
  return std::max({n2, apart * (n2 + second), apart * apart * (3 * second + third)});
}

/// The first degree from which on the terms left out change the force by less than a tenth of the root mean square,
/// over the ball of the cutoff, of what the cloud itself loses.
int sufficient_degree(const std::vector<double>& series, const Cloud& cloud, const auto& force) {
  const double volume = 4 * M_PI / 3 * std::pow(cloud.cutoff, 3);
  const double most = 0.1 * std::sqrt(cloud.lost / volume) * cloud.cutoff / 4;
  int degree = highest_degree;
  for (double left = 0; degree > lowest_degree; --degree) {
    // Terms of rounding alone, of which derivatives would make much, are no better kept than left.
    if (std::abs(series[degree]) > 5e-15 * std::abs(series[0])) left += std::abs(series[degree]) * force(degree);
    if (left > most) break;
  }
  return std::min(highest_degree, (degree + 1) / 2 * 2);
}

/// Integral over the ball of the cutoff of the square of the force that the terms beyond a degree make: with x = 2
/// (r / cutoff)^2 - 1 it is 4 r / cutoff^2 times the sum of a_n n U_(n-1)(x).
double lost_beyond(int degree, const std::vector<double>& series, const Cloud& cloud) {
  constexpr int shells = 200;
  double lost = 0;
  for (int shell = 0; shell < shells; ++shell) {
    const double part = (shell + 0.5) / shells, r = part * cloud.cutoff, x = 2 * part * part - 1;
    double force = 0, before = 0, now = 1;  // U_(n-2), U_(n-1)
    for (int n = 1; n <= highest_degree; ++n) {
      if (n > degree) force += series[n] * n * now;
      before = std::exchange(now, 2 * x * now - before);
    }
    force *= 4 * part / cloud.cutoff;
    lost += 4 * M_PI * r * r * force * force * cloud.cutoff / shells;
  }
  return lost;
}

std::vector<double> powers_of(const std::vector<double>& series, int degree) {
  std::vector<double> powers(degree + 1), before(degree + 1), now(degree + 1);
  before[0] = 1;  // T_0
  now[1] = 1;     // T_1
  for (int n = 0; n <= degree; ++n) {
    for (int k = 0; k <= degree; ++k) powers[k] += series[n] * before[k];
    auto after = before;
    for (int k = 0; k <= degree; ++k) after[k] = (k > 0 ? 2 * now[k - 1] : 0) - before[k];
    before = now;
    now = after;
  }
  return powers;
}

double checked_cutoff(Vec3 lengths, double cutoff) {
  require_consistent({.lengths = lengths});
  for (int k = 0; k < 3; ++k)
    if (2 * cutoff > lengths[k])
      throw InputError(
          fmt::format("a cutoff of {} is more than half of the box's {}: a charge would meet two images of "
                      "one other",
                      cutoff, lengths[k]));
  return cutoff;
}

Box<3> periodic_box(Vec3 lengths) {
  Box<3> box{lengths};
  box.sides.fill(Boundary::periodic);
  return box;
}

}  // namespace

std::vector<double> cloud_polynomial(const Cloud& cloud) {
  const auto series = chebyshev_series(cloud);
  int degree = lowest_degree;
  while (degree < highest_degree && lost_beyond(degree, series, cloud) > 0.09 * cloud.lost) ++degree;
  return powers_of(series, degree);
}

NearPart::NearPart(Vec3 lengths, const Cloud& cloud)
    : cutoff_(checked_cutoff(lengths, cloud.cutoff)), nearest_(periodic_box(lengths)) {
  const auto series = chebyshev_series(cloud);
  of_charges_ = powers_of(series, sufficient_degree(series, cloud, force_of_charges));
  const auto of_dipoles = [&](double n) { return force_of_dipoles(n, cloud); };
  of_dipoles_ = powers_of(series, sufficient_degree(series, cloud, of_dipoles));
}

/// Pairs within the cutoff, some hundred: what they do to each other is computed many at a time.
template <Kind kind>
class NearPart::Batch {
 public:
  Batch(const NearPart& near, const Tiles& tiles, const FeltSums& sums)
      : tiles_(tiles),
        coefficients_(near.coefficients(kind).data()),
        degree_(near.degree(kind)),
        cutoff2_(near.cutoff_ * near.cutoff_),
        sum_(sums.field.data()),
        force_(sums.force.data()) {
    for (int k = 0; k < 3; ++k) length_[k] = near.nearest_.length[k], turns_[k] = near.nearest_.turns_a_metre[k];
  }

  /// Pairs of one first charge, which is sorted to `first`.
  void add(int first, std::span<const Pair> pairs) {
    while (!pairs.empty()) {
      const std::span now = pairs.first(std::min<std::size_t>(pairs.size(), most - count_));
      pairs = pairs.subspan(now.size());
      gather(first, now);
      if (count_ == most) finish();
    }
  }
  /// Until then some have not been added.
  void finish() {
    // What lies behind the last is computed with it, and must be a number.
    for (int c = count_; c < count_ + many; ++c) squared_[c] = cutoff2_;
    compute_by_degree<lowest_degree>();
    for (int c = 0; c < count_;) c = add_run(c);
    count_ = 0;
  }

 private:
  static constexpr int most = 256, many = 8;
  /// B_0, ... of screened.hpp that are needed.
  static constexpr int kernels = kind == Kind::charges ? 2 : kind == Kind::dipoles ? 3 : 4;
  using Four = Lanes<4>;  ///< a vector and one number more
  using Many = Lanes<many>;

  const Four& charge(int s) const { return lanes<4>(tiles_.place_and_charge(s)); }
  const Four& dipole(int s) const { return lanes<4>(tiles_.dipole(s)); }
  static double product(const Four& a, const Four& b) {
    const Four product = a * b;
    return product[0] + product[1] + product[2];
  }

  void gather(int first, std::span<const Pair> pairs) {
    // To round a number below 2^51 to a whole one.
    constexpr double whole = 0x1.8p52;
    // In registers: for all that the compiler knows, what is stored could change what is of this object.
    const Four at = charge(first), length = length_, turns = turns_;
    const double cutoff2 = cutoff2_;
    int count = count_;
    for (const Pair pair : pairs) {  // no branch: which pairs are within reach is hard to guess
      const int second = tiles_.sorted(pair.j);
      __builtin_prefetch(&sum_[4 * second]);
      if constexpr (kind != Kind::charges) __builtin_prefetch(tiles_.dipole(second));
      if constexpr (kind == Kind::multipoles) __builtin_prefetch(&force_[4 * second]);
      Four apart = at - charge(second);
      apart -= length * ((apart * turns + whole) - whole);
      const Four square = apart * apart;
      const double squared = square[0] + square[1] + square[2];
      lanes<4>(&apart_[4 * count]) = apart;
      squared_[count] = squared;
      pair_[count] = {first, second};
      count += squared < cutoff2;
    }
    count_ = count;
  }

  template <int degree>
  void compute_by_degree() {
    if (degree == degree_) return compute<degree>();
    if constexpr (degree < highest_degree) compute_by_degree<degree + 2>();
  }

  template <int degree>
  void compute() {
    std::array<double, degree + 1> coefficients;
    std::copy_n(coefficients_, degree + 1, coefficients.begin());
    const double turn = 2 / cutoff2_;
    for (int c = 0; c < count_; c += many) {
      const Many squared = lanes<many>(&squared_[c]), x = squared * turn - 1;
      Many cloud = Many{} + coefficients[degree], slope{}, second{}, third{};  // those over 2! and 3!
      for (int k = degree - 1; k >= 0; --k) {
        if constexpr (kernels > 3) third = third * x + second;
        if constexpr (kernels > 2) second = second * x + slope;
        slope = slope * x + cloud;
        cloud = cloud * x + coefficients[k];
      }
      const Many over_squared = 1 / squared;
      Many over_distance;
      for (int k = 0; k < many; ++k) over_distance[k] = std::sqrt(over_squared[k]);
      const Many b1 = over_distance * over_squared;
      lanes<many>(&kernel_[1][c]) = over_distance * over_squared + 2 * turn * slope;
      lanes<many>(&kernel_[0][c]) = over_distance - cloud;
      // Each is -2 d/d(r^2) of the one before.
      if constexpr (kernels > 2) lanes<many>(&kernel_[2][c]) = 3 * b1 * over_squared - 8 * turn * turn * second;
      if constexpr (kernels > 3)
        lanes<many>(&kernel_[3][c]) = 15 * b1 * over_squared * over_squared + 48 * turn * turn * turn * third;
    }
  }

  /// Pairs from the c-th on that have one first charge, to both charges; returns where the next begin. One by one:
  /// where a batch ends must not show in the sums.
  int add_run(int c) {
    if constexpr (kind == Kind::charges) return add_charges(c);
    if constexpr (kind == Kind::dipoles) return add_dipoles(c);
    if constexpr (kind == Kind::multipoles) return add_multipoles(c);
  }

  int add_charges(int c) {
    const int i = pair_[c].i;
    const double q = charge(i)[3];
    const Four on_others{-q, -q, -q, q};
    Four on_first = lanes<4>(&sum_[4 * i]);
    for (; c < count_ && pair_[c].i == i; ++c) {
      const int j = pair_[c].j;
      const double field = kernel_[1][c];
      Four unit = lanes<4>(&apart_[4 * c]) * field;
      unit[3] = kernel_[0][c];
      on_first += charge(j)[3] * unit;
      lanes<4>(&sum_[4 * j]) += on_others * unit;
    }
    lanes<4>(&sum_[4 * i]) = on_first;
    return c;
  }

  int add_dipoles(int c) {
    const int i = pair_[c].i;
    const Four first = dipole(i);
    Four on_first = lanes<4>(&sum_[4 * i]);
    for (; c < count_ && pair_[c].i == i; ++c) {
      const int j = pair_[c].j;
      const Four apart = lanes<4>(&apart_[4 * c]), second = dipole(j);
      const double b1 = kernel_[1][c], b2 = kernel_[2][c];
      on_first += b2 * product(second, apart) * apart - b1 * second;
      lanes<4>(&sum_[4 * j]) += b2 * product(first, apart) * apart - b1 * first;
    }
    lanes<4>(&sum_[4 * i]) = on_first;
    return c;
  }

  /// As felt() of screened.hpp, which has the distance the other way round, for both at a time.
  int add_multipoles(int c) {
    const int i = pair_[c].i;
    const double qi = charge(i)[3];
    const Four first = dipole(i);
    Four on_first = lanes<4>(&sum_[4 * i]), force_on_first = lanes<4>(&force_[4 * i]);
    for (; c < count_ && pair_[c].i == i; ++c) {
      const int j = pair_[c].j;
      const Four apart = lanes<4>(&apart_[4 * c]), second = dipole(j);
      const double b0 = kernel_[0][c], b1 = kernel_[1][c], b2 = kernel_[2][c], b3 = kernel_[3][c];
      const double qj = charge(j)[3], along_i = product(first, apart), along_j = product(second, apart);
      const double radial_i = qj * b1 + along_j * b2, radial_j = qi * b1 - along_i * b2;
      Four on_i = radial_i * apart - b1 * second, on_j = -radial_j * apart - b1 * first;
      on_i[3] = qj * b0 + along_j * b1;
      on_j[3] = qi * b0 - along_i * b1;
      const double along = qi * radial_i - along_i * (qj * b2 + along_j * b3) + b2 * product(first, second);
      const Four force = along * apart + radial_i * first - radial_j * second;
      on_first += on_i;
      force_on_first += force;
      lanes<4>(&sum_[4 * j]) += on_j;
      lanes<4>(&force_[4 * j]) -= force;
    }
    lanes<4>(&sum_[4 * i]) = on_first;
    lanes<4>(&force_[4 * i]) = force_on_first;
    return c;
  }

  const Tiles& tiles_;
  const double* coefficients_;
  int degree_;
  double cutoff2_;
  double *sum_, *force_;
  Four length_{}, turns_{};
  int count_ = 0;
  std::array<Pair, most> pair_;  ///< as they are sorted
  alignas(64) std::array<double, most + many> squared_;
  alignas(64) std::array<std::array<double, most + many>, kernels> kernel_;
  alignas(64) std::array<double, 4 * most> apart_;  ///< from j to i
};

/// Where the pairs of each first charge begin.
void NearPart::index(int charges, std::span<const Pair> pairs, parallel::Team& team) {
  constexpr std::ptrdiff_t pairs_a_task = 1 << 16;
  const std::ptrdiff_t count = std::ssize(pairs);
  first_pair_.resize(charges + 1);
  team.for_each(static_cast<int>(count / pairs_a_task + 1), [&](int task) {
    const std::ptrdiff_t first = task * pairs_a_task, end = std::min(count, first + pairs_a_task);
    int i = first == 0 ? 0 : pairs[first - 1].i + 1;
    for (std::ptrdiff_t k = first; k < end; ++k)
      while (i <= pairs[k].i) first_pair_[i++] = k;
    if (end == count) std::fill(first_pair_.begin() + i, first_pair_.end(), count);
  });
}

template <Kind kind>
void NearPart::compute_as(const Tiles& tiles, std::span<const Pair> pairs, const FeltSums& sums, parallel::Team& team) {
  index(tiles.size(), pairs, team);
  std::ranges::fill(sums.field, 0.0);
  std::ranges::fill(sums.force, 0.0);
  tiles.for_each_apart(team, [&](int first, int end) {
    Batch<kind> batch(*this, tiles, sums);
    const auto pairs_of = [&](int s) {
      const int i = tiles.number(s);
      return pairs.subspan(first_pair_[i], first_pair_[i + 1] - first_pair_[i]);
    };
    for (int s = first; s < end; ++s) {
      // They lie anywhere in memory.
      if (s + 2 * ahead < end) __builtin_prefetch(&first_pair_[tiles.number(s + 2 * ahead)]);
      if (s + ahead < end)
        for (const std::span next = pairs_of(s + ahead); const std::size_t line : {0, 8, 16, 24, 32})
          __builtin_prefetch(next.data() + line);
      batch.add(s, pairs_of(s));
    }
    batch.finish();
  });
}

void NearPart::compute(const Tiles& tiles, std::span<const Pair> pairs, Kind kind, const FeltSums& sums,
                       parallel::Team& team) {
  switch (kind) {
    case Kind::charges:
      return compute_as<Kind::charges>(tiles, pairs, sums, team);
    case Kind::dipoles:
      return compute_as<Kind::dipoles>(tiles, pairs, sums, team);
    case Kind::multipoles:
      return compute_as<Kind::multipoles>(tiles, pairs, sums, team);
  }
}

}  // namespace lichtenberg::periodic
