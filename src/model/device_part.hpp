#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/table.hpp"
#include "src/model/fixed_point_vec.hpp"

namespace lichtenberg {

namespace parallel {
class CudaExecutor;
}

/// Grains on a device in sorted order, in reduced units.
struct DeviceGrains {
  int count = 0;
  Box<3> box;
  const Vec3* position = nullptr;  ///< d0
  const double *radius = nullptr, *charge = nullptr, *inverse_mass = nullptr;
  const int* number = nullptr;  ///< index of each grain in the scene
  /// Partners of each grain, up to the largest cutoff of all parts.
  TableView partners;
};

/// Units of sums over pairs (m0 v0^2/d0, m0 v0^2): powers of two.
struct PairUnits {
  double force = 1, energy = 1;
};

/// Pair forces that an effect adds on a device. Its kernels run on the executor for which it was made.
class DevicePart {
 public:
  virtual ~DevicePart() = default;
  /// Returns the approximate maxima of the force and energy of a pair.
  virtual PairUnits size() const = 0;
  /// Adds the forces on all grains ([N], quanta), and adds their energy to *energy (quanta).
  virtual void add_forces(const DeviceGrains& grains, const PairUnits& units, FixedPointVec* force,
                          std::int64_t* energy) const = 0;
};

/// Device implementation of Effect::drive.
class DeviceDrive {
 public:
  virtual ~DeviceDrive() = default;
  /// Changes the momenta ([N]) from `time` to `time` + dt, and adds the energy that they gain to *driven (quanta).
  virtual void drive(const DeviceGrains& grains, double time, double dt, Vec3* momentum, double quantum,
                     std::int64_t* driven) const = 0;
};

/// Factory of a part, for the executor of a gas.
template <class Implementation>
struct DeviceForm {
  std::function<std::unique_ptr<Implementation>(const parallel::HostExecutor&)> make_on_host{};
  std::function<std::unique_ptr<Implementation>(const parallel::CudaExecutor&)> make_on_cuda{};

  std::unique_ptr<Implementation> make(const parallel::HostExecutor& run) const { return make_on_host(run); }
  std::unique_ptr<Implementation> make(const parallel::CudaExecutor& run) const { return make_on_cuda(run); }
};
struct DevicePartForm : DeviceForm<DevicePart> {
  double reach = 0;  ///< d0, cutoff of the centre distance
};

}  // namespace lichtenberg
