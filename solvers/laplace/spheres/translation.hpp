#pragma once

#include <vector>

#include "solvers/laplace/spheres/harmonics.hpp"

namespace lichtenberg::laplace::spheres {

constexpr int lanes = 8;
/// One number for each of several pairs.
using Lanes [[gnu::vector_size(lanes * sizeof(double))]] = double;

/// Directions from source to target of several pairs with the same degrees.
struct PairDirections {
  Lanes cos_azimuth{}, sin_azimuth{}, cos_polar{}, sin_polar{};

  void set(int lane, Vec3 displacement);
};

/// Translation of multipoles to local coefficients about another centre. The axis between the centres is rotated to z,
/// where only equal m interact, and back. About 2 p^3 products per pair, with several pairs at once.
class Translation {
 public:
  explicit Translation(int degree);
  int degree() const { return turn_.degree(); }

  /// Translates `value`: on entry a_lm (2 R_s/d)^l R_s/d up to the source degree, on return b_lm (2 R_t/d)^-l up to the
  /// target degree. Overwrites both arrays of harmonics(larger degree) each.
  void apply(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
             Lanes* scratch) const;

  /// Multiplies by the matrices factor[m][t][t'], up to the degree, in the frame with z along the displacement.
  void in_pair_frame(const PairDirections& directions, int degree, const double* factor, Lanes* value,
                     Lanes* scratch) const;

  /// Shift of the centre of multipoles (`outward`) or of local coefficients. Outward, value_l contributes to degrees t
  /// >= l with length^(t - l); otherwise to t <= l with length^(l - t).
  struct Shift {
    const Lanes& length;
    bool outward;
    int degree, new_degree;
  };
  /// Shifts the centre. `directions`: from the new to the old centre for multipoles, from the old to the new one for
  /// local coefficients. Factors are those of unscaled solid harmonics: moments r^l C_lm, potentials sum b_lm r^l C_lm.
  void shift(const PairDirections& directions, const Shift& shift, Lanes* value, Lanes* scratch) const;

 private:
  template <class AlongAxis>
  void in_axis_frame(const PairDirections& directions, int source_degree, int target_degree, Lanes* value,
                     Lanes* scratch, AlongAxis along) const;
  void shift_along_axis(const Shift& shift, const Lanes* from, Lanes* to) const;
  void turn_about_z(const Lanes& cosine, const Lanes& sine, int degree, Lanes* value) const;
  void quarter_turn(int degree, const Lanes* from, Lanes* to) const;
  void along_axis(int source_degree, int target_degree, const Lanes* from, Lanes* to) const;

  QuarterTurn turn_;
  int side_;
  std::vector<double> axis_;   ///< Layout [m][l target][l source]
  std::vector<double> shift_;  ///< Layout [m][l higher][l lower]
};

}  // namespace lichtenberg::laplace::spheres
