#pragma once

#include <array>
#include <vector>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/near_kernels.hpp"

namespace lichtenberg::periodic::device {

/// Terms of the near part's polynomials.
constexpr int most_terms = 20;

/// The near part.
struct NearTable {
  float cutoff2 = 0;
  float length[3] = {};  ///< of the box, over 2^32
  NearKernels<float, most_terms> kernels;
};

/// What a mesh of charges is made of, from the CPU's parameters and functions.
struct MeshTables {
  Mesh mesh;
  NearTable near;
  NearTable multipoles;       ///< without terms: there can be no dipoles
  std::vector<float> window;  ///< of t^d in the c-th weight: [d * order + c] (Weigher)
  std::vector<float> factor;  ///< of mode (x * points[1] + y) * (points[2] / 2 + 1) + z
  float over_spacing[3] = {};
  float self = 0;         ///< potential of a unit charge's own cloud
  float self_field = 0;   ///< field of a unit dipole's own cloud, against it
  double reach = 0;       ///< ChargeMesh::reach
  float wave[2][3] = {};  ///< Influence::self_wave, seen from the middle between two points
  double cutoff = 0;
  double background = 0;  ///< potential that a unit of total charge adds everywhere
};

/// Throws InputError where ParticleMesh does but that windows may be prolate, for charges alone, and for an accuracy
/// beyond single precision.
MeshTables make_tables(const Mesh& mesh, const Cloud& cloud);

}  // namespace lichtenberg::periodic::device
