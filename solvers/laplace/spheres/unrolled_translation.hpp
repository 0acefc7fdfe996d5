#pragma once

#include <type_traits>
#include <utility>

#include "solvers/laplace/spheres/translation.hpp"
#include "solvers/parallel/unroll.hpp"

namespace lichtenberg::laplace::spheres {

/// Calls f with each of the integral constants from 0 to count - 1.
template <int count>
[[gnu::always_inline]] inline void for_each_constant(const auto& f) {
  [&]<int... k>(std::integer_sequence<int, k...>) __attribute__((always_inline)) {
    (f(std::integral_constant<int, k>{}), ...);
  }
  (std::make_integer_sequence<int, count>{});
}

/// Steps of Translation::apply with all loops unrolled for one degree. The degrees of most near pairs are low, and
/// their short loops would take several times as long as their products. Factors are read in the order of use.
template <int degree>
struct UnrolledTranslation {
  static void turn_about_z(const Lanes& cosine, const Lanes& sine, const Lanes* from, Lanes* to) {
    for (int l = 0; l <= degree; ++l) to[at(l, 0)] = from[at(l, 0)];
    Lanes c = cosine, s = sine;
    for_each_constant<degree>([&](auto below) __attribute__((always_inline)) {
      constexpr int m = below + 1;
      LICHTENBERG_UNROLL(16)
      for (int l = m; l <= degree; ++l) {
        const Lanes plus = from[at(l, m)], minus = from[at(l, -m)];
        to[at(l, m)] = c * plus - s * minus;
        to[at(l, -m)] = s * plus + c * minus;
      }
      const Lanes next = c * cosine - s * sine;
      s = s * cosine + c * sine;
      c = next;
    });
  }

  /// `factor`: QuarterTurn::values().
  static void quarter_turn(const double* factor, const Lanes* from, Lanes* to) {
    for_each_constant<harmonics(degree)>([&](auto row) __attribute__((always_inline)) {
      constexpr int l = degree_at(row), m = row - at(l, 0), sign = QuarterTurn::reads_sines(l, m) ? -1 : 1;
      Lanes sum{};
      LICHTENBERG_UNROLL(16)
      for (int k = QuarterTurn::first_column(l, m); k <= l; k += 2) sum += *factor++ * from[at(l, sign * k)];
      to[row] = sum;
    });
  }

  /// `factor`: Translation's factors [m][t from m][s from m] up to the degree.
  static void along_axis(const double* factor, const Lanes* from, Lanes* to) {
    for_each_constant<harmonics(degree)>([&](auto row) __attribute__((always_inline)) {
      constexpr int l = degree_at(row), m = row - at(l, 0);
      if constexpr (m >= 0) {
        const double* row_factor = factor + first_factor(m, l);
        Lanes cosine{}, sine{};
        LICHTENBERG_UNROLL(16)
        for (int s = m; s <= degree; ++s) {
          cosine += row_factor[s - m] * from[at(s, m)];
          if constexpr (m > 0) sine += row_factor[s - m] * from[at(s, -m)];
        }
        to[at(l, m)] = cosine;
        if constexpr (m > 0) to[at(l, -m)] = sine;
      }
    });
  }

  /// Rotates `value` to the frame with z along the displacement, multiplies by the factors along the axis, and rotates
  /// back.
  static void apply(const PairDirections& directions, const double* turn, const double* axis, Lanes* value,
                    Lanes* scratch) {
    turn_about_z(directions.cos_azimuth, -directions.sin_azimuth, value, value);
    quarter_turn(turn, value, scratch);
    turn_about_z(-directions.cos_polar, directions.sin_polar, scratch, scratch);
    quarter_turn(turn, scratch, value);
    along_axis(axis, value, scratch);
    quarter_turn(turn, scratch, value);
    turn_about_z(-directions.cos_polar, -directions.sin_polar, value, value);
    quarter_turn(turn, value, scratch);
    turn_about_z(-directions.cos_azimuth, -directions.sin_azimuth, scratch, value);
  }

 private:
  /// Returns the degree l of the harmonic with index at(l, m).
  static constexpr int degree_at(int index) {
    int l = 0;
    while (harmonics(l) <= index) ++l;
    return l;
  }
  /// Returns the index of the first factor of row (m, t).
  static constexpr int first_factor(int m, int t) {
    int first = 0;
    for (int k = 0; k < m; ++k) first += (degree - k + 1) * (degree - k + 1);
    return first + (t - m) * (degree - m + 1);
  }
};

}  // namespace lichtenberg::laplace::spheres
