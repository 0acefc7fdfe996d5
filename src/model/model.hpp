#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/model/asked_bodies.hpp"
#include "src/model/drag.hpp"
#include "src/model/effect.hpp"

namespace lichtenberg {

/// Bodies and the effects that act on them. Charges and a neighbour list exist only if an effect needs them.
struct Model {
  /// `charge`: C, [N]; taken over only if an effect needs charges. Throws InputError for an effect that cannot do the
  /// bodies' dimension or their box's periodic sides, for two of one name,
  /// for charges that are needed and are not one a body, and for drag of grains or below 0.
  Model(Bodies bodies, std::vector<std::unique_ptr<Effect>> effects, const std::vector<double>& charge);

  Bodies bodies;
  std::vector<std::unique_ptr<Effect>> effects;
  std::optional<NeighbourList> neighbours;
  Drag drag;  ///< of all effects; their forces are among forces()
  parallel::Team* team = &parallel::Team::single();  ///< that effects share their work among; outlives this

  /// Sum of all forces on the bodies as they are (N, [N * dimension], overwritten).
  void forces(double time, std::span<double> force) { forces(time, everybody_, force); }
  /// The same for the bodies asked for; what `force` holds of others has no meaning.
  void forces(double time, AskedBodies& asked, std::span<double> force);
  /// The derivatives of the same sum (overwritten).
  void jacobian(double time, ForceJacobian& jacobian) { this->jacobian(time, everybody_, jacobian); }
  void jacobian(double time, AskedBodies& asked, ForceJacobian& jacobian);
  /// Sum of all currents fed into the bodies (A, [N], overwritten). Effects are told no neighbours.
  void currents(double time, std::span<double> current);

  /// Sum of the energies that the effects have stored (J).
  double stored_energy(double time);
  /// Sum of m v^2 / 2 (J).
  double kinetic_energy() const;

  /// In which every charge decays to 1/e of itself (s), by all effects together; infinite if none lets it decay.
  double charge_relaxation_time() const;

  /// A step of length dt (s) to `time` stands: tells every effect, without neighbours.
  void accept(double time, double dt);
  /// The effects' own states, as arrays "effects.NAME.ARRAY".
  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);
  /// The columns that the effects show, and their lines in a summary.
  void add_columns(double time, Frame& frame);
  void summarize(double time, Summary& summary);

  /// The least of the effects' Needs::largest_move as a length (m); infinite if none sets one.
  double largest_move() const;

  /// What effects are given at this instant, with the list of neighbours brought up to date.
  State state(double time) { return state(time, everybody_); }

 private:
  void add_drag_of(std::size_t effect);
  State state(double time, AskedBodies& asked);
  /// Nobody looks for pairs: that is a pass over all bodies.
  State state_without_neighbours(double time) { return {time, bodies, {}, *team, everybody_.bodies()}; }

  std::size_t drag_at_;  ///< the first effect with drag, after whose forces all drag is added; else their number
  AskedBodies everybody_;
};

}  // namespace lichtenberg
