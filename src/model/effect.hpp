#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/drag.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg {

struct Checkpoint;
struct ContactRecord;
struct EffectKind;
struct Frame;
struct GrainContactLaw;
struct Summary;

/// What an effect must be given. Only what some effect of the scene needs is allocated and computed.
struct Needs {
  bool charges = false;                   ///< Bodies::charge
  bool field = false;                     ///< Laplace's equation, and with it a field solver
  std::optional<double> neighbour_range;  ///< m, surface to surface: State::neighbours up to this gap
  /// How far a body may move in one step of an integrator, in units of the smallest radius; farther, and it could pass
  /// through what the effect would have it bounce off.
  std::optional<double> largest_move;
};

/// The instant at which an effect is asked for its share.
struct State {
  double time = 0;  ///< s
  const Bodies& bodies;
  std::span<const Pair> neighbours;  ///< empty unless an effect needs them; may hold pairs beyond the range
  parallel::Team& team = parallel::Team::single();  ///< for loops that are worth sharing
  /// The bodies whose forces are asked for, in ascending order; empty: all. If not all, neighbours are the pairs that
  /// one of them is in, and what is added to the forces of others has no meaning.
  std::span<const int> asked{};
};

/// Calls visit(i) for every body whose force is asked for, in ascending order.
template <class Visit>
void for_each_asked(const State& state, const Visit& visit) {
  for (const int i : state.asked) visit(i);
  if (!state.asked.empty()) return;
  for (int i = 0; i < state.bodies.size(); ++i) visit(i);
}

/// How forces change with positions and momenta, as a sum of blocks, for implicit integrators. Force component k on
/// body i is row i * dimension + k; columns count position or momentum components in the same way.
class ForceJacobian {
 public:
  struct Entry {
    int row = 0, column = 0;
    double value = 0;
  };

  explicit ForceJacobian(int dimension) : dimension_(dimension) {}
  void clear() { by_position.clear(), by_momentum.clear(); }

  /// Adds along * n n' + across * (1 - n n') to d(force on i) / d(position of j) (N/m); n is a unit vector with
  /// `dimension` components. Every force that acts along a line between two surfaces has this form.
  void add_central(int i, int j, std::span<const double> n, double along, double across);
  /// Adds `rate` (1/s) to d(force on i) / d(momentum of i), the same for each component.
  void add_drag(int i, double rate);
  /// Adds along * n n' + across * (1 - n n') (1/s) to the same; n is a unit vector with `dimension` components.
  void add_drag(int i, std::span<const double> n, double along, double across);

  std::vector<Entry> by_position, by_momentum;  ///< entries of one place add up

 private:
  int dimension_;
};

/// One kind of physics. It is in a run only if its table stands in the scene. What is left at its default changes
/// nothing.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual const EffectKind& kind() const = 0;  ///< the one that made it
  std::string_view name() const;               ///< of its table in the scene
  virtual Needs needs() const { return {}; }

  /// Adds its forces (N, [N * dimension]) on the bodies asked for. Forces on grains follow from positions and charges
  /// alone, have a potential (stored_energy), and change little while a grain moves by a small part of
  /// StepLimits::force_length: they act as impulses between the steps in which contacts are followed.
  virtual void add_forces(const State& state, std::span<double> force) const { (void)state, (void)force; }
  /// Adds the derivatives of what add_forces adds. What is left out slows an implicit integrator's iteration down, but
  /// does not change where it converges to.
  virtual void add_jacobian(const State& state, ForceJacobian& jacobian) const { (void)state, (void)jacobian; }
  /// The energy (J) that its forces have stored and give back: that of springs, of weight. The field's is not among
  /// them.
  virtual double stored_energy(const State& state) const { return (void)state, 0; }
  /// For an effect that overrides add_forces: marks the bodies that it may push while each body i moves by at most
  /// travel[i] (m), both partners of a pair: a body that no effect marks flies beside the integration of the others,
  /// which see it where it was. More than need be may cost time, but no accuracy.
  virtual void mark_pushed(const Bodies& bodies, std::span<const double> travel, std::vector<bool>& pushed) const {
    (void)bodies, (void)travel, pushed.assign(pushed.size(), true);
  }
  /// Drag on a body, the same at any time and position. The model adds its force and derivative; its heat enters the
  /// energy balance. So drag is no part of add_forces, and marks nobody as pushed. Grains have `drive` instead.
  virtual DragLaw drag(const Bodies& bodies, int body) const { return (void)bodies, (void)body, DragLaw{}; }

  /// Adds the currents (A, [N]) that it feeds into the bodies; `state` has no neighbours.
  virtual void add_currents(const State& state, std::span<double> current) const { (void)state, (void)current; }
  /// The time (s) in which every charge decays to 1/e of itself, if nothing else happens to it.
  virtual double charge_relaxation_time() const { return INFINITY; }

  // What follows is for grains, which src/granular moves.

  /// The law of their contacts, of the effect that makes them; null of all others.
  virtual const GrainContactLaw* grain_contact() const { return nullptr; }
  /// Moves charges (reduced units, [N]) between grains in contact. The bodies still have the charges of before.
  virtual void exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) {
    (void)contacts, (void)bodies, (void)charge;
  }
  /// Changes momenta as a gas around the grains does from `time` on within dt; returns the energy that it gave them.
  /// Empty: nothing does, and no momentum has changed.
  virtual std::optional<double> drive(double time, double dt, Bodies& bodies) {
    return (void)time, (void)dt, (void)bodies, std::nullopt;
  }

  // What follows is for an effect with a state of its own, beyond the bodies and its options.

  /// Called once for each step of a run that stands, never for one that may be taken back: the bodies are where they
  /// are at state.time, and were dt (s) earlier where the step before left them. What changes here is the same in
  /// between. `state` has no neighbours.
  virtual void accept(const State& state, double dt) { (void)state, (void)dt; }
  /// Puts its state into a checkpoint of its own, and takes it from there. Throws Failure for what is no state of it.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  /// Whether save changes nothing of what follows, whenever it is called.
  virtual bool saves_exactly() const { return true; }
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
  /// Wall time (s) that its forces have taken since the start, by part, if it tells parts apart.
  virtual std::map<std::string, double> seconds() const { return {}; }
  /// What the user should know before the run goes on: a promise that is not kept.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Adds the columns that it shows in a frame. The recorder refuses a name that another column has.
  virtual void add_columns(const State& state, Frame& frame) const { (void)state, (void)frame; }
  /// Adds what it has to say to the summary of a run.
  virtual void summarize(const State& state, Summary& summary) const { (void)state, (void)summary; }
};

}  // namespace lichtenberg
