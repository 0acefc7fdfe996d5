#pragma once

#include "solvers/laplace/multipole/lattice.hpp"

namespace lichtenberg::laplace::multipole {

/// Potential in the empty box with given potentials of its electrode sides. At a corner where two of them meet with a
/// difference D, the potential varies like (2 D / pi) arg(z - corner). This is an imaginary charge, which the mirrors
/// repeat like any other. The remainder is linear.
class WallField {
 public:
  WallField(const Mirrors& mirrors, const LatticeSum& lattice, const std::array<Side, 4>& sides);

  /// Computes Taylor coefficients of the complex potential about z, in powers of t = distance / radius: V = Re sum
  /// value[n] t^n.
  void local(Complex z, double radius, int count, Complex* value) const;
  double potential(Complex z) const;
  /// Returns the charge on the side over the permittivity (V). It is infinite, with the sign of the difference, if the
  /// side meets another potential in a corner. It is not a number if it does so in both corners with different signs.
  double side_flux(SideIndex side) const;
  /// Returns true if two electrodes of different potential meet: the energy is then infinite.
  bool singular() const { return !corners_.empty(); }

 private:
  struct Corner {
    Complex at;
    double strength = 0;      ///< Strength 2 D / pi
    SideIndex before, after;  ///< Sides that meet at the corner, counterclockwise about it through the box
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
