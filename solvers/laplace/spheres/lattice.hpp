#pragma once

#include <Eigen/Core>

#include "solvers/laplace/spheres/harmonics.hpp"
#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"

namespace lichtenberg::laplace::spheres {

/// Translation operator between multipoles and local coefficients of distant sites (M2L), for any potential G of a unit
/// charge. The interaction of a source multipole of degree l with a local coefficient of degree t depends only on
/// derivatives of G of degree l + t. These are D_nm = C_nm(grad) G / ((-1)^n (2n - 1)!!) with n = l + t. For G = 1/r,
/// D_nm = C_nm / r^(n+1).
class Coupling {
 public:
  /// Makes the tables of translation factors for all source degrees l and target degrees t with l + t up to `degree`.
  explicit Coupling(int degree);

  /// Target site: its degree and radius (any unit of length, the same for source and derivatives).
  struct Target {
    int degree;
    double radius;
  };
  /// Source site. `mask`: axes along which the source is mirrored (bits x, y, z); `sign`: sign of the image's charge.
  struct Source {
    int degree;
    double radius;
    int mask;
    double sign;
  };
  /// Adds the field of a source to the local coefficients of a target, up to target.degree. Terms with l + t above the
  /// degree of the tables are left out. `derivatives`: D_nm at the displacement of the two sites. Each term has the
  /// factors sign a_lm source.radius^(l+1) target.radius^t. `T`: double, or Lanes for eight fields at once.
  template <class T>
  void add(const double* derivatives, const Source& source, const T* multipoles, const Target& target, T* local) const;

  /// Term of the translation: local[target] += factor * derivatives[derivative] * multipoles[source], if both sites
  /// have the unit of length as their radius.
  struct Term {
    int target, source, derivative;
    double factor;
  };
  /// Returns the terms for source multipoles of degree l and local coefficients of degree t.
  const std::vector<Term>& terms(int l, int t) const { return terms_[l * (degree_ + 1) + t]; }

 private:
  int degree_;
  std::vector<std::vector<Term>> terms_;  ///< Layout [l * (degree + 1) + t]
};

/// Computes the irregular solid harmonics C_lm / r^(l+1) at the point r, for all degrees up to `degree`: value
/// [harmonics(degree)].
void irregular_harmonics(Vec3 r, int degree, double* value);

/// Screened Coulomb potential of an Ewald sum: sign * erfc(alpha r) / r or, if `without` is true, sign * (erfc(alpha r)
/// - 1) / r, which excludes the charge itself.
struct Screened {
  double alpha;
  bool without;
  double sign;
};
/// Adds the derivatives of the screened potential at r, as D_nm of Coupling, for all degrees up to `degree`: value
/// [harmonics(degree)]. The formula is in LatticeSum. At r = 0 the charge itself is excluded. `term`: scratch memory of
/// the same size.
void add_screened(Vec3 r, const Screened& screened, int degree, double* term, double* value);

/// Ewald splitting: parameters that divide a lattice sum between a real-space sum over images and a sum over waves in
/// reciprocal space.
struct EwaldSplit {
  double alpha = 0;         ///< Inverse width of the Gaussian screening clouds (1/length)
  double cutoff = 0;        ///< Distance (length) beyond which screened images are neglected
  double largest_wave = 0;  ///< Wave number (1/length) beyond which waves are neglected

  friend bool operator==(const EwaldSplit&, const EwaldSplit&) = default;
};
/// Chooses the Ewald splitting of a sum that excludes images nearer than `range`, for a relative error `accuracy`.
/// With x = alpha range and erfc about exp(-x^2), images at the range contribute the accuracy; half a unit more of x
/// compensates for their number. Derivatives of degree n decrease later, as Q(n + 1/2, x^2). But charges are within a
/// third of the range from their centres, so derivatives enter with (2/3 range / r)^n at most. At the cut-off of 1.3
/// range this leaves less than the accuracy.
/// Waves of wave number k and degree n have factors of at most (2/3 range k)^n / (2n - 1)!! exp(-k^2 / 4 alpha^2). The
/// largest wave exceeds the k at which the exponential equals the accuracy by 3 alpha.
EwaldSplit ewald_split(double range, double accuracy);

/// Chooses the Ewald splitting of a sum over all images, for a given cut-off and a relative error `accuracy`. Charges
/// must be within 1/8 of the cut-off from their centres.
/// The accuracy equals exp(-x^2) with x = alpha cutoff, which is about the erfc of images at the cut-off. It also
/// equals exp(-(k / 2 alpha)^2) of the last wave. Derivatives of degree n add factors (x^2 / 4)^n / Gamma(n + 1/2) and
/// (x / 2)^n / (2n - 1)!!. Half a unit more of x compensates for them.
EwaldSplit ewald_split_of_all(double cutoff, double accuracy);

/// Ewald sum for multipoles: the potential of all mirror images of a unit charge beyond a range, as derivatives D_nm
/// for Coupling. Each term of Ewald's sum is differentiated in closed form. A uniform background neutralizes the
/// charges of one period.
/// With a_n = n + 1/2 and Gamma's regularized incomplete functions P and Q: C_nm(grad) erfc(alpha r)/r = (-1)^n
/// (2n-1)!! C_nm(r) / r^(2n+1) Q(a_n, alpha^2 r^2). For near images, which are excluded, the sum over waves contains
/// 1/r - erfc(alpha r)/r; this function has P in place of Q and is subtracted.
class LatticeSum {
 public:
  /// Prepares the Ewald sum over images at distances of at least `range` (0: all images), for derivatives up to
  /// `degree`.
  LatticeSum(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split);
  /// Returns true if this sum was made with these arguments, so that it can be used again.
  bool fits(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split) const {
    return mirrors_ == mirrors && range_ == range && degree_ == degree && split_ == split;
  }
  /// Returns the highest degree of derivatives.
  int degree() const { return degree_; }

  /// Computes the derivatives D_nm (Coupling) of the potential of those images beyond the range that are mirrored along
  /// the axes of `mask`. `from`: positions of the charges, mirrored in this way but not shifted; `at`: target
  /// positions, one per charge. Returns one column [harmonics(degree)] per pair of charge and target.
  Eigen::MatrixXd far_derivatives(int mask, const std::vector<Vec3>& from, const std::vector<Vec3>& at) const;

 private:
  void make_waves();
  void add_near(int mask, Vec3 from, Vec3 position, double* value) const;

  Mirrors mirrors_;
  double range_;
  EwaldSplit split_;
  int degree_;
  std::vector<Vec3> wave_;
  Eigen::MatrixXd even_, odd_;         ///< Layout [harmonics of even or odd degree][wave]
  std::vector<int> even_at_, odd_at_;  ///< Indices among all harmonics
};

}  // namespace lichtenberg::laplace::spheres
