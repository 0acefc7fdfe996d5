#pragma once

#include <complex>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace::spheres {

/// Real solid harmonics C_lm, normalized such that sum_m C_lm(n)^2 = 1 for a unit vector n (Schmidt): m > 0 goes with
/// cos(m phi), m < 0 with sin(|m| phi). They stand in arrays at l (l + 1) + m.
constexpr int harmonics(int degree) { return (degree + 1) * (degree + 1); }
constexpr int at(int l, int m) { return l * (l + 1) + m; }

/// r^l C_lm at r, all up to the degree; [harmonics(degree)].
void regular_harmonics(Vec3 r, int degree, double* value);

/// (-1) to the number of axes of `mask` (bits x, y, z) in which C_lm is odd: what mirrors across these axes do to it.
inline int mirror_sign(int l, int m, int mask) {
  const bool sine = m < 0, odd = (m & 1) != 0;
  const bool x = sine != odd, y = sine, z = ((l + m) & 1) != 0;
  bool negative = false;
  if (mask & 1) negative = negative != x;
  if (mask & 2) negative = negative != y;
  if (mask & 4) negative = negative != z;
  return negative ? -1 : 1;
}

/// What turns z into y, (x, y, z) -> (x, -z, y), does to coefficients: a matrix a degree, of which each row meets only
/// every other m of the cosines or of the sines.
class QuarterTurn {
 public:
  explicit QuarterTurn(int degree);

  /// The coefficients of one row, those of source_m, source_m + 2, ... up to l; the sines are those of -m.
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

/// The same as complex coefficients of C_lm with the phase of Condon and Shortley, m from -l to l.
std::vector<std::complex<double>> to_complex(const double* real, int degree);

}  // namespace lichtenberg::laplace::spheres
