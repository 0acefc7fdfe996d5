#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Root mean square force on N charges at random positions whose squares add up to `charge2`. No two charges are closer
/// than `contact`. Forces of many pairs add up in squares: the mean square is charge2^2 / (N V) times the integral of
/// r^-4 over all space beyond `contact`.
double random_force(double charge2, double charges, double volume, double contact);

/// Relative error of the force on randomly placed charges: rms force error over rms force. The squared error of a pair
/// is integrated over space and divided by the integral of its squared force. The ratio depends neither on the charges
/// nor on the size of the box. With dipoles of mean square `dipole2` (charges: mean square 1), it is the error of all
/// forces over the rms force between the charges.
double relative_error(const Mesh& mesh, const Cloud& cloud, double contact, double dipole2 = 0);

/// Mean square of the dipoles that charges of mean square 1 induce at this number density. The field has two parts:
/// that of charges at random positions, 4 pi density / contact (mean square), and that of six touching neighbours. Six
/// is the mean coordination number of isostatic packings of frictionless spheres.
double induced_dipole2(double polarizability, double density, double contact);

/// Parameters of a mesh sum.
struct MeshChoice {
  Mesh mesh;
  double cutoff = 0;
  double band_limit = 0;  ///< Band limit of its prolate_cloud.
  double alpha = 0;       ///< Splitting parameter of its gauss_cloud (1/length); 0: the cloud is prolate.
  double error = 0;       ///< Relative error of forces, with that of single precision: relative_error, or the measured
                          ///< one.
  bool single = false;    ///< True for a SingleMesh, false for a ParticleMesh.

  Cloud cloud() const { return alpha > 0 ? gauss_cloud(alpha, cutoff) : prolate_cloud(band_limit, cutoff); }
};

/// Mesh parameters that the user fixes; the others are chosen.
struct FixedParameters {
  std::optional<double> cutoff, alpha;
  std::optional<int> points;  ///< Number of points along the longest side.
  std::optional<int> order;

  bool any() const { return cutoff || alpha || points || order; }
  bool complete() const { return cutoff && points && order; }
};

/// Requirements for the choice of a mesh.
struct MeshRequest {
  double accuracy = 1e-4;  ///< Relative error of forces (relative_error); ignored if `fixed` is complete.
  int charges = 0;
  Vec3 lengths;
  double contact = 1;
  std::optional<double> polarizability{};  ///< Polarizability (length^3) of induced dipoles; empty: no dipoles.
  FixedParameters fixed{};
  bool on_device = false;  ///< True for a DeviceMesh, which also has prolate windows for charges without dipoles.
  // The following options serve comparisons only.
  bool gauss = false;        ///< True: Ewald's Gaussian splitting in place of the prolate one.
  bool splines = false;      ///< True: spline windows for a SingleMesh and a DeviceMesh too.
  bool only_double = false;  ///< True: always a ParticleMesh.
};

/// Smallest relative error of forces that a SingleMesh may be chosen for.
constexpr double finest_single = 6e-7;
/// Returns the reason why a SingleMesh cannot meet the request, as a clause that follows "as"; empty if it may.
std::string why_not_single(const MeshRequest& request);

/// Relative error of forces due to single precision alone: rms error over rms force, measured for 1000 to 50016 random
/// charges.
constexpr double error_of_single_precision = 4e-7;

/// Chooses the ParticleMesh parameters that reach `accuracy` (1e-8 to 0.1, as a relative_error) with the least
/// estimated work for `charges` charges. A larger cut-off means more pairs, a smaller one more mesh points. Throws
/// InputError if no cut-off up to half of the box reaches the accuracy. With `lowest_order` >= lowest_dipole_order the
/// mesh can sum dipoles, but the error estimate ignores them.
MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order = 4);
/// Chooses the parameters of a SingleMesh if there are no dipoles, the accuracy is 6e-7 or more and the box is long
/// enough; otherwise those of a ParticleMesh. If all parameters are given explicitly, only the band limit of the cloud
/// is chosen, for the least error. On a device, parameters for charges without dipoles minimize the estimated device
/// time; with dipoles they are those of a ParticleMesh. Throws InputError if the given parameters exclude the accuracy,
/// or if the precision does not support a given order.
MeshChoice choose_quick_mesh(const MeshRequest& request);
/// Like choose_quick_mesh, but measures the error at the positions of `sources` and aims for between a third and all of
/// the requested error. Relative errors of clusters differ from those at random positions by a factor of up to two,
/// either way. The reference is a finer mesh, or Ewald's sum for some of the charges. Charges at random positions get
/// half of the requested error, so that clusters that form later do not exceed it. If the request cannot be met,
/// `error` of the result is the error reached. Charges that are all 0 are replaced by alternating +1 and -1; dipoles
/// are those that the charges induce.
MeshChoice choose_measured_mesh(const MeshRequest& request, const Sources& sources);

/// Makes the ParticleMesh or SingleMesh with these parameters.
std::unique_ptr<Sum> make_mesh_sum(const MeshChoice& choice);

}  // namespace lichtenberg::periodic
