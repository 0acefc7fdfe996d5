#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Root mean square force on N charges at random places, none nearer to another than `contact`, whose squares add up to
/// `charge2`: forces of many pairs add up in squares, charge2^2 / (N V) times the integral of r^-4 over space.
double random_force(double charge2, double charges, double volume, double contact);

/// Root mean square error of the force on such charges over that force: as the square of a pair's error, integrated, to
/// that of its force. So it depends neither on the charges nor on the size of the box.
/// With dipoles of mean square `dipole2`, where that of charges is 1, it is the error of all forces over that of
/// charges among each other.
double relative_error(const Mesh& mesh, const Cloud& cloud, double contact, double dipole2 = 0);

/// Mean square of the dipoles that charges of mean square 1 induce at such a density, from the field at random places,
/// 4 pi density / contact, and from six neighbours that touch: spheres that carry each other have no more on average.
double induced_dipole2(double polarizability, double density, double contact);

/// Parameters of a mesh.
struct MeshChoice {
  Mesh mesh;
  double cutoff = 0;
  double band_limit = 0;  ///< of its prolate_cloud
  double alpha = 0;       ///< of its gauss_cloud; 0: the cloud is prolate
  double error = 0;       ///< relative_error, with that of single precision; or what was found, if it was measured
  bool single = false;    ///< for a SingleMesh, not a ParticleMesh

  Cloud cloud() const { return alpha > 0 ? gauss_cloud(alpha, cutoff) : prolate_cloud(band_limit, cutoff); }
};

/// Parameters that are not to be chosen.
struct ByHand {
  std::optional<double> cutoff, alpha;
  std::optional<int> points;  ///< along the longest side
  std::optional<int> order;

  bool any() const { return cutoff || alpha || points || order; }
  bool complete() const { return cutoff && points && order; }
};

/// What a mesh is for.
struct MeshRequest {
  double accuracy = 1e-4;  ///< as a relative_error; means nothing if all is given by hand
  int charges = 0;
  Vec3 lengths;
  double contact = 1;
  std::optional<double> polarizability{};  ///< of dipoles that the charges induce; none: there are no dipoles
  ByHand by_hand{};
  double longest_cutoff = INFINITY;  ///< of a ParticleMesh, in a box whose half is longer
  bool on_device = false;            ///< a DeviceMesh, which for charges alone has prolate windows too
  // For comparisons; runs have no reason to ask for any.
  bool gauss = false;        ///< Ewald's splitting in place of the prolate one
  bool splines = false;      ///< splines for windows of a SingleMesh and a DeviceMesh too
  bool only_double = false;  ///< a ParticleMesh in any case
};

/// The accuracy that a SingleMesh is good for.
constexpr double finest_single = 6e-7;
/// What keeps a SingleMesh from what is asked for, in words that follow "as"; empty if one might do.
std::string why_not_single(const MeshRequest& request);

/// Error of forces that single precision makes by itself: found over rms force, of 1000 to 50016 random charges.
constexpr double error_of_single_precision = 4e-7;

/// The parameters of a ParticleMesh that reach `accuracy`, 1e-8 to 0.1, as a relative_error with least work, which is
/// estimated for `charges` of them: a larger cutoff is more pairs, a smaller one more points. Throws InputError if no
/// cutoff up to half of the box does. With `lowest_order` at least lowest_dipole_order it can do dipoles, which its
/// error doesn't count.
MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order = 4);
/// The same of a SingleMesh, if there are no dipoles, the accuracy is 6e-7 or more and the box is long enough for one.
/// With all given by hand only the cloud's band limit is left to choose: the one of least error. Throws InputError if
/// what is given by hand leaves no way to reach the accuracy, or an order is given that the precision does not know.
/// On a device parameters of charges alone are chosen by what takes its time; with dipoles they are those of a
/// ParticleMesh.
MeshChoice choose_quick_mesh(const MeshRequest& request);
/// The same, with parameters whose error at these places lies between a third of what is asked for and that: relative
/// errors of clusters differ from those of charges at random places by up to two, either way. It is measured against a
/// finer mesh, or Ewald's sum of some charges. Charges at random places get half of what is asked for, so that
/// clusters which form later do not exceed it. What cannot be had so says it in `error`. Charges that are all 0 are
/// taken for +1 and -1 in turns; dipoles are those that they induce.
MeshChoice choose_measured_mesh(const MeshRequest& request, const Sources& sources);

/// Makes the ParticleMesh or SingleMesh of these parameters.
std::unique_ptr<Sum> make_mesh_sum(const MeshChoice& choice);

}  // namespace lichtenberg::periodic
