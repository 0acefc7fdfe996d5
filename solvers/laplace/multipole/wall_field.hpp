#pragma once

#include "solvers/laplace/multipole/lattice.hpp"

namespace lichtenberg::laplace::multipole {

/// Field of the walls: potential in the box without bodies, for given potentials of its electrode sides. At a corner
/// where two electrodes meet with a potential difference D, the potential varies like (2 D / pi) arg(z - corner). This
/// is the field of an imaginary charge, which the mirrors repeat like any other charge. The remaining potential is
/// linear.
class WallField {
 public:
  /// Computes the field of the walls for the potentials of the electrodes in `sides`. `mirrors` and `lattice` must
  /// outlive this object.
  WallField(const Mirrors& mirrors, const LatticeSum& lattice, const std::array<Side, 4>& sides);

  /// Computes the Taylor coefficients value[0] ... value[count - 1] (V) of the complex potential about z: V(z + radius
  /// t) = Re sum_n value[n] t^n.
  void local(Complex z, double radius, int count, Complex* value) const;
  /// Computes the potential (V) of the walls' field at the point z = x + i y (m).
  double potential(Complex z) const;
  /// Computes the charge on an electrode side in the box without bodies, over the permittivity (V). It is infinite,
  /// with the sign of the potential difference, if the side meets an electrode of another potential in a corner. It is
  /// NaN if that happens in both corners with opposite signs.
  double side_flux(SideIndex side) const;
  /// Returns true if two electrodes of different potential meet: the energy is then infinite.
  bool singular() const { return !corners_.empty(); }

 private:
  /// Corner in which two electrodes of different potential meet.
  struct Corner {
    Complex at;               ///< Position (m)
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
