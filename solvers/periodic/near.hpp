#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/near_kernels.hpp"

namespace lichtenberg::periodic {

/// Computes the near part of charges and dipoles that are taken for clouds. Sources that follow each other in a column
/// make a cluster; everything near a cluster interacts with all its sources at once. In single precision: charges.
template <class Real>
class Near {
 public:
  static constexpr int together = 8;  ///< sources of a cluster
  /// Highest degree of a cloud's polynomial.
  static constexpr int highest_degree = sizeof(Real) == 4 ? 18 : 30;

  /// Throws InputError for a cutoff beyond longest_cutoff, and for a cloud that needs a higher degree.
  Near(Vec3 lengths, const Cloud& cloud);

  /// The longest cut-off in a box. Half of it, so that a source meets one image of each other; in single precision a
  /// third, so that clusters may be as long as that.
  static double longest_cutoff(Vec3 lengths);
  double cutoff() const { return cutoff_; }
  int degree(Kind kind) const { return table(kind).terms - 1; }
  /// Layout of columns that reach at least as far as the cut-off and `reach`.
  typename Columns<Real>::Layout layout(double reach) const;
  /// Overwrites `sums`, in units of cut-off and charge_unit(). Without `potentials` those stay 0, and the fields have
  /// the same bits. The same bits for any number of threads.
  void compute(const Columns<Real>& columns, Kind kind, bool potentials, const FeltSums<Real>& sums,
               parallel::Team& team) const;

 private:
  using Place = Coordinate<Real>;
  using Table = NearKernels<Real, highest_degree + 1>;
  struct Cluster;
  struct NearColumn;
  template <Kind kind, bool potentials>
  class Neighbourhood;
  template <Kind kind, bool potentials>
  void compute_as(const Columns<Real>& columns, const FeltSums<Real>& sums, parallel::Team& team) const;
  template <Kind kind, bool potentials>
  void compute_column(const Columns<Real>& columns, int column, const FeltSums<Real>& sums) const;
  std::vector<NearColumn> columns_near(const Columns<Real>& columns, int column) const;
  Cluster cluster_from(const Columns<Real>& columns, int first, int end) const;
  Cluster boxed(const Columns<Real>& columns, Cluster cluster, const std::array<Difference<Real>, 3>& low,
                const std::array<Difference<Real>, 3>& high) const;
  bool too_long(const std::array<Difference<Real>, 3>& low, const std::array<Difference<Real>, 3>& high) const;
  const Table& table(Kind kind) const { return kind == Kind::charges ? of_charges_ : of_dipoles_; }

  double cutoff_, widest_;
  std::array<Real, 3> longest_;  ///< extents of a cluster, in cut-offs
  std::array<Real, 3> scale_;    ///< of a coordinate, to cut-offs
  Table of_charges_, of_dipoles_;
};

}  // namespace lichtenberg::periodic
