#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/charge_mesh.hpp"

namespace lichtenberg::periodic {

/// Coefficients of powers of 2 (r / cutoff)^2 - 1 of a polynomial that stands for the cloud's potential within the
/// cutoff, of the lowest degree that changes the force between charges by less than .3 of what the cloud itself loses,
/// both rms over the ball of the cutoff: errors add up in squares, so it adds 2 % to that of the whole.
std::vector<double> cloud_polynomial(const Cloud& cloud);

/// The near rest of charges and dipoles that are taken for clouds: pairs within the cutoff, each by its nearest image.
class NearPart {
 public:
  /// Throws InputError if the cutoff is more than half a length of the box.
  NearPart(Vec3 lengths, const Cloud& cloud);

  double cutoff() const { return cutoff_; }
  /// Degree of the polynomial in r^2 that stands for the cloud's potential; dipoles take more of its derivatives.
  int degree(Kind kind) const { return static_cast<int>(coefficients(kind).size()) - 1; }
  /// Its coefficients, of powers of 2 (r / cutoff)^2 - 1.
  const std::vector<double>& coefficients(Kind kind) const { return kind == Kind::charges ? of_charges_ : of_dipoles_; }
  /// Overwrites `sums`; the tiles reach at least as far as the cutoff. `pairs`: ascending. The same bits for any number
  /// of threads.
  void compute(const Tiles& tiles, std::span<const Pair> pairs, Kind kind, const FeltSums& sums, parallel::Team& team);

 private:
  template <Kind kind>
  class Batch;
  template <Kind kind>
  void compute_as(const Tiles& tiles, std::span<const Pair> pairs, const FeltSums& sums, parallel::Team& team);
  void index(int charges, std::span<const Pair> pairs, parallel::Team& team);

  double cutoff_;
  NearestImage<3> nearest_;
  std::vector<double> of_charges_, of_dipoles_;  ///< coefficients of powers of 2 (r / cutoff)^2 - 1
  std::vector<std::ptrdiff_t> first_pair_;       ///< of each charge, by number
};

}  // namespace lichtenberg::periodic
