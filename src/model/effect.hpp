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

/// Requirements of an effect. The model allocates and computes only quantities that some effect of the scene needs.
struct Needs {
  bool charges = false;  ///< Bodies::charge
  bool field = false;    ///< Laplace's equation, and therefore a field solver
  /// m, surface to surface: State::neighbours contains all pairs up to this gap.
  std::optional<double> neighbour_range;
  /// Largest displacement of a body in one step of an integrator, in units of the smallest radius. A larger
  /// displacement could pass through an obstacle from which the effect makes bodies bounce.
  std::optional<double> largest_move;
};

/// State of the system at the instant at which an effect is evaluated.
struct State {
  double time = 0;  ///< s
  const Bodies& bodies;
  /// Empty unless an effect needs them; may contain pairs beyond the range.
  std::span<const Pair> neighbours;
  /// Threads for loops with enough work.
  parallel::Team& team = parallel::Team::single();
  /// Requested bodies, in ascending order; empty: all. If some bodies are not requested, `neighbours` holds the pairs
  /// with a requested body. Values added to the forces of other bodies are then ignored.
  std::span<const int> requested{};
};

/// Calls visit(i) for every requested body, in ascending order.
template <class Visit>
void for_each_requested(const State& state, const Visit& visit) {
  for (const int i : state.requested) visit(i);
  if (!state.requested.empty()) return;
  for (int i = 0; i < state.bodies.size(); ++i) visit(i);
}

/// Derivatives of forces by positions and momenta, as a sum of blocks, for implicit integrators. Force component k on
/// body i is row i * dimension + k. Columns count position or momentum components in the same way.
class ForceJacobian {
 public:
  struct Entry {
    int row = 0, column = 0;
    double value = 0;
  };

  explicit ForceJacobian(int dimension) : dimension_(dimension) {}
  void clear() { by_position.clear(), by_momentum.clear(); }

  /// Adds along * n n' + across * (1 - n n') to d(force on i) / d(position of j) (N/m). n is a unit vector with
  /// `dimension` components. Every force that acts along a line between two surfaces has this form.
  void add_central(int i, int j, std::span<const double> n, double along, double across);
  /// Adds `rate` (1/s) to d(force on i) / d(momentum of i), for each component.
  void add_drag(int i, double rate);
  /// Adds along * n n' + across * (1 - n n') (1/s) to d(force on i) / d(momentum of i). n is a unit vector with
  /// `dimension` components.
  void add_drag(int i, std::span<const double> n, double along, double across);

  std::vector<Entry> by_position, by_momentum;  ///< entries of the same row and column are summed

 private:
  int dimension_;
};

/// One physical effect. A run contains it only if the scene has its table. Functions that it does not override have no
/// effect.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual const EffectKind& kind() const = 0;  ///< kind that made the effect
  std::string_view name() const;               ///< name of its table in the scene
  virtual Needs needs() const { return {}; }

  /// Adds the effect's forces (N, [N * dimension]) on the requested bodies. Forces on grains must depend only on
  /// positions and charges and have a potential (stored_energy). They must change little while a grain moves by a small
  /// part of StepLimits::force_length, because they act as impulses between contact substeps.
  virtual void add_forces(const State& state, std::span<double> force) const { (void)state, (void)force; }
  /// Adds the derivatives of the forces of add_forces. Missing terms slow the iteration of an implicit integrator, but
  /// do not change its limit.
  virtual void add_jacobian(const State& state, ForceJacobian& jacobian) const { (void)state, (void)jacobian; }
  /// Returns the energy (J) that the effect's forces store reversibly, such as the energy of springs or weight. The
  /// field energy is not included.
  virtual double stored_energy(const State& state) const { return (void)state, 0; }
  /// Marks the bodies that the effect's forces may act on while each body i moves by at most travel[i] (m); both bodies
  /// of a pair are marked. By default an effect that overrides add_forces marks all bodies. Unmarked bodies are
  /// integrated separately, and the integration of the others uses their old positions. Additional marks cost time but
  /// no accuracy.
  virtual void mark_interacting(const Bodies& bodies, std::span<const double> travel,
                                std::vector<bool>& interacting) const;
  /// Returns the drag on a body, which is the same at any time and position. The model adds its force and derivative.
  /// Its heat enters the energy balance. Drag is therefore not part of add_forces, and it marks no bodies. Grains have
  /// `drive` instead.
  virtual DragLaw drag(const Bodies& bodies, int body) const { return (void)bodies, (void)body, DragLaw{}; }

  /// Adds the currents (A, [N]) that the effect injects into the bodies. `state` has no neighbours.
  virtual void add_currents(const State& state, std::span<double> current) const { (void)state, (void)current; }
  /// Returns the time (s) in which every charge decays to 1/e in the absence of other effects.
  virtual double charge_relaxation_time() const { return INFINITY; }

  // The following functions are for grains, which src/granular moves.

  /// Returns the contact law of the grains, if this effect defines it; null otherwise.
  virtual const GrainContactLaw* grain_contact() const { return nullptr; }
  /// Moves charges (reduced units, [N]) between grains in contact. `bodies` still has the charges before the exchange.
  virtual void exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) {
    (void)contacts, (void)bodies, (void)charge;
  }
  /// Changes momenta from `time` to `time` + dt by an external drive, such as a surrounding gas or weight. Returns the
  /// energy that the bodies gain; empty: no momentum has changed.
  virtual std::optional<double> drive(double time, double dt, Bodies& bodies) {
    return (void)time, (void)dt, (void)bodies, std::nullopt;
  }

  // The following functions are for effects that have a state in addition to the bodies and the options.

  /// Commits a step. It is called once for each accepted step of a run, never for a step that may be rolled back. The
  /// bodies have their positions at state.time. dt (s) earlier, they had the positions that the preceding step left.
  /// The state changed here is constant between two calls. `state` has no neighbours.
  virtual void accept(const State& state, double dt) { (void)state, (void)dt; }
  /// Saves the effect's state to a checkpoint of its own.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  /// Returns true if a call of save never changes later results.
  virtual bool saves_exactly() const { return true; }
  /// Restores the effect's state. Throws Failure for a checkpoint that is no state of the effect.
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
  /// Returns the wall time (s) of the effect's forces since the start, by part; empty if parts are not timed.
  virtual std::map<std::string, double> seconds() const { return {}; }
  /// Returns warnings for the user before the run continues, such as an exceeded error bound.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Adds the effect's columns to a frame. The recorder refuses duplicate names.
  virtual void add_columns(const State& state, Frame& frame) const { (void)state, (void)frame; }
  /// Adds the effect's lines and quantities to the summary of a run.
  virtual void summarize(const State& state, Summary& summary) const { (void)state, (void)summary; }
};

}  // namespace lichtenberg
