#pragma once

#include <cstdint>
#include <vector>

#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/near_kernels.hpp"

namespace lichtenberg::periodic::device {

/// Maximum number of terms of the near part's polynomials.
constexpr int most_terms = 20;

/// Parameters of the near part on a device.
struct NearTable {
  float cutoff2 = 0;                       ///< Squared cut-off
  float length[3] = {};                    ///< Edges of the box over 2^32
  NearKernels<float, most_terms> kernels;  ///< Polynomials of the near kernels
};

/// Grounded sides of a box, in which charges have images: opposite charges, reflected along an axis.
struct Mirrors {
  bool along[3] = {};
  std::uint32_t twice[3] = {};  ///< Twice the coordinate of the side, in fixed point (FixedPointPosition)

  /// Returns the number of copies of each charge: itself and its images.
  LICHTENBERG_HOST_DEVICE int copies() const { return 1 << (along[0] + along[1] + along[2]); }
};

/// Parameters of a mesh sum on a device, computed by the functions of the CPU's method.
struct MeshTables {
  Mesh mesh;
  NearTable near;             ///< Near part of charges
  NearTable multipoles;       ///< Near part of charges with dipoles; without terms if the mesh does not support them
  std::vector<float> window;  ///< Coefficient of t^d in the c-th weight, at [d * order + c] (Weigher)
  std::vector<float> factor;  ///< Influence function: mode (x, y, z) at (x * points[1] + y) * (points[2] / 2 + 1) + z
  float inverse_spacing[3] = {};
  float self = 0;         ///< Potential of a unit charge's own cloud
  float self_field = 0;   ///< Field of a unit dipole's own cloud, opposite to the dipole
  double reach = 0;       ///< Half of the window's width (ChargeMesh::reach)
  float wave[2][3] = {};  ///< Influence::self_wave relative to the middle between two points
  double cutoff = 0;      ///< Cut-off of the near part
  double background = 0;  ///< Potential of the neutralizing background per unit of total charge
  Mirrors mirrors{};      ///< Grounded sides of the box, if any
};

/// Computes the parameters of a mesh sum on a device. `enclosure`: conditions at the sides, whose images the sum adds;
/// the mesh is one for Enclosure::request(). Throws InputError unless the order of the window is from 4 to 7
/// and each axis has at least twice as many points. Throws InputError for a cut-off beyond half of the shortest edge.
/// Throws InputError if the near part needs more than most_terms terms, because of an accuracy beyond single precision.
MeshTables make_tables(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure = {});

}  // namespace lichtenberg::periodic::device
