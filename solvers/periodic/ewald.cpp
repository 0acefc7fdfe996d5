#include "solvers/periodic/ewald.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/periodic/field_sums.hpp"

namespace lichtenberg::periodic {
namespace {

using std::numbers::inv_sqrtpi;
using std::numbers::pi;

/// Returns the translations that may bring a nearest image (each component at most half a side) within the cut-off. The
/// zero translation comes first.
std::vector<Vec3> translations(Vec3 lengths, double cutoff) {
  std::array<int, 3> most;
  for (int k = 0; k < 3; ++k) most[k] = static_cast<int>(cutoff / lengths[k] + 0.5);
  std::vector<Vec3> result = {{}};
  for (int x = -most[0]; x <= most[0]; ++x)
    for (int y = -most[1]; y <= most[1]; ++y)
      for (int z = -most[2]; z <= most[2]; ++z) {
        const Vec3 translation{x * lengths.x, y * lengths.y, z * lengths.z};
        Vec3 least;
        for (int k = 0; k < 3; ++k) least[k] = std::max(0.0, std::abs(translation[k]) - 0.5 * lengths[k]);
        if (norm2(translation) > 0 && norm2(least) <= cutoff * cutoff) result.push_back(translation);
      }
  return result;
}

/// Complex number, such as exp(i k.r).
struct Phase {
  double c = 0, s = 0;

  friend Phase operator*(Phase a, Phase b) { return {a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c}; }
  friend Phase operator*(double a, Phase b) { return {a * b.c, a * b.s}; }
  Phase& operator+=(Phase b) {
    c += b.c;
    s += b.s;
    return *this;
  }
};

/// exp(2 pi i n x / L) of all sources for n = 0 ... most. Each value is computed from its own angle, because powers of
/// the first would accumulate rounding errors.
class Phases {
 public:
  Phases(const Sources& sources, int axis, int most) : sources_(sources.size()), value_((most + 1) * sources_) {
    for (std::size_t j = 0; j < sources_; ++j) {
      const double periods = sources.position[3 * j + axis] / sources.lengths[axis];
      const double fraction = periods - std::nearbyint(periods);
      for (int n = 0; n <= most; ++n) {
        const double cycles = n * fraction - std::nearbyint(n * fraction);
        value_[n * sources_ + j] = {std::cos(2 * pi * cycles), std::sin(2 * pi * cycles)};
      }
    }
  }
  Phase at(int n, std::size_t j) const {
    const Phase phase = value_[std::abs(n) * sources_ + j];
    return {phase.c, n < 0 ? -phase.s : phase.s};
  }

 private:
  std::size_t sources_;
  std::vector<Phase> value_;
};

/// Waves (x, y, first), ..., (x, y, last), and the index at which the first of them is stored.
struct Column {
  int x, y, first, last;
  std::size_t offset;
};

/// Waves within the cut-off, one of each opposite pair, as multiples of `unit`.
struct Waves {
  std::array<int, 3> most{};
  Vec3 unit;  ///< Wave numbers 2 pi / L
  std::vector<Column> columns;
  std::size_t size = 0;

  Vec3 vector(int x, int y, int z) const { return {x * unit.x, y * unit.y, z * unit.z}; }
};

Waves waves_within(Vec3 lengths, double cutoff) {
  Waves waves;
  for (int k = 0; k < 3; ++k) {
    waves.unit[k] = 2 * pi / lengths[k];
    waves.most[k] = static_cast<int>(cutoff / waves.unit[k]);
  }
  for (int x = 0; x <= waves.most[0]; ++x)
    for (int y = x == 0 ? 0 : -waves.most[1]; y <= waves.most[1]; ++y) {
      const double rest = cutoff * cutoff - norm2(waves.vector(x, y, 0));
      if (rest < 0) continue;
      const int last = static_cast<int>(std::sqrt(rest) / waves.unit.z), first = x == 0 && y == 0 ? 1 : -last;
      waves.columns.push_back({x, y, first, last, waves.size});
      waves.size += last - first + 1;
    }
  return waves;
}

/// Data of one evaluation of the sum, shared by its parts.
class Evaluation {
 public:
  Evaluation(const Sources& sources, const Splitting& splitting)
      : sources_(sources),
        splitting_(splitting),
        translations_(translations(sources.lengths, splitting.cutoff)),
        waves_(waves_within(sources.lengths, splitting.wave_cutoff)),
        phases_{Phases(sources, 0, waves_.most[0]), Phases(sources, 1, waves_.most[1]),
                Phases(sources, 2, waves_.most[2])},
        amplitude_(waves_.size) {
    CompensatedSum charge;
    for (const double q : sources.charge) charge += q;
    background_ = -pi * charge.total() / (splitting.alpha * splitting.alpha * sources.volume());
  }

