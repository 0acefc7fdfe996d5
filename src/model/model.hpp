#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/model/drag.hpp"
#include "src/model/effect.hpp"
#include "src/model/requested_bodies.hpp"

namespace lichtenberg {

/// Bodies and the effects (forces, currents, drag) that act on them, with the sums over all effects. Charges and a
/// neighbour list exist only if an effect needs them.
struct Model {
  /// Makes a model of bodies and effects. `charge` (C, [N]) is copied into the bodies if an effect needs charges.
  /// Throws InputError for an effect that does not support the bodies' dimension or periodic sides, and for two effects
  /// of one name. Throws InputError if an effect needs charges and their number is not N, and for an invalid drag law
  /// (Drag::add). Throws InputError for an effect of grains with Effect::drag, which must define Effect::drive instead.
  Model(Bodies bodies, std::vector<std::unique_ptr<Effect>> effects, const std::vector<double>& charge);

  Bodies bodies;
  std::vector<std::unique_ptr<Effect>> effects;
  std::optional<NeighbourList> neighbours;
  /// Total drag of all effects; forces() includes its forces.
  Drag drag;
  /// Threads for the effects; must outlive the model.
  parallel::Team* team = &parallel::Team::single();

  /// Computes the total force of all effects on each body in its current state. `force` (N, [N * dimension]) is
  /// overwritten. With Bodies::fix_z its components along z are 0.
  void forces(double time, std::span<double> force) { forces(time, all_bodies_, force); }
  /// Computes the total force of all effects on each requested body. Elements of `force` (N, [N * dimension]) for other
  /// bodies are undefined.
  void forces(double time, RequestedBodies& requested, std::span<double> force);
  /// Computes the Jacobian matrix of the total forces on all bodies: their derivatives by positions and momenta.
  /// `jacobian` is overwritten.
  void jacobian(double time, ForceJacobian& jacobian) { this->jacobian(time, all_bodies_, jacobian); }
  /// Computes the Jacobian matrix of the total forces on the requested bodies: their derivatives by positions and
  /// momenta. `jacobian` is overwritten.
  void jacobian(double time, RequestedBodies& requested, ForceJacobian& jacobian);
  /// Computes the total current that the effects inject into each body (A, [N], overwritten). The effects get no
  /// neighbour pairs: State::neighbours is empty.
  void currents(double time, std::span<double> current);

  /// Returns the potential energy of all effects (J), the sum of Effect::stored_energy. It does not contain the energy
  /// of the field of Laplace's equation.
  double stored_energy(double time);
  /// Returns true if an effect dissipates energy apart from drag (Needs::dissipates).
  bool dissipates() const;
  /// Returns the power (W) that the effects dissipate apart from drag, the sum of Effect::dissipated_power.
  double dissipated_power(double time);
  /// Returns the kinetic energy of all bodies (J), the sum of m v^2 / 2.
  double kinetic_energy() const;

  /// Returns the charge relaxation time (s), in which all effects together reduce every charge to 1/e; infinite if no
  /// effect reduces charges.
  double charge_relaxation_time() const;

  /// Calls Effect::accept of every effect after an accepted step of length dt (s) that ends at `time`.
  void accept(double time, double dt);
  /// Adds the states of all effects to a checkpoint, as arrays "effects.NAME.ARRAY".
  void save(Checkpoint& checkpoint) const;
  /// Restores the states of all effects from a checkpoint. Throws the exceptions of Effect::restore.
  void restore(const Checkpoint& checkpoint);
  /// Adds the columns (named quantities) of all effects to a frame of the result file.
  void add_columns(double time, Frame& frame);
  /// Adds the lines of text and numbers of all effects to the summary of a run.
  void summarize(double time, Summary& summary);

  /// Returns the largest displacement (m) of a body that all effects allow in one step of an integrator
  /// (Needs::largest_move). It is infinite without bodies or if no effect limits it.
  double largest_move() const;

  /// Returns the input of the effects for the current bodies at `time`, with an updated neighbour list.
  State state(double time) { return state(time, all_bodies_); }

 private:
  void add_drag_of(std::size_t effect);
  State state(double time, RequestedBodies& requested);
  /// Returns the input of the effects without neighbour pairs, because an update of the list takes a pass over all
  /// bodies.
  State state_without_neighbours(double time) { return {time, bodies, {}, *team, all_bodies_.bodies()}; }

  /// Index of the first effect with drag; number of effects if there is none. The drag of all effects is added after
  /// the forces of this effect.
  std::size_t drag_at_;
  RequestedBodies all_bodies_;
};

}  // namespace lichtenberg
