#pragma once

#include <span>
#include <vector>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/columns.hpp"

namespace lichtenberg::periodic {

/// The near rest of charges that are taken for clouds, in single precision. It finds the pairs itself: charges that
/// follow each other in a column make a cluster, and all that is near a cluster meets all of its charges at once.
class SingleNear {
 public:
  /// Charges of a cluster.
  static constexpr int together = 8;

  SingleNear(Vec3 lengths, const Cloud& cloud);

  /// The longest cut-off in this box, a third of it: what acts on a cluster, which is no larger than that, then has its
  /// nearest image in common for all of its charges.
  static double longest_cutoff(Vec3 lengths);
  static constexpr int highest_degree = 18;  ///< of a cloud's polynomial
  /// Overwrites `sums`; the columns' reach is at least the cut-off. `sums`: field x, y, z and potential at each sorted
  /// charge, four numbers, in units of cut-off and Columns::charge_unit; without `potentials` those stay 0, and the
  /// fields are the same bits.
  void compute(const Columns& columns, bool potentials, std::span<float> sums, parallel::Team& team) const;

 private:
  struct Cluster;
  struct NearColumn;
  template <int degree, bool potentials>
  class Neighbourhood;
  template <int degree>
  void compute_by_degree(const Columns& columns, bool potentials, float* sums, parallel::Team& team) const;
  std::vector<NearColumn> columns_near(const Columns& columns, int column) const;
  template <int degree, bool potentials>
  void compute_column(const Columns& columns, int column, float* sums) const;
  Cluster cluster_from(const Columns& columns, int first, int end) const;
  Cluster boxed(const Columns& columns, Cluster cluster, const std::array<std::int32_t, 3>& low,
                const std::array<std::int32_t, 3>& high) const;

  float highest_;               ///< cluster, in cut-offs: no more than a third of the box, nor with much nothing in it
  std::array<float, 3> scale_;  ///< of Turns, to cut-offs
  std::vector<float> polynomial_;  ///< of the cloud's potential, in 2 r^2 - 1
  std::vector<float> slope_;       ///< of its derivative by r^2, times 2
};

}  // namespace lichtenberg::periodic