  int columns() const { return static_cast<int>(waves_.columns.size()); }

  /// Computes, for each wave of a column, (8 pi / V) exp(-k^2 / 4 alpha^2) / k^2 times the conjugate of S_k = sum_j
  /// (q_j + i k.mu_j) exp(i k.r_j). The factor is 8 where G 3.19 has 4, since each wave also represents its opposite.
  void sum_sources(int number) {
    const Column& column = waves_.columns[number];
    std::vector<Phase> across(sources_.size());
    for (int j = 0; j < sources_.size(); ++j) across[j] = phases_[0].at(column.x, j) * phases_[1].at(column.y, j);
    for (int z = column.first; z <= column.last; ++z) {
      const Vec3 k = waves_.vector(column.x, column.y, z);
      const double k2 = norm2(k), alpha = splitting_.alpha;
      const double weight = 8 * pi / sources_.volume() * std::exp(-k2 / (4 * alpha * alpha)) / k2;
      const Phase sum = structure_factor(k, z, across);
      amplitude_[column.offset + (z - column.first)] = {weight * sum.c, -weight * sum.s};
    }
  }

  FieldSample field_at(int i) const {
    const Multipole on = multipole(sources_, i);
    CompensatedFieldSample sum;
    add_near(i, on, sum);
    for (const Column& column : waves_.columns) sum += wave_field(column, i, on);
    sum += {background_ - 2 * inv_sqrtpi * splitting_.alpha * on.charge, self_field() * on.dipole};
    return sum.total();
  }

 private:
  /// Field at the centre of a unit dipole's own cloud.
  double self_field() const {
    const double alpha = splitting_.alpha;
    return 4 * alpha * alpha * alpha * inv_sqrtpi / 3;
  }

  Phase structure_factor(Vec3 k, int z, std::span<const Phase> across) const {
    CompensatedSum real, imaginary;
    for (int j = 0; j < sources_.size(); ++j) {
      const Multipole from = multipole(sources_, j);
      const Phase term = Phase{from.charge, dot(k, from.dipole)} * (across[j] * phases_[2].at(z, j));
      real += term.c;
      imaginary += term.s;
    }
    return {real.total(), imaginary.total()};
  }

  void add_near(int i, const Multipole& on, CompensatedFieldSample& sum) const {
    const double cutoff2 = splitting_.cutoff * splitting_.cutoff;
    for (int j = 0; j < sources_.size(); ++j) {
      const Vec3 separation = nearest_image(sources_.position_of(j) - sources_.position_of(i), sources_.lengths);
      const Multipole from = multipole(sources_, j);
      for (std::size_t t = i == j ? 1 : 0; t < translations_.size(); ++t) {
        const Vec3 r = separation + translations_[t];
        const double r2 = norm2(r);
        if (r2 <= cutoff2) sum += pair_field(screened(r2, splitting_.alpha), r, on, from);
      }
    }
  }

