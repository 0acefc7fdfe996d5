#pragma once

#include <complex>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace::spheres {

/// Returns the number of real solid harmonics C_lm up to the given degree: (degree + 1)^2. On the unit sphere they are
/// real spherical harmonics with Schmidt normalization, sum_m C_lm(n)^2 = 1 for a unit vector n. m > 0 belongs to cos(m
/// phi), m < 0 to sin(|m| phi).
constexpr int harmonics(int degree) { return (degree + 1) * (degree + 1); }
/// Returns the index of C_lm in arrays of harmonics: l (l + 1) + m.
constexpr int at(int l, int m) { return l * (l + 1) + m; }

/// Computes the regular solid harmonics r^l C_lm at the point r, for all degrees up to `degree`: value
/// [harmonics(degree)].
void regular_harmonics(Vec3 r, int degree, double* value);

/// Returns the factor (1 or -1) of C_lm under reflections along the axes of `mask` (bits x, y, z). It is -1 if C_lm is
/// odd in an odd number of these axes.
inline int mirror_sign(int l, int m, int mask) {
  const bool sine = m < 0, odd = (m & 1) != 0;
  const bool x = sine != odd, y = sine, z = ((l + m) & 1) != 0;
  bool negative = false;
  if (mask & 1) negative = negative != x;
  if (mask & 2) negative = negative != y;
  if (mask & 4) negative = negative != z;
  return negative ? -1 : 1;
}

/// Rotation of solid harmonics by 90 degrees about x, (x, y, z) -> (x, -z, y): a matrix for the coefficients of each
/// degree, from Wigner's functions d^l(pi/2). A row of a matrix has nonzero entries for every other m only, for either
/// the cosines (m >= 0) or the sines (m < 0).
class QuarterTurn {
 public:
  /// Computes the rotation matrices for all degrees up to `degree`.
  explicit QuarterTurn(int degree);

  /// Nonzero entries of one row of a rotation matrix, for the columns m = first_m, first_m + 2, ... up to l, or -m if
  /// `sine` is true.
  struct Row {
    bool sine = false;
    int first_m = 0;
    const double* value = nullptr;
  };
  /// Returns the row of the rotation matrix of degree l that gives coefficient m of the rotated harmonics.
  Row row(int l, int m) const {
    const Start& s = start_[at(l, m)];
    return {s.sine, s.first_m, value_.data() + s.begin};
  }
  int degree() const { return degree_; }

  /// Returns Row::sine: true for coefficients that are odd in z, hence odd in y before the rotation.
  static constexpr bool reads_sines(int l, int m) { return ((l + m) & 1) != 0; }
  /// Returns Row::first_m. It is odd if the rotated coefficient is odd in x for cosines, or even in x for sines.
  static constexpr int first_column(int l, int m) {
    const bool sine = reads_sines(l, m), odd_in_x = (m < 0) != ((m & 1) != 0);
    return sine != odd_in_x ? 1 : sine ? 2 : 0;
  }
  /// Returns the values of all rows in the order of at(l, m).
  const double* values() const { return value_.data(); }

 private:
  struct Start {
    bool sine;
    int first_m;
    std::size_t begin;
  };
  int degree_;
  std::vector<Start> start_;
  std::vector<double> value_;
};

/// Converts coefficients of real harmonics to those of complex harmonics with the Condon-Shortley phase, m from -l to
/// l; both in the order of at(l, m).
std::vector<std::complex<double>> to_complex(const double* real, int degree);

}  // namespace lichtenberg::laplace::spheres
