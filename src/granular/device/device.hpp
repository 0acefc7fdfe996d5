#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/granular/device/snapshot.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular::device {

/// What steps took since the gas was loaded.
struct StepCounts {
  std::int64_t steps = 0, contact_steps = 0;
  std::int64_t lists = 0, evaluations = 0;  ///< lists made, sums over charges
  double seconds = 0, list_seconds = 0;     ///< of the wall: all of it, and that of lists
};

/// A gas of grains on a device, carried on by the steps of Multirate. What it holds goes there and comes back as a
/// checkpoint of Gas: that of a device is one of the CPU's.
class DeviceGas {
 public:
  virtual ~DeviceGas() = default;

  /// Takes the gas over. `elastic`: the scene is being mixed, no charge moves; `stage_begin`: since when this law
  /// holds.
  virtual void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin = 0) = 0;
  /// Of the gas as it is.
  virtual Snapshot snapshot() const = 0;
  /// Changes what has changed in the checkpoint that was loaded.
  void store(Checkpoint& checkpoint) const { device::store(snapshot(), checkpoint); }
  virtual double potential_energy() = 0;
  virtual double time() const = 0;
  /// Carries it on towards `time`, at most to there, by up to so many steps: what surrounds grains allows one. Throws
  /// Failure where Gas does.
  virtual void step(double time, int most = 1) = 0;
  virtual StepCounts counts() const = 0;
};

/// The kernels that a gas runs: tests run those of the host.
enum class Target { host, cuda };

/// Throws InputError, with a sentence, for a scene that has what a device does not compute.
void check_scene(const Scene& scene, Target target = Target::cuda);
/// Bytes of a device that a gas of this scene will take, by an estimate for grains evenly spread.
double bytes_needed(const Scene& scene);

/// On the first CUDA device. Throws InputError where check_scene does, or if there is no device that can be used;
/// Failure if it has not enough memory.
std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene);
/// The device's algorithms run by the CPU, item after item, for tests.
std::unique_ptr<DeviceGas> make_host_gas(const Scene& scene);

}  // namespace lichtenberg::granular::device
