#pragma once

#include <complex>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace::spheres {

/// Returns the number of real solid harmonics C_lm (real spherical harmonics on the unit sphere) up to a degree. They
/// are normalized such that sum_m C_lm(n)^2 = 1 for a unit vector n (Schmidt); m > 0 goes with cos(m phi), m < 0 with
/// sin(|m| phi). Arrays hold them at l (l + 1) + m.
constexpr int harmonics(int degree) { return (degree + 1) * (degree + 1); }
constexpr int at(int l, int m) { return l * (l + 1) + m; }

/// Computes r^l C_lm at r for all degrees up to `degree`; [harmonics(degree)].
void regular_harmonics(Vec3 r, int degree, double* value);

/// Returns (-1) to the number of axes of `mask` (bits x, y, z) in which C_lm is odd: the factor of C_lm under mirrors
/// across these axes.
inline int mirror_sign(int l, int m, int mask) {
  const bool sine = m < 0, odd = (m & 1) != 0;
  const bool x = sine != odd, y = sine, z = ((l + m) & 1) != 0;
  bool negative = false;
  if (mask & 1) negative = negative != x;
  if (mask & 2) negative = negative != y;
  if (mask & 4) negative = negative != z;
  return negative ? -1 : 1;
}

/// Rotation that takes z to y, (x, y, z) -> (x, -z, y), applied to coefficients: one matrix per degree. Each row
/// involves only every other m, of either the cosines or the sines.
class QuarterTurn {
 public:
  explicit QuarterTurn(int degree);

  /// Coefficients of one row, for m = first_m, first_m + 2, ... up to l; sines are those of -m.
  struct Row {
    bool sine = false;
    int first_m = 0;
    const double* value = nullptr;
  };
  Row row(int l, int m) const {
    const Start& s = start_[at(l, m)];
    return {s.sine, s.first_m, value_.data() + s.begin};
  }
  int degree() const { return degree_; }

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

/// Converts to complex coefficients of C_lm with the Condon-Shortley phase, m from -l to l.
std::vector<std::complex<double>> to_complex(const double* real, int degree);

}  // namespace lichtenberg::laplace::spheres
