#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/model/drag.hpp"
#include "src/model/effect.hpp"
#include "src/model/requested_bodies.hpp"

namespace lichtenberg {

/// Bodies and the effects that act on them. Charges and a neighbour list exist only if an effect needs them.
struct Model {
  /// `charge`: C, [N]; used only if an effect needs charges. Throws InputError for an effect that does not support the
  /// bodies' dimension or their box's periodic sides, and for two effects of one name. Throws InputError unless
  /// required charges are one for each body, and for drag of grains or negative drag.
  Model(Bodies bodies, std::vector<std::unique_ptr<Effect>> effects, const std::vector<double>& charge);

  Bodies bodies;
  std::vector<std::unique_ptr<Effect>> effects;
  std::optional<NeighbourList> neighbours;
  /// Drag of all effects; forces() includes its forces.
  Drag drag;
  /// Threads for the effects; must outlive the model.
  parallel::Team* team = &parallel::Team::single();

  /// Computes the sum of all forces on the bodies in their current state (N, [N * dimension], overwritten).
  void forces(double time, std::span<double> force) { forces(time, all_bodies_, force); }
  /// Computes the forces on the requested bodies. Elements of `force` for other bodies are undefined.
  void forces(double time, RequestedBodies& requested, std::span<double> force);
  /// Computes the derivatives of the sum of all forces (overwritten).
  void jacobian(double time, ForceJacobian& jacobian) { this->jacobian(time, all_bodies_, jacobian); }
  void jacobian(double time, RequestedBodies& requested, ForceJacobian& jacobian);
  /// Computes the sum of all currents injected into the bodies (A, [N], overwritten). Effects get no neighbours.
  void currents(double time, std::span<double> current);

  /// Returns the sum of the energies that the effects store (J).
  double stored_energy(double time);
  /// Returns the sum of m v^2 / 2 (J).
  double kinetic_energy() const;

  /// Returns the time (s) in which all effects together reduce every charge to 1/e; infinite if no effect does.
  double charge_relaxation_time() const;

  /// Commits a step of length dt (s) to `time` in every effect, without neighbours.
  void accept(double time, double dt);
  /// Saves the effects' states as arrays "effects.NAME.ARRAY".
  void save(Checkpoint& checkpoint) const;
  /// Restores the effects' states. Throws the exceptions of Effect::restore.
  void restore(const Checkpoint& checkpoint);
  /// Adds the effects' columns to a frame.
  void add_columns(double time, Frame& frame);
  /// Adds the effects' lines and quantities to a summary.
  void summarize(double time, Summary& summary);

  /// Returns the smallest of the effects' Needs::largest_move as a length (m); infinite if no effect sets one.
  double largest_move() const;

  /// Returns the input of the effects at this instant, with an updated neighbour list.
  State state(double time) { return state(time, all_bodies_); }

 private:
  void add_drag_of(std::size_t effect);
  State state(double time, RequestedBodies& requested);
  /// Returns the input of the effects, without neighbours. Their search would take a pass over all bodies.
  State state_without_neighbours(double time) { return {time, bodies, {}, *team, all_bodies_.bodies()}; }

  /// First effect with drag, after whose forces all drag is added; number of effects if there is none.
  std::size_t drag_at_;
  RequestedBodies all_bodies_;
};

}  // namespace lichtenberg
