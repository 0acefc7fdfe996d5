#pragma once

#include <memory>

#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic::device {

/// Measured times (s) of the parts of an evaluation on a device, and the mean number of partners.
struct Profile {
  double lists = 0;  ///< Rebuild of the neighbour lists, for cut-off plus `skin`
  /// Near part; spreading of charges on the mesh; transforms and influence function; interpolation.
  double near = 0, spread = 0, transforms = 0, gather = 0;
  double forces = 0, with_potentials = 0;  ///< All parts except the lists, run as one graph
  double partners = 0;                     ///< Mean number of partners of a charge in the lists
};

/// Particle-mesh Ewald method on a device, in single precision. evaluate() finds the pairs itself.
class DeviceMesh : public Sum {
 public:
  double cutoff() const override { return 0; }
  /// Measures the times of an evaluation of these charges, as means over `repeats` runs of each part. `skin`: margin of
  /// the neighbour lists (length).
  virtual Profile profile(const Sources& sources, double skin, int repeats) = 0;
};

/// Makes a mesh sum on the current CUDA device. `enclosure`: conditions at the sides of the box. The sources have the
/// lengths of the mesh, which is for Enclosure::request(); they are without their images. Throws InputError if there is
/// no usable device or the program was built without CUDA, and the exceptions of make_tables().
std::unique_ptr<DeviceMesh> make_cuda_mesh(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure = {});
/// Makes a mesh sum that runs the device's algorithms sequentially on the CPU, for tests. Throws the exceptions of
/// make_tables().
std::unique_ptr<DeviceMesh> make_host_mesh(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure = {});

}  // namespace lichtenberg::periodic::device
