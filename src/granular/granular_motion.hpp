#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace granular::device {
class DeviceGas;
}

/// Simulation of a scene of grains in time, in reduced units (Scene::reference), with the integrator of the scene's
/// [mechanics]. It provides frames, checkpoints and a time series of observables.
class GranularMotion : public Motion {
 public:
  /// Makes the simulation of a scene on the CPU.
  explicit GranularMotion(const Scene& scene);
  /// Makes the simulation of a scene whose steps run on `device` (null: CPU). Frames and checkpoints copy the gas back
  /// from the device.
  GranularMotion(const Scene& scene, std::unique_ptr<granular::device::DeviceGas> device);
  ~GranularMotion() override;

  double time() const override;
  std::string time_unit() const override { return "t0"; }
  double next_frame() const override;
  double end_time() const override;
  void advance_to(double time, const std::function<bool()>& pause) override;
  bool finished() override;
  bool exact_anywhere() const override;

  Frame frame() override;
  std::function<Frame()> frame_later() override;
  std::string progress() override;

  Checkpoint checkpoint() override;
  void restore(const Checkpoint& checkpoint) override;

  std::vector<std::string> warnings() override;
  ColumnGroup take_history() override;
  std::function<SavedState()> saved_state_later() override;
  bool leaves_a_core() const override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;
  /// Returns the number of searches for candidate pairs (pairs that may touch) on the CPU.
  std::int64_t searches() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg
