#pragma once

#include <memory>

#include "solvers/laplace/problem.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/groups.hpp"
#include "src/mechanics/counters.hpp"
#include "src/model/model.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// A scene in time: from its first instant forward, with the integrator and the coupling that its [mechanics] asks for.
class Simulation : public Motion {
 public:
  explicit Simulation(const Scene& scene);
  /// With a field solver of one's own.
  Simulation(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);
  ~Simulation() override;

  double time() const override;
  /// A multiple of output.every, or stop.time.
  double next_frame() const override;
  double end_time() const override;
  /// Throws Paused where it is told to pause, InputError if the first instant cannot be solved (a short circuit, say),
  /// Failure if a solver gives up or conductors short-circuit two electrodes.
  void advance_to(double time, const std::function<bool()>& pause = {}) override;
  /// stop.time is reached, or the scene is to stop when stationary and is.
  bool finished() override;

  /// What there is to see now. Solves the field of the first instant if nothing has yet.
  ConductorFrame now();
  /// What there is to see now as columns, in two dimensions and in three, with the network of the contacts and what the
  /// effects show.
  Frame frame() override;
  std::optional<laplace::Field> field() override;
  std::string progress() override;
  /// Every conductor is connected to an electrode, and forces and speeds are at most stop.force times the largest of
  /// the run (D 7.1). Never true in a neutral scene.
  bool stationary();

  /// Makes this very simulation forget what a new one could not know: the field solver's first guesses.
  Checkpoint checkpoint() override;
  /// One restored from it goes on as this one does, but for the field solver's tolerance.
  std::optional<Checkpoint> snapshot() override;
  void restore(const Checkpoint& checkpoint) override;

  /// The field's error, chosen for the start, may have grown as conductors moved.
  std::vector<std::string> warnings() override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;

  const Counters& counters() const;
  const Model& model() const;
  /// The electrical contacts that are made, in ascending order.
  std::vector<effects::Contact> contacts() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg
