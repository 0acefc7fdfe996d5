#pragma once

#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Complex number for points, multipole coefficients and fields of the plane.
using Complex = std::complex<double>;

inline Complex to_complex(Vec2 p) { return {p.x, p.y}; }

/// Product without the test for infinities that the standard requires of std::complex's operator, and that costs more
/// than the product.
inline Complex multiply(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Image of a source in the mirrors x = 0 and y = 0. The field Re sum_k a_k / (z - c)^k becomes sign Re sum_k a'_k / (z
/// - c')^k. For x -> -x this follows from -conj(z) - c = -conj(z + conj(c)).
struct Image {
  bool across_x = false;  ///< True if reflected by x -> -x
  bool across_y = false;  ///< True if reflected by y -> -y
  double sign = 1;        ///< Sign of the image's charge

  Complex centre(Complex c) const { return {across_x ? -c.real() : c.real(), across_y ? -c.imag() : c.imag()}; }
  bool conjugates() const { return across_x != across_y; }
  /// Returns the coefficient a'_k, including the sign.
  Complex coefficient(int k, Complex a) const {
    const double s = across_x && k % 2 == 1 ? -sign : sign;
    return {s * a.real(), (conjugates() ? -s : s) * a.imag()};
  }
};

/// Walls of the box as mirrors: an insulating side reflects a charge to one of equal sign, an electrode at potential
/// zero to the opposite one. Repeated reflections make a lattice of images with periods 2 Lx and 2 Ly, on which a shift
/// by one period multiplies the charge by period_sign_x() or period_sign_y(). The unbounded plane has no mirrors.
struct Mirrors {
  explicit Mirrors(const LaplaceProblem& problem) : size(problem.size), bounded(true) {
    for (int s = 0; s < 4; ++s) side_sign[s] = problem.sides[s].kind == Side::Kind::insulating ? 1 : -1;
    const double x = side_sign[left], y = side_sign[bottom];
    images = {{false, false, 1}, {true, false, x}, {false, true, y}, {true, true, x * y}};
  }
  Mirrors() : images({Image{}}) {}

  Vec2 size;                                 ///< Size of the box
  bool bounded = false;                      ///< False for the unbounded plane
  std::array<int, 4> side_sign{1, 1, 1, 1};  ///< By SideIndex: 1 insulating, -1 electrode
  std::vector<Image> images;                 ///< Images in the period next to the origin, the source itself first

  int period_sign_x() const { return side_sign[left] * side_sign[right]; }
  int period_sign_y() const { return side_sign[bottom] * side_sign[top]; }
  /// Returns false if no wall absorbs flux: a field exists then only without net charge.
  bool grounded() const { return side_sign != std::array<int, 4>{1, 1, 1, 1}; }
};

}  // namespace lichtenberg::laplace::multipole