  /// Returns the contribution of a column of waves. With a_n the sum over its waves of k_z^n amplitude exp(i k.r), the
  /// potential is Re a_0, the field k Im a, and (mu.grad) field = k (k.mu) Re a.
  FieldSample wave_field(const Column& column, int i, const Multipole& on) const {
    std::array<Phase, 3> a{};
    for (int z = column.first; z <= column.last; ++z) {
      const double kz = z * waves_.unit.z;
      const Phase wave = amplitude_[column.offset + (z - column.first)] * phases_[2].at(z, i);
      a[0] += wave;
      a[1] += kz * wave;
      a[2] += (kz * kz) * wave;
    }
    const Phase across = phases_[0].at(column.x, i) * phases_[1].at(column.y, i);
    for (Phase& sum : a) sum = across * sum;
    const Vec3 k = waves_.vector(column.x, column.y, 0);
    const double along = dot(k, on.dipole), slope = along * a[0].c + on.dipole.z * a[1].c;
    FieldSample result{a[0].c, {k.x * a[0].s, k.y * a[0].s, a[1].s}};
    result.force = on.charge * result.field + Vec3{k.x * slope, k.y * slope, along * a[1].c + on.dipole.z * a[2].c};
    return result;
  }

  const Sources& sources_;
  const Splitting splitting_;
  const std::vector<Vec3> translations_;
  const Waves waves_;
  const std::array<Phases, 3> phases_;
  std::vector<Phase> amplitude_;
  double background_ = 0;
};

/// Solves factor (2 s spread)^derivatives exp(-s^2) = tolerance for s, and returns at least 1.
double decay_length(double factor, double spread, int derivatives, double tolerance) {
  double s = 5;
  for (int sweep = 0; sweep < 20; ++sweep)  // The logarithm changes slowly: each sweep gains about a digit
    s = std::sqrt(std::max(1.0, std::log(factor * std::pow(std::max(1.0, 2 * s * spread), derivatives) / tolerance)));
  return s;
}

}  // namespace

// The costs of both sums balance if the terms of each source cost the same: N (4 pi / 3) (s/alpha)^3 / V in real space
// and half of (4 pi / 3) (2 s alpha)^3 V / (2 pi)^3 waves. A real-space term with erfc costs about as much as `cost`
// waves.
// Neglected magnitudes beyond s, in units of q / d^2: in real space N/V times the integral of 4 pi r^2 (2 alpha /
// (sqrt(pi) r)) exp(-alpha^2 r^2) is 4 sqrt(pi) exp(-s^2) / (alpha d). For waves with |S_k| <= N q, V/(2 pi)^3 times
// the integral of 4 pi k^2 (4 pi N / (V k)) exp(-k^2 / 4 alpha^2) is (4 / pi) N (alpha d)^2 exp(-s^2). Each further
// derivative is a factor of 2 alpha s d in both; the force between dipoles has two.
Splitting splitting_for(const Sources& sources, double tolerance, double alpha) {
  require_consistent(sources);
  if (!(tolerance > 0))
    throw InputError(fmt::format("a tolerance of Ewald's sum is {}: it must be positive", tolerance));
  const double n = std::max(1, sources.size()), shortest = sources.shortest_length(), cost = 8;
  const double cube = shortest * shortest * shortest / sources.volume();
  if (alpha == 0) alpha = std::pow(2 * cost * n * cube * cube, 1.0 / 6) * std::sqrt(pi) / shortest;
  const double spread = alpha * shortest / std::cbrt(n * cube);  // alpha times d
  const int derivatives = sources.dipole.empty() ? 0 : 2;
  const double s = decay_length(4 / (inv_sqrtpi * spread), spread, derivatives, tolerance);
  const double wave_s = decay_length(4 / pi * n * spread * spread, spread, derivatives, tolerance);
  return {alpha, s / alpha, 2 * alpha * wave_s};
}

void Ewald::evaluate(const Sources& sources, std::span<const Pair>, parallel::Team& team, Response& response) {
  evaluate_at(all_of(sources), sources, team, response);
}

void Ewald::evaluate_at(std::span<const int> sample, const Sources& sources, parallel::Team& team,
                        Response& response) const {
  require_consistent(sources);
  Evaluation evaluation(sources, splitting_.alpha > 0 ? splitting_ : splitting_for(sources, tolerance_));
  team.for_each(evaluation.columns(), [&](int c) { evaluation.sum_sources(c); });
  resize(response, static_cast<int>(sample.size()));
  team.for_each(static_cast<int>(sample.size()), [&](int k) { store(k, evaluation.field_at(sample[k]), response); });
  response.energy = energy_of(sources, sample, response);
}

}  // namespace lichtenberg::periodic
