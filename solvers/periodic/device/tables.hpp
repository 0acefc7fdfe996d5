#pragma once

#include <vector>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/near_kernels.hpp"

namespace lichtenberg::periodic::device {

/// Maximum number of terms of the near part's polynomials.
constexpr int most_terms = 20;

/// Parameters of the near part.
struct NearTable {
  float cutoff2 = 0;
  float length[3] = {};  ///< Lengths of the box over 2^32
  NearKernels<float, most_terms> kernels;
};

/// Parameters of a mesh sum on the device, computed by the CPU's functions.
struct MeshTables {
  Mesh mesh;
  NearTable near;
  NearTable multipoles;       ///< Without terms if the mesh does not support dipoles
  std::vector<float> window;  ///< Coefficient of t^d in the c-th weight, at [d * order + c] (Weigher)
  std::vector<float> factor;  ///< Factor of mode (x * points[1] + y) * (points[2] / 2 + 1) + z
  float inverse_spacing[3] = {};
  float self = 0;         ///< Potential of a unit charge's own cloud
  float self_field = 0;   ///< Field of a unit dipole's own cloud, opposite to the dipole
  double reach = 0;       ///< ChargeMesh::reach
  float wave[2][3] = {};  ///< Influence::self_wave relative to the middle between two points
  double cutoff = 0;
  double background = 0;  ///< Potential that a unit of total charge adds everywhere
};

/// Makes the parameters. Throws InputError where ParticleMesh does, except that windows may be prolate for charges
/// without dipoles. Throws InputError for an accuracy beyond single precision.
MeshTables make_tables(const Mesh& mesh, const Cloud& cloud);

}  // namespace lichtenberg::periodic::device
