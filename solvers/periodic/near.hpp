#pragma once

#include <array>
#include <vector>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/near_kernels.hpp"

namespace lichtenberg::periodic {

/// Near part (real-space sum) of a periodic Coulomb sum of charges and dipoles: the interaction of pairs within the
/// cut-off, minus that of their clouds. Consecutive sources of a column form a cluster; all sources near a cluster
/// interact with the whole cluster at once by SIMD. Single precision supports charges only.
template <class Real>
class Near {
 public:
  static constexpr int together = 8;  ///< Maximum number of sources of a cluster
  /// Highest degree of the polynomial that represents a cloud's potential.
  static constexpr int highest_degree = sizeof(Real) == 4 ? 18 : 30;

  /// Makes the tables of the near part for a box with these edges. Throws InputError for a cut-off beyond
  /// longest_cutoff(), and for a cloud that needs a polynomial above highest_degree.
  Near(Vec3 lengths, const Cloud& cloud);

  /// Returns the longest possible cut-off in a box. In double precision it is half of the shortest side, so that a
  /// source meets one image of each other source. In single precision it is a third of the shortest side, so that
  /// clusters may be as long as the cut-off.
  static double longest_cutoff(Vec3 lengths);
  double cutoff() const { return cutoff_; }                      ///< Cut-off (length)
  int degree(Kind kind) const { return table(kind).terms - 1; }  ///< Degree of the cloud's polynomial
  /// Returns the layout of Columns for the near part, with a reach of at least the cut-off and the given `reach` of a
  /// mesh. `volume`: that of the part of the box that contains sources; 0: the whole box.
  typename Columns<Real>::Layout layout(double reach, double volume = 0) const;
  /// Computes the near part of fields, potentials and forces: overwrites `sums`, in units of the cut-off and
  /// Columns::charge_unit(). Without `potentials` the potentials of charges are 0, and the fields have the same bits.
  /// Results have identical bits for any number of threads. Throws InputError for dipoles in single precision.
  void compute(const Columns<Real>& columns, Kind kind, bool potentials, const FieldSums<Real>& sums,
               parallel::Team& team) const;

 private:
  using FixedPoint = Coordinate<Real>;
  using Table = NearKernels<Real, highest_degree + 1>;
  struct Cluster;
  struct NearColumn;
  template <Kind kind, bool potentials>
  class Neighbourhood;
  template <Kind kind, bool potentials>
  void compute_as(const Columns<Real>& columns, const FieldSums<Real>& sums, parallel::Team& team) const;
  template <Kind kind, bool potentials>
  void compute_column(const Columns<Real>& columns, int column, const FieldSums<Real>& sums) const;
  std::vector<NearColumn> columns_near(const Columns<Real>& columns, int column) const;
  Cluster cluster_from(const Columns<Real>& columns, int first, int end) const;
  Cluster boxed(const Columns<Real>& columns, Cluster cluster, const std::array<Difference<Real>, 3>& low,
                const std::array<Difference<Real>, 3>& high) const;
  bool too_long(const std::array<Difference<Real>, 3>& low, const std::array<Difference<Real>, 3>& high) const;
  const Table& table(Kind kind) const { return kind == Kind::charges ? charge_kernels_ : dipole_kernels_; }

  double cutoff_, widest_;
  std::array<Real, 3> longest_;  ///< Largest extents of a cluster, in units of the cut-off
  std::array<Real, 3> scale_;    ///< Factors from coordinates to lengths in units of the cut-off
  Table charge_kernels_, dipole_kernels_;
};

}  // namespace lichtenberg::periodic
