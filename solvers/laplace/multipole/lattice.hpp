#pragma once

#include <vector>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// Periodic Green's function of the plane: lattice sum Lambda(z) = sum_w s_x^n s_y^m ln(z - w) over the lattice vectors
/// w = 2 n Lx + 2 i m Ly. Lx and Ly are the sides of the box, and s_x, s_y = 1 or -1 the factors of a charge's images
/// from period to period (Mirrors).
/// Times -charge / (2 pi eps) it is the complex potential of a charge and its periodic repetitions; derivatives are
/// potentials of multipoles. The implementation adds the vectors near the origin one by one, and a Taylor series about
/// the origin for all others.
/// If both factors are 1, the sum diverges: Lambda is then ln theta_1 (theta function), a sum over rows of the lattice
/// along one coordinate. A term in the square of the other coordinate makes it periodic. This term cancels among the
/// four mirror images or, in a fully insulated box, among the charges (docs/numerics/multipole-plane.md). In the
/// unbounded plane Lambda(z) = ln z.
class LatticeSum {
 public:
  /// Lattice vector, and the sign of the charge there.
  struct Vector {
    int n = 0, m = 0;  ///< Periods along x and y
    Complex shift;     ///< Lattice vector w (m)
    double sign = 1;   ///< s_x^n s_y^m
  };

  /// Computes the Taylor series of the lattice sum for the box of these mirrors.
  explicit LatticeSum(const Mirrors& mirrors);

  /// Returns the lattice vectors near the origin, whose terms are not in the Taylor series; the origin itself is the
  /// first.
  const std::vector<Vector>& near() const { return near_; }
  /// Computes the Taylor part of Lambda (all lattice vectors except near()) and its derivatives at z: value[n] =
  /// d^n/dz^n for n = 0 ... count - 1. Of value[0] only the real part is meaningful. Valid to rounding for |z| up to
  /// half the diagonal of a period.
  void far_derivatives(Complex z, int count, Complex* value) const;
  /// Adds the term that makes Lambda periodic (0 unless s_x = s_y = 1) to the function value[0] and its first
  /// derivative value[1] at z.
  void add_background(Complex z, Complex* value) const;
  /// Computes Re Lambda(z), including the term that makes it periodic, for any z of the plane. If |z| (reduced to one
  /// period) is below `least`, `least` replaces it.
  double real_part(Complex z, double least) const;
  /// Reduces z by whole periods to |Re z| <= Lx and |Im z| <= Ly. Sets `sign` to the sign s_x^n s_y^m of the subtracted
  /// lattice vector. In the unbounded plane z does not change.
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
