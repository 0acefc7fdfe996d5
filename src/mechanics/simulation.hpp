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

/// Motion of a scene of conductors from its first instant, with the integrator and the coupling of its [mechanics].
class Simulation : public Motion {
 public:
  explicit Simulation(const Scene& scene);
  /// Uses this field solver instead of the scene's.
  Simulation(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);
  ~Simulation() override;

  double time() const override;
  /// Returns a multiple of output.every, or stop.time (s).
  double next_frame() const override;
  double end_time() const override;
  /// Throws Paused if `pause` returns true, InputError if the first instant cannot be solved (by a short circuit, for
  /// example), Failure if a solver fails or conductors short-circuit two electrodes.
  void advance_to(double time, const std::function<bool()>& pause = {}) override;
  /// Returns true at stop.time, or if the scene stops when it is stationary and it is.
  bool finished() override;

  /// Returns the present state. Solves the field of the first instant if that is not done yet.
  ConductorFrame now();
  /// Returns the present state as columns, in two or three dimensions, with the network of contacts and the columns of
  /// effects.
  Frame frame() override;
  std::optional<laplace::Field> field() override;
  std::string progress() override;
  /// Returns true if every conductor is connected with an electrode, and forces and speeds are at most stop.force times
  /// the largest of the run (D 7.1). Never true in a neutral scene.
  bool stationary();

  /// Also resets this simulation to the state of a restored one: the initial guesses of the field solver are dropped.
  Checkpoint checkpoint() override;
  /// Returns a checkpoint that discards nothing. A simulation that is restored from it continues as this one, except
  /// for errors within the field solver's tolerance.
  std::optional<Checkpoint> snapshot() override;
  void restore(const Checkpoint& checkpoint) override;

  /// Warns if the field's error, chosen for the start, has grown as conductors moved.
  std::vector<std::string> warnings() override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;

  const Counters& counters() const;
  const Model& model() const;
  /// Returns the present electrical contacts, in ascending order.
  std::vector<effects::Contact> contacts() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg
