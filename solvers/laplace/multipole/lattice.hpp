#pragma once

#include <vector>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// Lattice sum Lambda(z) = sum over the lattice vectors w = 2 n Lx + 2 i m Ly of s_x^n s_y^m ln(z - w), with s the
/// mirrors' signs of a period. It is the complex potential of a charge and its repetitions, up to the factor -charge /
/// (2 pi eps); those of multipoles follow by differentiation. The sum consists of the vectors near the origin, one by
/// one, and a Taylor series about the origin for the rest.
/// If both signs are +, the sum diverges: Lambda is then ln theta_1 with rows along one coordinate. A term in the
/// square of the other coordinate makes it periodic. This term cancels among the four mirror images or, in a fully
/// insulated box, among the charges (docs/numerics/multipole-plane.md). In the unbounded plane Lambda(z) = ln z.
class LatticeSum {
 public:
  struct Vector {
    int n = 0, m = 0;  ///< Periods along x and y
    Complex shift;     ///< Lattice vector w
    double sign = 1;
  };

  explicit LatticeSum(const Mirrors& mirrors);

  /// Lattice vectors outside the Taylor series; the origin is the first.
  const std::vector<Vector>& near() const { return near_; }
  /// Computes derivatives of the Taylor part at z, value[n] = d^n/dz^n; only the real part of value[0] is meaningful.
  /// Valid for |z| up to half the diagonal of a period, to rounding.
  void far_derivatives(Complex z, int count, Complex* value) const;
  /// Adds the term that makes Lambda periodic to value[0] and value[1], to first order about z.
  void add_background(Complex z, Complex* value) const;
  /// Returns Re Lambda(z), made periodic, for any z of the plane; distances below `least` are replaced by it.
  double real_part(Complex z, double least) const;
  /// Returns z less whole periods, |Re z| <= Lx and |Im z| <= Ly, and sets the sign of the shift.
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
  double background_ = 0;  ///< pi / (area of a period) if both signs are +, otherwise 0
  std::vector<Vector> near_;
  std::vector<Complex> taylor_;
  // The following members serve real_part: for |z| within half a diagonal, fewer vectors need separate terms.
  std::vector<Vector> inner_;
  std::vector<double> inner_series_;  ///< Series in z^2: odd powers and imaginary parts cancel
};

}  // namespace lichtenberg::laplace::multipole
