#pragma once

#include <array>
#include <vector>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/convolution.hpp"
#include "solvers/periodic/influence.hpp"

namespace lichtenberg::periodic {

/// Lowest spline order for dipoles: second derivatives of lower orders jump, and so would the forces on dipoles.
constexpr int lowest_dipole_order = 5;

/// Checks a mesh, and returns it. Throws InputError unless the edges of its box are positive and the order of its
/// window is from 4 to `highest_order`. Each axis must also have at least twice as many points as the order.
const Mesh& checked(const Mesh& mesh, int highest_order);

/// Returns the largest distance along an axis from a charge to the mesh points on which it is spread: half of the
/// window's width, for the largest spacing.
double reach_of(const Mesh& mesh);

/// Mesh part of the periodic Coulomb sum (particle-mesh Ewald, P3M): the smooth, long-range potential of charges and
/// dipoles that are replaced by clouds. The order of calls is spread() to assign charges to the mesh, solve() for the
/// potential by FFT, add() to interpolate at the sources.
/// A dipole is spread with the slopes of the windows, as the limit of two opposite charges. Potentials, fields and
/// forces are derivatives of one energy. Results have identical bits for any number of threads. Single precision
/// supports charges only.
template <class Real>
class ChargeMesh {
 public:
  /// Sets up the mesh and its influence function. Throws InputError unless all of this holds. The edges of the box are
  /// positive and finite. Single precision: windows of orders 4 to 8, an even number of points along z. Double
  /// precision: splines of orders 4 to 7. Each axis has at least twice the order in points.
  ChargeMesh(const Mesh& mesh, const Cloud& cloud);

  int order() const { return mesh_.order; }         ///< Order of the window
  double reach() const { return reach_of(mesh_); }  ///< Largest distance along an axis of a charge from its points
  /// Spreads the sources on the mesh (charge assignment). The reach of `columns` must be at least reach(), and their
  /// unit of length the cut-off.
  void spread(const Columns<Real>& columns, Kind kind, parallel::Team& team);
  /// Computes the potential on the mesh from the charges spread: convolution with the influence function by FFT.
  void solve(parallel::Team& team) { grid_.apply(team); }
  /// Interpolates the potential: adds fields, potentials and forces at the sources to `sums`, without those of a
  /// source's own cloud. Units are the cut-off and Columns::charge_unit().
  void add(const Columns<Real>& columns, Kind kind, const FieldSums<Real>& sums, parallel::Team& team) const;

 private:
  using Four = Lanes<4, Real>;
  ChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence);
  template <class Work>
  void with_constants(Kind kind, const Work& work) const;
  void use_rows(const Columns<Real>& columns, int column);
  template <int order, Kind kind>
  void spread_source(const Columns<Real>& columns, int s);
  template <int order, Kind kind>
  void add_to(const FieldSums<Real>& sums, const Columns<Real>& columns, int s) const;
  /// Field and force that a source's own cloud causes on the mesh, with opposite sign.
  struct Own {
    Four field, force;
  };
  template <Kind kind>
  Own own_part(const Columns<Real>& columns, int s, const Four& from_middle) const;
  static Four moment_of(const Columns<Real>& columns, int s) {
    return Four{columns.quantity(1)[s], columns.quantity(2)[s], columns.quantity(3)[s], 0};
  }

  Mesh mesh_;
  /// Coefficients of s^d in the weights of the points around a position, and in their slopes; [d][2 x lanes].
  std::vector<Real> window_;
  std::vector<Real> curvature_;  ///< Coefficients of the weights' second derivatives; [d][lanes]
  Convolution<Real> grid_;
  // The following members are in units of the cut-off.
  std::array<Real, 4> inverse_spacing_;  ///< 1 / spacing along x, y, z; then -1
  std::array<std::array<Real, 4>, 2> wave_;
  Real self_;        ///< Potential of a unit charge's own cloud at its centre, averaged over positions on the mesh
  Real self_field_;  ///< Field of a unit dipole's own cloud at its centre, opposite to the dipole
  double background_, total_ = 0;
};

}  // namespace lichtenberg::periodic
