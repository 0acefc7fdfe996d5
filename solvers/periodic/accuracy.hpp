#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Computes the root mean square force on charges at random positions. `charge2`: sum of the squared charges;
/// `charges`: their number N; `volume`: V; no two charges are closer than `contact`. Squared forces of pairs add up:
/// the mean square is charge2^2 / (N V) times the integral of r^-4 over all space beyond `contact`.
double random_force(double charge2, double charges, double volume, double contact);

/// Estimates the relative error of the forces of a mesh sum on randomly placed charges: rms force error over rms force.
/// Its square is the squared error of a pair, integrated over space, divided by the integral of the squared force
/// beyond the distance `contact`. It does not depend on the charges, and hardly on the size of the box. Rounding errors
/// are not included. With dipoles of mean square `dipole2` (for charges of mean square 1), it is the error of all
/// forces over the rms force between the charges.
double relative_error(const Mesh& mesh, const Cloud& cloud, double contact, double dipole2 = 0);

/// Estimates the mean square of the dipoles that charges of mean square 1 induce, for a polarizability (length^3),
/// number density (1/length^3) and smallest distance `contact` (length). It is polarizability^2 times the mean squared
/// field. The mean squared field is 4 pi density / contact of charges at random positions plus 6 / contact^4 of six
/// touching neighbours. Six is the mean coordination number of isostatic packings of frictionless spheres.
double induced_dipole2(double polarizability, double density, double contact);

/// Chosen parameters of a mesh sum: mesh, splitting of 1/r and precision.
struct MeshChoice {
  Mesh mesh;
  double cutoff = 0;      ///< Cut-off of the near part (length).
  double band_limit = 0;  ///< Band limit of its prolate_cloud.
  double alpha = 0;       ///< Splitting parameter of its gauss_cloud (1/length); 0: the cloud is prolate.
  /// Relative error of forces, including single precision: estimated by relative_error(), or measured.
  double error = 0;
  bool single = false;  ///< True for a SingleMesh, false for a ParticleMesh.

  /// Makes the charge cloud of these parameters.
  Cloud cloud() const { return alpha > 0 ? gauss_cloud(alpha, cutoff) : prolate_cloud(band_limit, cutoff); }
};

/// Parameters of a mesh sum that the user fixes; absent parameters are chosen.
struct FixedParameters {
  std::optional<double> cutoff, alpha;
  std::optional<int> points;  ///< Number of points along the longest side.
  std::optional<int> order;

  bool any() const { return cutoff || alpha || points || order; }  ///< True if a parameter is fixed
  bool complete() const { return cutoff && points && order; }      ///< True if only the cloud is to be chosen
};

/// Requirements for the choice of a mesh sum.
struct MeshRequest {
  double accuracy = 1e-4;  ///< Relative error of forces (relative_error); ignored if `fixed` is complete.
  int charges = 0;         ///< Number of charges.
  Vec3 lengths;            ///< Edges of the periodic box.
  double contact = 1;      ///< Smallest distance between two charges.
  std::optional<double> polarizability{};  ///< Polarizability (length^3) of induced dipoles; empty: no dipoles.
  FixedParameters fixed{};
  /// Mean number density around a charge, within balls of radius 2^(-k/2) times the longest edge, k = 0, 1, ...;
  /// empty: uniform.
  std::vector<double> local_density{};
  std::array<double, 2> used{1, 1};  ///< Part of the box along x and y outside the longest gap between charges
  bool on_device = false;  ///< True for a DeviceMesh, which also has prolate windows for charges without dipoles.
  // The following options serve comparisons only.
  bool gauss = false;        ///< True: Ewald's Gaussian splitting in place of the prolate one.
  bool splines = false;      ///< True: spline windows for a SingleMesh and a DeviceMesh too.
  bool only_double = false;  ///< True: always a ParticleMesh.
  /// Axes without periodic images (OpenAxes). Along them `lengths` are the ranges of the charges' positions, 0 or more.
  std::array<bool, 3> open{};

  /// Returns a mesh without points in the box that a cut-off requires. It is longer along open axes, so that images are
  /// beyond the end of the Green's function.
  Mesh box(double cutoff) const;
};

/// Returns the mean number density of the charges of a request around a charge within a radius.
double density_around(const MeshRequest& request, double radius);

/// Smallest relative error of forces for which a SingleMesh may be chosen.
constexpr double finest_single = 6e-7;
/// Returns the reason why no SingleMesh is chosen for the request, for an error message with "as" before it. Empty if
/// one may be chosen.
std::string why_not_single(const MeshRequest& request);

/// Relative error of forces due to single precision alone: rms error over rms force for charges at random positions
/// (tests/periodic_single_test.cpp).
constexpr double error_of_single_precision = 4e-7;

/// Chooses the parameters of a ParticleMesh (double precision) with the least estimated work for a relative error
/// `accuracy` from 1e-8 to 0.1. `charges`: number of charges; `lengths`: edges of the box; `contact`: smallest distance
/// of charges. A larger cut-off means more pairs, a smaller one more mesh points. With `lowest_order` >=
/// lowest_dipole_order the mesh can sum dipoles, but the error estimate ignores them. Throws InputError if no cut-off
/// up to half of the shortest edge reaches the accuracy, or if an argument is out of range.
MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order = 4);
/// Chooses the parameters of a mesh sum with the least estimated time from estimated errors. The result is a SingleMesh
/// if why_not_single() is empty and single precision reaches the accuracy; otherwise a ParticleMesh.
/// If cut-off, points and order are fixed, the function chooses precision, window and band limit only, and ignores the
/// requested accuracy. On a device, parameters for charges without dipoles minimize the estimated device time; with
/// dipoles they are those of a ParticleMesh. Throws InputError if no parameters reach the accuracy, which must be from
/// 1e-8 to 0.1, or if the precision does not support a fixed order.
MeshChoice choose_quick_mesh(const MeshRequest& request);
/// Chooses the parameters of a mesh sum, as choose_quick_mesh() does, with the error measured at the positions of
/// `sources`. The aim is a measured error between a third of the requested error and all of it. Relative errors of
/// clusters can differ from those at random positions by a factor of about two, either way
/// (docs/measurements/periodic.json).
/// The reference forces are those of a finer mesh, or of Ewald's sum for all or some of the charges. The first trial is
/// made for half of the requested error, so that clusters that form later do not exceed it. If the request cannot be
/// met, `error` of the result is the error reached. Charges that are all 0 are replaced by alternating +1 and -1;
/// dipoles are those that the charges induce. Without a measurement the result is that of choose_quick_mesh(): if
/// cut-off, points and order are fixed, for fewer than two sources, and if the forces vanish.
/// `team`: threads of the measurement.
MeshChoice choose_measured_mesh(const MeshRequest& request, const Sources& sources,
                                parallel::Team& team = parallel::Team::single());

/// Returns the estimated time (s) of one evaluation of the forces between charges on one core with AVX-512, for a
/// choice made for the request.
double seconds_of(const MeshChoice& choice, const MeshRequest& request);

/// Makes the mesh sum (ParticleMesh or SingleMesh) with these parameters.
std::unique_ptr<Sum> make_mesh_sum(const MeshChoice& choice);

}  // namespace lichtenberg::periodic
