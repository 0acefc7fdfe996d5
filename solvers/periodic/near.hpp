#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/charge_mesh.hpp"

namespace lichtenberg::periodic {

/// The near rest of charges that are taken for clouds: pairs within the cutoff, each by its nearest image.
class NearPart {
 public:
  /// Throws InputError if the cutoff is more than half a length of the box.
  NearPart(Vec3 lengths, const Cloud& cloud);

  double cutoff() const { return cutoff_; }
  /// Degree of the polynomial in r^2 that stands for the cloud's potential.
  int degree() const { return static_cast<int>(coefficients_.size()) - 1; }
  /// Overwrites `sum`, in the order of the tiles, which reach at least as far as the cutoff. `pairs`: ascending. The
  /// same bits for any number of threads.
  void compute(const Tiles& tiles, std::span<const Pair> pairs, FieldAndPotential sum, parallel::Team& team);

 private:
  class Batch;
  void index(int charges, std::span<const Pair> pairs, parallel::Team& team);

  double cutoff_;
  NearestImage<3> nearest_;
  std::vector<double> coefficients_;        ///< of powers of 2 (r / cutoff)^2 - 1
  std::vector<std::ptrdiff_t> first_pair_;  ///< of each charge, by number
};

}  // namespace lichtenberg::periodic
