#pragma once

#include <memory>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic::device {

/// Wall times (s) of the parts of an evaluation, and the mean number of partners.
struct Profile {
  double lists = 0;  ///< Rebuild of the lists, for cut-off plus `skin`
  double near = 0, spread = 0, transforms = 0, gather = 0;
  double forces = 0, with_potentials = 0;  ///< Everything except the lists, run as one graph
  double partners = 0;                     ///< Mean number of partners of a charge in the lists
};

/// Mesh sum on a device. It finds its own pairs.
class DeviceMesh : public Sum {
 public:
  double cutoff() const override { return 0; }
  /// Measures an evaluation of these charges, with `repeats` runs of each part.
  virtual Profile profile(const Sources& sources, double skin, int repeats) = 0;
};

/// Makes a mesh sum on the first CUDA device. Throws InputError if there is no usable device, for parameters that
/// ParticleMesh refuses, and for an accuracy beyond single precision.
std::unique_ptr<DeviceMesh> make_cuda_mesh(const Mesh& mesh, const Cloud& cloud);
/// Makes a mesh sum that runs the device's algorithms sequentially on the CPU, for tests.
std::unique_ptr<DeviceMesh> make_host_mesh(const Mesh& mesh, const Cloud& cloud);

}  // namespace lichtenberg::periodic::device
