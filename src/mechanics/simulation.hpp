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

/// Simulation of a scene of conductors in time. Charges, field, contacts and motion follow the integrator and the
/// coupling of the scene's [mechanics].
class Simulation : public Motion {
 public:
  /// Makes the simulation at time 0, with the field solver of the scene.
  explicit Simulation(const Scene& scene);
  /// Makes the simulation at time 0 with the given field solver; null: the solver of the scene with
  /// field.moving_tolerance.
  Simulation(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);
  ~Simulation() override;

  double time() const override;
  /// Returns the time (s) of the next frame: the next multiple of output.every, or stop.time if that is earlier.
  double next_frame() const override;
  double end_time() const override;
  /// Advances the scene to `time` (s). Throws Paused if `pause` returns true between two steps. Throws InputError if
  /// the first instant cannot be solved, by a short circuit, for example. Throws Failure if a solver fails or
  /// conductors connect different prescribed potentials (a short circuit).
  void advance_to(double time, const std::function<bool()>& pause = {}) override;
  /// Returns true at stop.time, or earlier in a stationary state if stop.stationary is set.
  bool finished() override;

  /// Returns positions, velocities, charges, potentials and energies at the present instant. Solves the field of the
  /// first instant if that is not done yet.
  ConductorFrame now();
  /// Returns the present state as columns of the result file, in two or three dimensions. They include the columns of
  /// effects and, with contact_discharge, the network of contacts.
  Frame frame() override;
  std::optional<laplace::Field> field() override;
  std::string progress() override;
  /// Returns true if contacts and wires connect every conductor to a prescribed potential (electrode, side or wire),
  /// and all free conductors are nearly at rest. The force on each and its speed are then at most stop.force times the
  /// largest of the run (D 7.1). Never true in a scene without a field.
  bool stationary();

  /// Returns the complete state. Also discards earlier solutions of this simulation's field solver, as a restored
  /// simulation has none.
  Checkpoint checkpoint() override;
  /// Returns the complete state and keeps all caches. A simulation restored from it agrees with this one within the
  /// tolerance of the field solver.
  std::optional<Checkpoint> snapshot() override;
  void restore(const Checkpoint& checkpoint) override;

  /// In two dimensions with field.accuracy: estimates the error of the last solved field, and returns a warning when it
  /// first exceeds this accuracy. The solver's parameters were chosen for the positions at the start.
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
