#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/granular/device/snapshot.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular::device {

/// Counters and times since the gas was loaded.
struct StepCounts {
  std::int64_t steps = 0, contact_steps = 0;
  std::int64_t lists = 0, evaluations = 0;  ///< rebuilt neighbour lists, evaluated sums over charges
  double seconds = 0, list_seconds = 0;     ///< wall time: total, and for lists
};

/// A gas of grains on a device, advanced by the steps of Multirate. Its state is exchanged as a checkpoint of Gas, the
/// same as on the CPU.
class DeviceGas {
 public:
  virtual ~DeviceGas() = default;

  /// Loads a gas. `elastic`: an elastic stage without charge exchange; `stage_begin` (t0): start of the present law.
  virtual void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin = 0) = 0;
  /// Returns the present state.
  virtual Snapshot snapshot() const = 0;
  /// Updates the checkpoint that was loaded.
  void store(Checkpoint& checkpoint) const { device::store(snapshot(), checkpoint); }
  virtual double potential_energy() = 0;
  virtual double time() const = 0;
  /// Advances towards `time` (t0), by at most `most` steps; by one step in scenes with Effect::drive. Throws Failure as
  /// Gas does.
  virtual void step(double time, int most = 1) = 0;
  virtual StepCounts counts() const = 0;
};

/// Executor of the kernels; tests use the host.
enum class Target { host, cuda };

/// Throws InputError for a scene with features that a device does not compute.
void check_scene(const Scene& scene, Target target = Target::cuda);
/// Returns an estimate of the device memory (bytes) of a gas, for evenly distributed grains.
double bytes_needed(const Scene& scene);

/// Makes a gas on the first CUDA device. Throws InputError as check_scene does, or if there is no usable device;
/// Failure if it lacks memory.
std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene);
/// Makes a gas that runs the device's algorithms sequentially on the CPU, for tests.
std::unique_ptr<DeviceGas> make_host_gas(const Scene& scene);

}  // namespace lichtenberg::granular::device
