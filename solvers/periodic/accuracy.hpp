#pragma once

#include "solvers/periodic/influence.hpp"

namespace lichtenberg::periodic {

/// Root mean square force on N charges at random places, none nearer to another than `contact`, whose squares add up to
/// `charge2`: forces of many pairs add up in squares, charge2^2 / (N V) times the integral of r^-4 over space.
double random_force(double charge2, double charges, double volume, double contact);

/// Root mean square error of the force on such charges over that force: as the square of a pair's error, integrated, to
/// that of its force. So it depends neither on the charges nor on the size of the box.
double relative_error(const Mesh& mesh, const Cloud& cloud, double contact);

/// Parameters of a ParticleMesh.
struct MeshChoice {
  Mesh mesh;
  double band_limit = 0, cutoff = 0;  ///< of its prolate_cloud
  double error = 0;                   ///< relative_error
};

/// The parameters that reach `accuracy`, 1e-8 to 0.1, as a relative_error with least work, which is estimated for
/// `charges` of them: a larger cutoff is more pairs, a smaller one more points. Throws InputError if no cutoff up to
/// half of the box does. With `lowest_order` at least lowest_dipole_order it is good for dipoles.
MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order = 4);

}  // namespace lichtenberg::periodic
