#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/convolution.hpp"
#include "solvers/periodic/influence.hpp"

namespace lichtenberg::periodic {

/// Least order of splines for dipoles: below, their second derivatives jump, and with them the forces on dipoles.
constexpr int lowest_dipole_order = 5;

/// Returns the mesh. Throws InputError unless there are windows of its order and enough points for them.
const Mesh& checked(const Mesh& mesh, int highest_order);

/// The largest distance along an axis from a charge to the points that it is spread to: half a window.
double reach_of(const Mesh& mesh);

/// Charges and dipoles taken for clouds, on a mesh: `spread` them, `solve` for the potential, `add` it at their places,
/// in this order. A dipole is spread as a charge that is moved a little, with the windows' slopes: potentials, fields
/// and forces are all slopes of one energy. Each has the same bits for any number of threads. In single precision:
/// charges.
template <class Real>
class ChargeMesh {
 public:
  /// Single precision: windows of orders from 4 to 8, an even number of points along z. Double precision: splines of
  /// orders from 4 to 7. At least twice the order in points along each axis. Throws InputError.
  ChargeMesh(const Mesh& mesh, const Cloud& cloud);

  int order() const { return mesh_.order; }
  double reach() const { return reach_of(mesh_); }
  /// The columns' reach is at least this one's, their unit of length the cut-off.
  void spread(const Columns<Real>& columns, Kind kind, parallel::Team& team);
  void solve(parallel::Team& team) { grid_.apply(team); }
  /// Adds fields and forces without those of a source's own cloud. Units as of Near::compute.
  void add(const Columns<Real>& columns, Kind kind, const FeltSums<Real>& sums, parallel::Team& team) const;

 private:
  using Four = Lanes<4, Real>;
  ChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence);
  template <class Work>
  void with_constants(Kind kind, const Work& work) const;
  template <int order, Kind kind>
  void spread_source(const Columns<Real>& columns, int s);
  template <int order, Kind kind>
  void add_to(const FeltSums<Real>& sums, const Columns<Real>& columns, int s) const;
  struct Own {
    Four field, force;
  };
  template <Kind kind>
  Own own_part(const Columns<Real>& columns, int s, const Four& from_middle) const;
  static Four moment_of(const Columns<Real>& columns, int s) {
    return Four{columns.quantity(1)[s], columns.quantity(2)[s], columns.quantity(3)[s], 0};
  }

  Mesh mesh_;
  std::vector<Real> window_;     ///< of s^d: weights of the points around a place, and their slopes; [d][2 x lanes]
  std::vector<Real> curvature_;  ///< second derivatives of the weights, [d][lanes]
  Convolution<Real> grid_;
  // In units of the cut-off.
  std::array<Real, 4> over_spacing_;  ///< along x, y, z; and -1
  std::array<std::array<Real, 4>, 2> wave_;
  Real self_;        ///< potential of a unit charge's own cloud, on average, at its centre
  Real self_field_;  ///< field of a unit dipole's own cloud at its centre, against it
  double background_, total_ = 0;
};

}  // namespace lichtenberg::periodic
