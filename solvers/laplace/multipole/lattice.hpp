#pragma once

#include <vector>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// Lambda(z) = sum over the lattice vectors w = 2 n Lx + 2 i m Ly of s_x^n s_y^m ln(z - w), s being the mirrors' signs
/// of a period: what a charge and its repetitions make, up to the factor -charge / (2 pi eps). A multipole's
/// repetitions follow by differentiation. Split into the vectors near the origin, taken one by one, and the rest, a
/// Taylor series about the origin.
///
/// Where both signs are +, the sum has no limit: Lambda is ln theta_1 with rows along one coordinate. It becomes
/// periodic with a term in the square of the other, which the four mirror images cancel, or in a box that is insulated
/// all round the other charges (README.md). In the plane Lambda(z) = ln z.
class LatticeSum {
 public:
  struct Vector {
    int n = 0, m = 0;  ///< periods along x and y
    Complex shift;     ///< w
    double sign = 1;
  };

  explicit LatticeSum(const Mirrors& mirrors);

  /// Lattice vectors that aren't part of the Taylor series; the origin comes first.
  const std::vector<Vector>& near() const { return near_; }
  /// Derivatives of the rest at z, value[n] = d^n/dz^n; the real part of value[0] alone has a meaning. |z| up to half
  /// the diagonal of a period, where the series has converged to rounding.
  void far_derivatives(Complex z, int count, Complex* value) const;
  /// Adds to value[0] and value[1] those of the term that makes Lambda periodic, to first order about z.
  void add_background(Complex z, Complex* value) const;
  /// Re Lambda(z), made periodic, for any z of the plane; distances below `least` count as that.
  double real_part(Complex z, double least) const;
  /// z without whole periods, |Re z| <= Lx and |Im z| <= Ly, and the sign of the periods taken off.
  Complex reduced(Complex z, double& sign) const;

 private:
  Complex rows_derivative(Complex z) const;
  double constant() const;
  void find_near(double reach);
  double clear_radius(double radius) const;
  void find_taylor(double radius);
  void find_inner_series();

  bool bounded_ = false;
  Vec2 period_;
  int sign_x_ = 1, sign_y_ = 1;
  bool rows_along_y_ = false;
  double background_ = 0;  ///< pi / (area of a period) where both signs are +
  std::vector<Vector> near_;
  std::vector<Complex> taylor_;
  // For real_part: with |z| within half a diagonal, fewer vectors need to be taken one by one.
  std::vector<Vector> inner_;
  std::vector<double> inner_series_;  ///< of z^2: odd powers cancel, and so do imaginary parts
};

}  // namespace lichtenberg::laplace::multipole
