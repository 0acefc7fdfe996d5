#pragma once

#include <Eigen/Core>

#include "solvers/laplace/spheres/harmonics.hpp"
#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"

namespace lichtenberg::laplace::spheres {

/// How a field that comes from far away depends on the distance: for a source of degree l and a target of degree t only
/// derivatives of degree l + t of the potential of a charge matter, C_(l+t),m(grad) G / (-1)^(l+t) (2 l + 2 t - 1)!!,
/// which for G = 1/r are C_lm / r^(l+1).
class Coupling {
 public:
  /// For l + t up to the degree.
  explicit Coupling(int degree);

  struct Target {
    int degree;
    double radius;
  };
  /// `mask`: the source is mirrored.
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

  /// local[target] += factor * derivatives[derivative] * multipoles[source], in powers of one length.
  struct Term {
    int target, source, derivative;
    double factor;
  };
  /// For a source of degree l and a target of degree t.
  const std::vector<Term>& terms(int l, int t) const { return terms_[l * (degree_ + 1) + t]; }

 private:
  int degree_;
  std::vector<std::vector<Term>> terms_;  ///< [l * (degree + 1) + t]
};

/// C_lm / r^(l+1) at r, all up to the degree.
void irregular_harmonics(Vec3 r, int degree, double* value);

/// A potential sign * erfc(alpha r) / r, or, `without` 1/r, sign times that less 1/r.
struct Screened {
  double alpha;
  bool without;
  double sign;
};
/// Adds C_nm(grad) of it, as derivatives for Coupling (LatticeSum has the formula). `term`: scratch of
/// harmonics(degree) numbers.
void add_screened(Vec3 r, const Screened& screened, int degree, double* term, double* value);

/// How Ewald's sums are shared between images and waves where images nearer than `range` are not meant. With erfc about
/// exp(-x^2), images at the range have the accuracy, and half a unit more makes up for how many there are. Derivatives
/// of degree n are screened later, Q(n + 1/2, x^2), but of charges that are a third of the range from their centres at
/// most they count (2/3 range / r)^n: at the cut-off .02 to .14 of the accuracy for 1e-3 to 1e-13. Waves, with (2/3
/// range k)^n / (2n - 1)!! exp(-k^2 / 4 alpha^2) at most, are left out from .002 of it on for 1e-3, from 1.5 of it for
/// 1e-11.
struct EwaldSplit {
  double alpha = 0;         ///< 1/length, of the clouds
  double cutoff = 0;        ///< length: farther images are left out
  double largest_wave = 0;  ///< 1/length

  friend bool operator==(const EwaldSplit&, const EwaldSplit&) = default;
};
EwaldSplit ewald_split(double range, double accuracy);

/// The same where no image is left out and charges are within an eighth of the cut-off from their centres: erfc of
/// images at the cut-off and exp(-(k / 2 alpha)^2) of the last wave are the accuracy. The factors that derivatives of
/// degree n add to it, (x^2 / 4)^n / Gamma(n + 1/2) and (x / 2)^n / (2n - 1)!! with x = alpha cutoff, stay below what
/// half a unit more of x takes off.
EwaldSplit ewald_split_of_all(double cutoff, double accuracy);

/// What all images of a unit charge beyond a range make, as derivatives for Coupling: Ewald's sum, in which every term
/// has been differentiated in closed form. With a_n = n + 1/2 and Gamma's regularized incomplete functions P and Q,
///   C_nm(grad) erfc(alpha r)/r = (-1)^n (2n-1)!! C_nm(r) / r^(2n+1) Q(a_n, alpha^2 r^2),
/// and 1/r - erfc(alpha r)/r, what near images that are not meant here have in the waves, the same with P. If the
/// charges of one period do not cancel there is a uniform background.
class LatticeSum {
 public:
  LatticeSum(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split);
  /// Whether it is the sum for these arguments.
  bool fits(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split) const {
    return mirrors_ == mirrors && range_ == range && degree_ == degree && split_ == split;
  }
  int degree() const { return degree_; }

  /// Of images with `mask` of a charge whose mirror image (without shift) is at `from`, at the places given: a column
  /// of harmonics(degree) each.
  Eigen::MatrixXd far_derivatives(int mask, const std::vector<Vec3>& from, const std::vector<Vec3>& at) const;

 private:
  void make_waves();
  void add_near(int mask, Vec3 from, Vec3 place, double* value) const;

  Mirrors mirrors_;
  double range_;
  EwaldSplit split_;
  int degree_;
  std::vector<Vec3> wave_;
  Eigen::MatrixXd even_, odd_;         ///< [harmonics of even or odd degree][wave]
  std::vector<int> even_at_, odd_at_;  ///< their places among all harmonics
};

}  // namespace lichtenberg::laplace::spheres
