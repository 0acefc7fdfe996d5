#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/granular/device/snapshot.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/model/surface_law.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular::device {

/// Counters and wall times (s) of a gas on a device since it was made.
struct StepCounts {
  std::int64_t steps = 0, contact_steps = 0;  ///< outer steps, contact substeps
  std::int64_t lists = 0, evaluations = 0;    ///< rebuilt neighbour lists, evaluated Coulomb sums
  double seconds = 0, list_seconds = 0;       ///< wall time: total, and for neighbour lists
};

/// Interface of a gas of grains on a device, advanced by multiple time stepping (Multirate). The state is loaded from
/// and stored to a checkpoint of Gas, the gas on the CPU. Reduced units.
class DeviceGas {
 public:
  virtual ~DeviceGas() = default;

  /// Loads the state of a gas from a checkpoint of Gas. `law`: contact law; `elastic`: true in an elastic stage,
  /// without charge exchange and drives; `stage_begin`: time since which the law applies (t0). `surface`: surface law
  /// of rough grains (Gas::surface()); null for smooth ones.
  virtual void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin = 0,
                    const SurfaceLaw* surface = nullptr) = 0;
  /// Copies the current state to host memory.
  virtual Snapshot snapshot() const = 0;
  /// Updates a checkpoint of the same gas to the current state.
  void store(Checkpoint& checkpoint) const { device::store(snapshot(), checkpoint); }
  virtual double potential_energy() = 0;
  virtual double time() const = 0;
  /// Advances the gas towards `time` (t0) by at most `most` outer steps (from one evaluation of the smooth forces to
  /// the next), or by one step if external drives (Effect::drive) act. Throws Failure if contacts are too short for the
  /// step, or if grains fly through each other. Throws Failure if positions are not finite, or if induced dipoles
  /// cannot be computed.
  virtual void step(double time, int most = 1) = 0;
  virtual StepCounts counts() const = 0;
};

/// Executor that runs the kernels of a gas: the CPU (for tests) or a CUDA device.
enum class Target { host, cuda };

/// Throws InputError for a scene with features that a device does not compute. These are conductors, two dimensions,
/// sides that are neither periodic nor walls, and unsupported integrators, effects or options of effects. `target`
/// cuda: laws without CUDA kernels are refused, too, and gases too small for several devices. `devices`: their number;
/// several move smooth grains in a periodic box, with charges that do not change.
void check_scene(const Scene& scene, Target target = Target::cuda, int devices = 1);
/// Returns an estimate of the device memory (bytes) that the gas of a scene needs, for evenly distributed grains.
/// Throws InputError for unsupported effects.
double bytes_needed(const Scene& scene);

/// Returns the number of CUDA devices. Throws InputError if there is no usable device or the program was built without
/// CUDA.
int cuda_device_count();
/// Returns the numbers of the CUDA devices that a scene selects, at least one (Scene::cuda_devices). Throws the
/// exceptions of cuda_device_count() if it selects all.
std::vector<int> chosen_devices(const Scene& scene);
/// Estimates the speed of several H200s of a host over that of one, from measurements
/// (docs/measurements/device-gas.json).
double expected_gain(std::size_t grains, int devices);
/// Makes the gas of a scene on CUDA devices with the given numbers; none: on the current one. The calling thread must
/// also make the calls of a gas on one device. Throws the exceptions of check_scene() and cuda_device_count(),
/// InputError for a device that does not exist, and Failure if a device lacks memory.
std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene, const std::vector<int>& devices = {});
/// Makes a gas that runs the algorithms of a device sequentially on the CPU, for tests. Throws the exceptions of
/// check_scene() with Target::host. `ranks`: number of devices that threads of the CPU represent.
std::unique_ptr<DeviceGas> make_host_gas(const Scene& scene, int ranks = 1);

}  // namespace lichtenberg::granular::device
