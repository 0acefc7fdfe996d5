#pragma once

#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Points, multipole coefficients and fields of the plane as complex numbers.
using Complex = std::complex<double>;

inline Complex to_complex(Vec2 p) { return {p.x, p.y}; }

/// Without the test for infinities that the standard makes std::complex's operator do: it costs more than the product.
inline Complex multiply(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// How a source looks in the mirrors x = 0 and y = 0. The field Re sum_k a_k / (z - c)^k becomes
/// sign Re sum_k a'_k / (z - c')^k; for x -> -x this follows from -conj(z) - c = -conj(z + conj(c)).
struct Image {
  bool across_x = false;  ///< x -> -x
  bool across_y = false;  ///< y -> -y
  double sign = 1;        ///< of the image's charge

  Complex centre(Complex c) const { return {across_x ? -c.real() : c.real(), across_y ? -c.imag() : c.imag()}; }
  bool conjugates() const { return across_x != across_y; }
  /// a'_k, with the sign.
  Complex coefficient(int k, Complex a) const {
    const double s = across_x && k % 2 == 1 ? -sign : sign;
    return {s * a.real(), (conjugates() ? -s : s) * a.imag()};
  }
};

/// The walls of the box as mirrors: an insulating side reflects a charge to one of the same sign, an electrode at
/// potential zero to the opposite one. Reflecting to and fro makes a lattice of images with periods 2 Lx and 2 Ly, on
/// which a shift by one period multiplies the charge by `period_sign`. The unbounded plane has no mirrors.
struct Mirrors {
  explicit Mirrors(const LaplaceProblem& problem) : size(problem.size), bounded(true) {
    for (int s = 0; s < 4; ++s) side_sign[s] = problem.sides[s].kind == Side::Kind::insulating ? 1 : -1;
    const double x = side_sign[left], y = side_sign[bottom];
    images = {{false, false, 1}, {true, false, x}, {false, true, y}, {true, true, x * y}};
  }
  Mirrors() : images({Image{}}) {}

  Vec2 size;                                 ///< of the box
  bool bounded = false;                      ///< false: the plane
  std::array<int, 4> side_sign{1, 1, 1, 1};  ///< by SideIndex: 1 insulating, -1 electrode
  std::vector<Image> images;                 ///< in the period next to the origin, the source itself first

  int period_sign_x() const { return side_sign[left] * side_sign[right]; }
  int period_sign_y() const { return side_sign[bottom] * side_sign[top]; }
  /// False if no wall absorbs flux: then only a source without net charge has a field.
  bool grounded() const { return side_sign != std::array<int, 4>{1, 1, 1, 1}; }
};

}  // namespace lichtenberg::laplace::multipole
