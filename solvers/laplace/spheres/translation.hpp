#pragma once

#include <type_traits>
#include <vector>

#include "solvers/lanes.hpp"
#include "solvers/laplace/spheres/harmonics.hpp"

namespace lichtenberg::laplace::spheres {

/// Number of pairs that are processed at once by SIMD.
constexpr int lanes = 8;
typedef double OneRegister __attribute__((vector_size(lanes * sizeof(double))));
/// SIMD vector: one number for each of eight pairs (or of eight fields).
using Lanes = std::conditional_t<simd::bytes_wide == sizeof(OneRegister), OneRegister, simd::Twin<lanes, double>>;

/// Directions from source to target of eight pairs, as cosines and sines of azimuth and polar angle.
struct PairDirections {
  Lanes cos_azimuth{}, sin_azimuth{}, cos_polar{}, sin_polar{};

  /// Sets the direction of one pair from its displacement (any length above 0).
  void set(int lane, Vec3 displacement);
};

/// Translation operators of solid harmonics between two centres, for eight pairs at once: multipoles to local
/// coefficients (M2L), and shifts of either (M2M, L2L). The displacement is rotated to the z axis, where only equal m
/// interact, and back (rotation method). About 2 p^3 products per pair for degree p.
class Translation {
 public:
  /// Makes the tables for degrees up to `degree`.
  explicit Translation(int degree);
  int degree() const { return turn_.degree(); }

  /// Translates multipoles a_lm of a source of radius R_s to local coefficients b_lm at a target of radius R_t at a
  /// distance d. On entry `value` contains a_lm (2 R_s/d)^l R_s/d up to the source degree, on return b_lm (2 R_t/d)^-l
  /// up to the target degree. `value` and `scratch` have harmonics(larger degree) elements; both are overwritten. Up to
  /// degree 8 all loops are unrolled.
  void apply(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
             Lanes* scratch) const;

  /// Multiplies coefficients by matrices factor[m][t][t'] that act in the frame with z along the displacement: rotates
  /// `value` (up to `degree`) to this frame, multiplies, and rotates back. `scratch` is overwritten.
  void in_pair_frame(const PairDirections& directions, int degree, const double* factor, Lanes* value,
                     Lanes* scratch) const;

  /// Shift of the centre of an expansion by `length`, from coefficients up to `degree` to coefficients up to
  /// `new_degree`. `outward` is true for multipoles: the coefficient of degree l contributes to degrees t >= l with
  /// length^(t - l). It is false for local coefficients: contributions to t <= l with length^(l - t).
  struct Shift {
    const Lanes& length;
    bool outward;
    int degree, new_degree;
  };
  /// Shifts the centre of multipoles or local coefficients `value`. `directions`: from the new to the old centre for
  /// multipoles, from the old to the new centre for local coefficients. Coefficients are those of unscaled solid
  /// harmonics: moments of r^l C_lm, potentials sum b_lm r^l C_lm. `scratch` is overwritten.
  void shift(const PairDirections& directions, const Shift& shift, Lanes* value, Lanes* scratch) const;

 private:
  template <class AlongAxis>
  void in_axis_frame(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
                     Lanes* scratch, AlongAxis along) const;
  void shift_along_axis(const Shift& shift, const Lanes* from, Lanes* to) const;
  void turn_about_z(const Lanes& cosine, const Lanes& sine, int degree, Lanes* value) const;
  void quarter_turn(int degree, const Lanes* from, Lanes* to) const;
  void along_axis(int source_degree, int target_degree, const Lanes* from, Lanes* to) const;
  template <int degree>
  void apply_unrolled(const PairDirections& directions, Lanes* value, Lanes* scratch) const;
  double factor(int m, int t, int s) const { return axis_[(static_cast<std::size_t>(m) * side_ + t) * side_ + s]; }

  QuarterTurn turn_;
  int side_;
  std::vector<double> axis_;                   ///< Layout [m][l target][l source]
  std::vector<double> shift_;                  ///< Layout [m][l higher][l lower]
  std::vector<std::vector<double>> unrolled_;  ///< Factors of axis_ for UnrolledTranslation of each degree
};

}  // namespace lichtenberg::laplace::spheres
