#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/spheres/harmonics.hpp"

namespace lichtenberg::laplace::spheres {

constexpr int lanes = 8;
/// The same number of several pairs.
using Lanes [[gnu::vector_size(lanes * sizeof(double))]] = double;

/// Several pairs of one source degree and one target degree, each with its way from source to target.
struct Ways {
  Lanes cos_azimuth{}, sin_azimuth{}, cos_polar{}, sin_polar{};

  void set(int lane, Vec3 way);
};

/// Turns the fields that multipoles make into local coefficients elsewhere: the axis between the two is turned into z,
/// where only equal m meet, and back. About 2 p^3 products a pair, with several pairs at once.
class Translation {
 public:
  explicit Translation(int degree);
  int degree() const { return turn_.degree(); }

  /// value: on entry a_lm (2 R_s/d)^l R_s/d up to the source degree, on return b_lm (2 R_t/d)^-l up to the target
  /// degree; overwrites both arrays, of harmonics(larger degree) each.
  void apply(const Ways& ways, int source_degree, int target_degree, Lanes* value, Lanes* scratch) const;

  /// Multiplies by matrices factor[m][t][t'], up to the degree, in the frame whose z is the way.
  void in_pair_frame(const Ways& ways, int degree, const double* factor, Lanes* value, Lanes* scratch) const;

  /// A move of the centre of multipoles (`outward`) or of local coefficients: value_l goes into degrees t >= l times
  /// the length to the power t - l, or the other way round into t <= l times its power l - t.
  struct Shift {
    const Lanes& length;
    bool outward;
    int degree, new_degree;
  };
  /// `ways` lead from the new
  /// centre of multipoles to the old one, and for local coefficients from the old one to the new one. Factors are those
  /// of solid harmonics without scale: moments r^l C_lm, potentials sum b_lm r^l C_lm.
  void shift(const Ways& ways, const Shift& shift, Lanes* value, Lanes* scratch) const;

 private:
  template <class AlongAxis>
  void in_axis_frame(const Ways& ways, int source_degree, int target_degree, Lanes* value, Lanes* scratch,
                     AlongAxis along) const;
  void shift_along_axis(const Shift& shift, const Lanes* from, Lanes* to) const;
  void turn_about_z(const Lanes& cosine, const Lanes& sine, int degree, Lanes* value) const;
  void quarter_turn(int degree, const Lanes* from, Lanes* to) const;
  void along_axis(int source_degree, int target_degree, const Lanes* from, Lanes* to) const;

  QuarterTurn turn_;
  int side_;
  std::vector<double> axis_;   ///< [m][l target][l source]
  std::vector<double> shift_;  ///< [m][l higher][l lower]
};

}  // namespace lichtenberg::laplace::spheres
