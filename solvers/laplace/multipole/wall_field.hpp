#pragma once

#include "solvers/laplace/multipole/lattice.hpp"

namespace lichtenberg::laplace::multipole {

/// The potential in the empty box whose electrode sides have given potentials. Where two of them meet in a corner with
/// a difference D, the potential turns like (2 D / pi) arg(z - corner): an imaginary charge that the mirrors repeat
/// like any other. What the corners leave is linear.
class WallField {
 public:
  WallField(const Mirrors& mirrors, const LatticeSum& lattice, const std::array<Side, 4>& sides);

  /// Taylor coefficients about z of the complex potential, in powers of (distance / radius): V = Re sum value[n] t^n.
  void local(Complex z, double radius, int count, Complex* value) const;
  double potential(Complex z) const;
  /// Charge on the side over the permittivity, V; infinite with the sign of the difference if it meets another
  /// potential in a corner, not a number if it does so in both with different signs.
  double side_flux(SideIndex side) const;
  /// True if two electrodes of different potential meet: then the energy has no bound.
  bool singular() const { return !corners_.empty(); }

 private:
  struct Corner {
    Complex at;
    double strength = 0;      ///< 2 D / pi
    SideIndex before, after;  ///< sides that meet there, counterclockwise about the corner through the box
  };
  void find_corners(const std::array<Side, 4>& sides);
  void find_linear(const std::array<Side, 4>& sides);
  Complex logarithm(Complex z, Complex corner) const;

  const Mirrors* mirrors_;
  const LatticeSum* lattice_;
  std::vector<Corner> corners_;
  double constant_ = 0;
  Complex slope_ = 0;  ///< dV/dx - i dV/dy of the linear part
};

}  // namespace lichtenberg::laplace::multipole
