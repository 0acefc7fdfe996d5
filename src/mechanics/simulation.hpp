#pragma once

#include <memory>

#include "solvers/laplace/problem.hpp"
#include "src/effects/groups.hpp"
#include "src/mechanics/counters.hpp"
#include "src/model/frame.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// A scene in time: from its first instant forward, with the integrator and the coupling that its [mechanics] asks for.
class Simulation {
 public:
  explicit Simulation(const Scene& scene);
  /// With a field solver of one's own.
  Simulation(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);
  ~Simulation();

  double time() const;  ///< s
  /// Carries the scene on to `time` (s; not earlier than now). Throws InputError if the first instant cannot be solved
  /// (a short circuit, say), Failure if a solver gives up or conductors short-circuit two electrodes.
  void advance_to(double time);

  /// What there is to see now. Solves the field of the first instant if nothing has yet.
  Frame frame();
  /// The potential now. Throws Failure in a neutral scene.
  laplace::Field field();
  /// Every conductor is connected to an electrode, and forces and speeds are at most stop.force times the largest of
  /// the run (D 7.1). Never true in a neutral scene.
  bool stationary();

  /// All there is. Also makes this very simulation forget what a new one could not know (the field solver's first
  /// guesses): one restored from the checkpoint goes on bit for bit as this one does.
  Checkpoint checkpoint();
  /// The same without forgetting: one restored from it goes on as this one does, but for the field solver's tolerance.
  Checkpoint snapshot();
  /// Puts the simulation where the checkpoint was made. Throws Failure if that was of another scene.
  void restore(const Checkpoint& checkpoint);

  const Counters& counters() const;
  const Model& model() const;
  /// The electrical contacts that are made now; null in a scene without contact_discharge.
  const std::vector<effects::Contact>* contacts() const;
  /// The last field problem that was solved; null unless the scene asks for an accuracy.
  const laplace::LaplaceProblem* last_problem() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg
