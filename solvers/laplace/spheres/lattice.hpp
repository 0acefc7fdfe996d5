#pragma once

#include <Eigen/Core>

#include "solvers/laplace/spheres/harmonics.hpp"
#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"

namespace lichtenberg::laplace::spheres {

/// Dependence of far fields on the displacement. For a source of degree l and a target of degree t only derivatives of
/// degree l + t of a charge's potential G matter: C_(l+t),m(grad) G / (-1)^(l+t) (2 l + 2 t - 1)!!. For G = 1/r these
/// are C_lm / r^(l+1).
class Coupling {
 public:
  /// Makes tables for l + t up to the degree.
  explicit Coupling(int degree);

  struct Target {
    int degree;
    double radius;
  };
  /// Source site. `mask`: axes along which the source is mirrored.
  struct Source {
    int degree;
    double radius;
    int mask;
    double sign;
  };
  /// Adds sign * sum over l, m of a_lm source.radius^(l+1) target.radius^t * derivatives, for t up to target.degree.
  /// `T`: double, or Lanes for eight fields at once.
  template <class T>
  void add(const double* derivatives, const Source& source, const T* multipoles, const Target& target, T* local) const;

  /// Term local[target] += factor * derivatives[derivative] * multipoles[source], in powers of one length.
  struct Term {
    int target, source, derivative;
    double factor;
  };
  /// Returns the terms for a source of degree l and a target of degree t.
  const std::vector<Term>& terms(int l, int t) const { return terms_[l * (degree_ + 1) + t]; }

 private:
  int degree_;
  std::vector<std::vector<Term>> terms_;  ///< Layout [l * (degree + 1) + t]
};

/// Computes C_lm / r^(l+1) at r, for all degrees up to `degree`.
void irregular_harmonics(Vec3 r, int degree, double* value);

/// Screened potential sign * erfc(alpha r) / r or, if `without` is true, sign times that less 1/r.
struct Screened {
  double alpha;
  bool without;
  double sign;
};
/// Adds C_nm(grad) of the screened potential, as derivatives for Coupling (formula: LatticeSum). `term`: scratch of
/// harmonics(degree) numbers.
void add_screened(Vec3 r, const Screened& screened, int degree, double* term, double* value);

/// Splitting of Ewald's sums between images and waves if images nearer than `range` are excluded. With erfc about
/// exp(-x^2), images at the range contribute the accuracy; half a unit more of x compensates for their number.
/// Derivatives of degree n decrease later, as Q(n + 1/2, x^2). But charges lie within a third of the range from their
/// centres, so they enter with (2/3 range / r)^n at most. At the cut-off this leaves 0.02 to 0.14 of the accuracy for
/// 1e-3 to 1e-13. Waves contribute at most (2/3 range k)^n / (2n - 1)!! exp(-k^2 / 4 alpha^2). The neglected waves
/// begin at 0.002 of the accuracy for 1e-3, and at 1.5 of it for 1e-11.
struct EwaldSplit {
  double alpha = 0;         ///< Screening parameter of the clouds (1/length)
  double cutoff = 0;        ///< Distance (length) beyond which images are neglected
  double largest_wave = 0;  ///< Wave number (1/length) beyond which waves are neglected

  friend bool operator==(const EwaldSplit&, const EwaldSplit&) = default;
};
EwaldSplit ewald_split(double range, double accuracy);

/// Returns the splitting if no image is excluded and charges are within 1/8 of the cut-off from their centres. With x =
/// alpha cutoff, erfc of images at the cut-off and exp(-(k / 2 alpha)^2) of the last wave equal the accuracy.
/// Derivatives of degree n add factors (x^2 / 4)^n / Gamma(n + 1/2) and (x / 2)^n / (2n - 1)!!. Half a unit more of x
/// compensates for them.
EwaldSplit ewald_split_of_all(double cutoff, double accuracy);

/// Field of all images of a unit charge beyond a range, as derivatives for Coupling: Ewald's sum with each term
/// differentiated in closed form. With a_n = n + 1/2 and Gamma's regularized incomplete functions P and Q, C_nm(grad)
/// erfc(alpha r)/r = (-1)^n (2n-1)!! C_nm(r) / r^(2n+1) Q(a_n, alpha^2 r^2). The function of excluded near images in
/// the waves, 1/r - erfc(alpha r)/r, has P in place of Q. A uniform background neutralizes the charges of one period.
class LatticeSum {
 public:
  LatticeSum(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split);
  /// Returns true if the sum has these arguments.
  bool fits(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split) const {
    return mirrors_ == mirrors && range_ == range && degree_ == degree && split_ == split;
  }
  int degree() const { return degree_; }

  /// Computes the derivatives of images with `mask`; `from`: mirror images (without shift) of the charges, `at`: target
  /// positions. Returns one column of harmonics(degree) per pair.
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
