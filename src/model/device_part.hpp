#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/table.hpp"
#include "src/model/whole.hpp"

namespace lichtenberg {

namespace parallel {
class CudaExecutor;
}

/// Grains on a device as they are sorted, in reduced units.
struct DeviceGrains {
  int count = 0;
  Box<3> box;
  const Vec3* position = nullptr;  ///< d0
  const double *radius = nullptr, *charge = nullptr;
  TableView partners;  ///< of each grain, up to the largest reach of all parts
};

/// Units of sums over pairs (m0 v0^2/d0, m0 v0^2): powers of two.
struct PairQuanta {
  double force = 1, energy = 1;
};

/// Forces that an effect adds on a device. Its kernels run on the executor that it was made for.
class DevicePart {
 public:
  virtual ~DevicePart() = default;
  /// Forces and energies of a pair are about that large where they are largest.
  virtual PairQuanta size() const = 0;
  /// Adds the forces on all grains ([N], quanta), and their energy to *energy (quanta).
  virtual void add_forces(const DeviceGrains& grains, const PairQuanta& quanta, WholeVec* force,
                          std::int64_t* energy) const = 0;
};

/// How a part is made, for the executor of a gas.
struct DevicePartForm {
  double reach = 0;      ///< d0, between centres
  bool on_cuda = false;  ///< whether CUDA kernels exist for it where the program has any
  std::function<std::unique_ptr<DevicePart>(const parallel::HostExecutor&)> make_on_host{};
  std::function<std::unique_ptr<DevicePart>(const parallel::CudaExecutor&)> make_on_cuda{};

  std::unique_ptr<DevicePart> make(const parallel::HostExecutor& run) const { return make_on_host(run); }
  std::unique_ptr<DevicePart> make(const parallel::CudaExecutor& run) const { return make_on_cuda(run); }
};

}  // namespace lichtenberg
