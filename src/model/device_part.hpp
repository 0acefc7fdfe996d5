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

/// Pointers to the arrays of grains in device memory, in reduced units. Grains are sorted by the cells of the neighbour
/// search, so that near grains are near in memory.
struct DeviceGrains {
  int count = 0;
  Box<3> box;
  const Vec3* position = nullptr;  ///< d0
  const double *radius = nullptr, *charge = nullptr, *inverse_mass = nullptr;
  const int* number = nullptr;  ///< index of each sorted grain in the scene
  const int* image = nullptr;   ///< [3 N], number of periods by which a grain has crossed the box, along each axis
  /// Neighbour list: partners of each grain up to the largest cutoff of all pair forces.
  TableView partners;
};

/// Scale of the force (m0 v0^2/d0) and energy (m0 v0^2) of pairs, in reduced units. As quanta of fixed-point sums over
/// pairs, both are powers of two.
struct PairUnits {
  double force = 1, energy = 1;
};

/// Interface of the pair forces that an effect computes on a device. Forces and energies are summed as integer
/// multiples of quanta, so that the sums do not depend on their order.
class DevicePart {
 public:
  virtual ~DevicePart() = default;
  /// Returns about the largest force and energy of a pair, from which the quanta are chosen.
  virtual PairUnits size() const = 0;
  /// Adds the forces on all grains to `force` ([N], multiples of units.force), and the total energy to *energy
  /// (multiples of units.energy). Both outputs are in device memory.
  virtual void add_forces(const DeviceGrains& grains, const PairUnits& units, FixedPointVec* force,
                          std::int64_t* energy) const = 0;
};

/// Interface of Effect::drive on a device: an external drive, such as a surrounding gas, that changes momenta of
/// grains.
class DeviceDrive {
 public:
  virtual ~DeviceDrive() = default;
  /// Changes the momenta ([N], in device memory) from `time` to `time` + dt (reduced units). Adds the energy that the
  /// grains gain to *driven, as a multiple of `quantum` (m0 v0^2).
  virtual void drive(const DeviceGrains& grains, double time, double dt, Vec3* momentum, double quantum,
                     std::int64_t* driven) const = 0;
};

/// Factory of an effect's device implementation (DevicePart: pair forces; DeviceDrive: external drive) for the executor
/// of a gas: the CPU or a CUDA device. `make_on_cuda` is empty for a law without CUDA kernels.
template <class Implementation>
struct DeviceForm {
  std::function<std::unique_ptr<Implementation>(const parallel::HostExecutor&)> make_on_host{};
  std::function<std::unique_ptr<Implementation>(const parallel::CudaExecutor&)> make_on_cuda{};

  std::unique_ptr<Implementation> make(const parallel::HostExecutor& run) const { return make_on_host(run); }
  std::unique_ptr<Implementation> make(const parallel::CudaExecutor& run) const { return make_on_cuda(run); }
};
/// Factory of an effect's pair forces on a device, with their cutoff.
struct DevicePartForm : DeviceForm<DevicePart> {
  double reach = 0;  ///< d0, cutoff of the distance between centres
};

}  // namespace lichtenberg
