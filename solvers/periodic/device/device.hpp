#pragma once

#include <memory>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic::device {

/// Seconds of the parts of an evaluation, and how many bytes of the device it takes.
struct Profile {
  double lists = 0;  ///< made for `skin` more than the cutoff
  double near = 0, spread = 0, transforms = 0, gather = 0;
  double forces = 0, with_potentials = 0;  ///< all but the lists, run as one graph
  double partners = 0;                     ///< in the lists, of a charge
};

/// ParticleMesh on a device. It finds its pairs itself.
class DeviceMesh : public Sum {
 public:
  double cutoff() const override { return 0; }
  /// Of an evaluation of these charges, each part run `repeats` times.
  virtual Profile profile(const Sources& sources, double skin, int repeats) = 0;
};

/// On the first CUDA device. Throws InputError if there is none that can be used, for parameters that ParticleMesh
/// would refuse, and for an accuracy that single precision does not have.
std::unique_ptr<DeviceMesh> make_cuda_mesh(const Mesh& mesh, const Cloud& cloud);
/// The device's algorithms run by the CPU, item after item, for tests.
std::unique_ptr<DeviceMesh> make_host_mesh(const Mesh& mesh, const Cloud& cloud);

}  // namespace lichtenberg::periodic::device
