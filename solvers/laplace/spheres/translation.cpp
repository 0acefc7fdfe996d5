#include "solvers/laplace/spheres/translation.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/spheres/unrolled_translation.hpp"

namespace lichtenberg::laplace::spheres {

void PairDirections::set(int lane, Vec3 displacement) {
  const double across = std::sqrt(displacement.x * displacement.x + displacement.y * displacement.y),
               d = norm(displacement);
  cos_polar[lane] = displacement.z / d;
  sin_polar[lane] = across / d;
  cos_azimuth[lane] = across > 0 ? displacement.x / across : 1;
  sin_azimuth[lane] = across > 0 ? displacement.y / across : 0;
}

namespace {

/// Returns the square roots of C(n, k) / 2^n.
std::vector<std::vector<double>> root_binomials(int most) {
  std::vector<std::vector<double>> row(most + 1);
  row[0] = {1};
  for (int n = 1; n <= most; ++n) {
    row[n].assign(n + 1, 0);
    for (int k = 0; k <= n; ++k) row[n][k] = 0.5 * ((k > 0 ? row[n - 1][k - 1] : 0) + (k < n ? row[n - 1][k] : 0));
  }
  for (auto& values : row)
    for (double& value : values) value = std::sqrt(value);
  return row;
}

constexpr int most_unrolled = 8;  ///< Compilation time and size grow with the cube of this degree

}  // namespace

Translation::Translation(int degree) : turn_(degree), side_(degree + 1) {
  const auto root = root_binomials(2 * degree);
  axis_.resize(static_cast<std::size_t>(side_) * side_ * side_);
  for (int m = 0; m <= degree; ++m)
    for (int t = m; t <= degree; ++t)
      for (int s = m; s <= degree; ++s)
        // The sign is (-1)^(t + m); the two rotations from and to z omit a rotation by pi about it, which is (-1)^m.
        axis_[(static_cast<std::size_t>(m) * side_ + t) * side_ + s] =
            (t & 1 ? -1 : 1) * root[s + t][s + m] * root[s + t][s - m];
  // Shift of r^t C_tm by d along z: sum_l sqrt(C(t+m, l+m) C(t-m, l-m)) d^(t-l) r^l C_lm, with the same (-1)^m.
  shift_.resize(axis_.size());
  for (int m = 0; m <= degree; ++m)
    for (int t = m; t <= degree; ++t)
      for (int s = m; s <= t; ++s)
        shift_[(static_cast<std::size_t>(m) * side_ + t) * side_ + s] =
            (m & 1 ? -1 : 1) * std::exp2(t) * root[t + m][s + m] * root[t - m][s - m];
  for (int p = 0; p <= std::min(degree, most_unrolled); ++p) {
    unrolled_.emplace_back();
    for (int m = 0; m <= p; ++m)
      for (int t = m; t <= p; ++t)
        for (int s = m; s <= p; ++s) unrolled_[p].push_back(factor(m, t, s));
  }
}

void Translation::turn_about_z(const Lanes& cosine, const Lanes& sine, int degree, Lanes* value) const {
  Lanes c = cosine, s = sine;
  for (int m = 1; m <= degree; ++m) {
    for (int l = m; l <= degree; ++l) {
      Lanes &plus = value[at(l, m)], &minus = value[at(l, -m)];
      const Lanes turned = c * plus - s * minus;
      minus = s * plus + c * minus;
      plus = turned;
    }
    const Lanes next = c * cosine - s * sine;
    s = s * cosine + c * sine;
    c = next;
  }
}

void Translation::quarter_turn(int degree, const Lanes* from, Lanes* to) const {
  for (int l = 0; l <= degree; ++l)
    for (int m = -l; m <= l; ++m) {
      const QuarterTurn::Row row = turn_.row(l, m);
      const Lanes* middle = from + at(l, 0);
      Lanes sum{};
      const double* value = row.value;
      if (row.sine)
        for (int k = row.first_m; k <= l; k += 2) sum += *value++ * middle[-k];
      else
        for (int k = row.first_m; k <= l; k += 2) sum += *value++ * middle[k];
      to[at(l, m)] = sum;
    }
}

void Translation::along_axis(int source_degree, int target_degree, const Lanes* from, Lanes* to) const {
  const int both = std::min(source_degree, target_degree);
  for (int m = 0; m <= both; ++m)
    for (int t = m; t <= target_degree; ++t) {
      const double* factor = axis_.data() + (static_cast<std::size_t>(m) * side_ + t) * side_;
      Lanes cosine{}, sine{};
      for (int s = m; s <= source_degree; ++s) cosine += factor[s] * from[at(s, m)];
      to[at(t, m)] = cosine;
      if (m == 0) continue;
      for (int s = m; s <= source_degree; ++s) sine += factor[s] * from[at(s, -m)];
      to[at(t, -m)] = sine;
    }
  for (int t = both + 1; t <= target_degree; ++t)
    for (int m = both + 1; m <= t; ++m) to[at(t, m)] = to[at(t, -m)] = Lanes{};
}

void Translation::shift_along_axis(const Shift& shift, const Lanes* from, Lanes* to) const {
  const auto [length, outward, degree, new_degree] = shift;
  std::vector<Lanes> power(std::max(degree, new_degree) + 1, Lanes{} + 1);
  for (std::size_t k = 1; k < power.size(); ++k) power[k] = power[k - 1] * length;
  for (int t = 0; t <= new_degree; ++t)
    for (int m = 0; m <= t; ++m) {
      Lanes cosine{}, sine{};
      const int low = outward ? m : t, high = outward ? std::min(t, degree) : degree;
      for (int l = low; l <= high; ++l) {
        const int higher = outward ? t : l, lower = outward ? l : t;
        const Lanes factor =
            shift_[(static_cast<std::size_t>(m) * side_ + higher) * side_ + lower] * power[higher - lower];
        cosine += factor * from[at(l, m)];
        if (m > 0) sine += factor * from[at(l, -m)];
      }
      to[at(t, m)] = cosine;
      if (m > 0) to[at(t, -m)] = sine;
    }
}

template <class AlongAxis>
void Translation::in_axis_frame(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
                                Lanes* scratch, AlongAxis along) const {
  turn_about_z(directions.cos_azimuth, -directions.sin_azimuth, source_degree, value);
  quarter_turn(source_degree, value, scratch);
  turn_about_z(-directions.cos_polar, directions.sin_polar, source_degree, scratch);
  quarter_turn(source_degree, scratch, value);
  along(value, scratch);
  quarter_turn(target_degree, scratch, value);
  turn_about_z(-directions.cos_polar, -directions.sin_polar, target_degree, value);
  quarter_turn(target_degree, value, scratch);
  turn_about_z(-directions.cos_azimuth, -directions.sin_azimuth, target_degree, scratch);
  std::copy(scratch, scratch + harmonics(target_degree), value);
}

template <int degree>
void Translation::apply_unrolled(const PairDirections& directions, Lanes* value, Lanes* scratch) const {
  UnrolledTranslation<degree>::apply(directions, turn_.values(), unrolled_[degree].data(), value, scratch);
}

void Translation::apply(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
                        Lanes* scratch) const {
  const int larger = std::max(source_degree, target_degree);
  if (larger <= most_unrolled) {
    std::fill(value + harmonics(source_degree), value + harmonics(larger), Lanes{});
    for_each_constant<most_unrolled + 1>([&](auto degree) {
      if (degree == larger) apply_unrolled<degree>(directions, value, scratch);
    });
    return;
  }
  in_axis_frame(directions, source_degree, target_degree, value, scratch,
                [&](const Lanes* from, Lanes* to) { along_axis(source_degree, target_degree, from, to); });
}

void Translation::in_pair_frame(const PairDirections& directions, int degree, const double* factor, Lanes* value,
                                Lanes* scratch) const {
  const int side = degree + 1;
  const auto multiply = [&](const Lanes* from, Lanes* to) {
    for (int m = 0; m <= degree; ++m)
      for (int t = m; t <= degree; ++t) {
        const double* row = factor + (static_cast<std::size_t>(m) * side + t) * side;
        Lanes cosine{}, sine{};
        for (int s = m; s <= degree; ++s) cosine += row[s] * from[at(s, m)], sine += row[s] * from[at(s, -m)];
        const double half_turn = m & 1 ? -1 : 1;  // As in the constructor
        to[at(t, m)] = half_turn * cosine;
        if (m > 0) to[at(t, -m)] = half_turn * sine;
      }
  };
  in_axis_frame(directions, degree, degree, value, scratch, multiply);
}

void Translation::shift(const PairDirections& directions, const Shift& shift, Lanes* value, Lanes* scratch) const {
  in_axis_frame(directions, shift.degree, shift.new_degree, value, scratch,
                [&](const Lanes* from, Lanes* to) { shift_along_axis(shift, from, to); });
}

}  // namespace lichtenberg::laplace::spheres
