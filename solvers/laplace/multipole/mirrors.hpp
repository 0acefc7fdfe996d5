#pragma once

#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Complex number: a point x + i y of the plane (m), a multipole coefficient or a field.
using Complex = std::complex<double>;

inline constexpr Complex i_unit{0, 1};

/// Converts a point to x + i y.
inline Complex to_complex(Vec2 p) { return {p.x, p.y}; }

/// Returns the product a b. In contrast to the operator of std::complex it does not test for infinities, because the
/// test costs more than the product.
inline Complex multiply(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Mirror image of a source (image charge) in the axes x = 0, y = 0 or both; without reflection, the source itself. A
/// source at c with the potential Re sum_k a_k / (z - c)^k has an image at c' = centre(c) with the potential Re sum_k
/// a'_k / (z - c')^k; coefficient() computes a'_k. For x -> -x this follows from -conj(z) - c = -conj(z + conj(c)).
struct Image {
  bool across_x = false;  ///< True if reflected by x -> -x
  bool across_y = false;  ///< True if reflected by y -> -y
  double sign = 1;        ///< Sign of the image's charge

  /// Returns the position of the image of a source at c.
  Complex centre(Complex c) const { return {across_x ? -c.real() : c.real(), across_y ? -c.imag() : c.imag()}; }
  /// Returns true if the image's coefficients are complex conjugates: a single reflection.
  bool conjugates() const { return across_x != across_y; }
  /// Returns the image's multipole coefficient a'_k, including the sign, for the source's coefficient a = a_k.
  Complex coefficient(int k, Complex a) const {
    const double s = across_x && k % 2 == 1 ? -sign : sign;
    return {s * a.real(), (conjugates() ? -s : s) * a.imag()};
  }
};

/// Method of images for the sides of the box. An insulating side reflects a charge to an image of equal sign, an
/// electrode at potential zero to an image of opposite sign. Repeated reflections make a lattice of images with periods
/// 2 Lx and 2 Ly (Lx, Ly: sides of the box). From one period to the next the image's charge changes by the factor
/// period_sign_x() or period_sign_y(). The unbounded plane has no mirrors.
struct Mirrors {
  /// Makes the mirrors of a problem's box; the default constructor makes the unbounded plane.
  explicit Mirrors(const LaplaceProblem& problem) : size(problem.size), bounded(true) {
    for (int s = 0; s < 4; ++s) side_sign[s] = problem.sides[s].kind == Side::Kind::insulating ? 1 : -1;
    const double x = side_sign[left], y = side_sign[bottom];
    images = {{false, false, 1}, {true, false, x}, {false, true, y}, {true, true, x * y}};
  }
  Mirrors() : images({Image{}}) {}

  Vec2 size;                                 ///< Width and height of the box (m)
  bool bounded = false;                      ///< False for the unbounded plane
  std::array<int, 4> side_sign{1, 1, 1, 1};  ///< By SideIndex: 1 insulating, -1 electrode
  std::vector<Image> images;                 ///< Images in the period next to the origin, the source itself first

  /// Returns the factor (1 or -1) of an image's charge after one period along x.
  int period_sign_x() const { return side_sign[left] * side_sign[right]; }
  /// Returns the factor (1 or -1) of an image's charge after one period along y.
  int period_sign_y() const { return side_sign[bottom] * side_sign[top]; }
  /// Returns true if a side is an electrode. Without electrodes no side absorbs flux, and a bounded field exists only
  /// if the total charge is zero.
  bool grounded() const { return side_sign != std::array<int, 4>{1, 1, 1, 1}; }
};

}  // namespace lichtenberg::laplace::multipole
