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
struct SurfaceLaw;

/// Data that an effect requires from the model. The model allocates and computes only quantities that some effect of
/// the scene requires.
struct Needs {
  bool charges = false;  ///< true: Bodies::charge must have a charge for each body
  bool field = false;    ///< true: the scene needs a solution of Laplace's equation
  /// Largest gap between surfaces (m) of the pairs that State::neighbours must contain; empty: no pairs.
  std::optional<double> neighbour_range;
  /// Largest allowed displacement of a body in one step of an integrator, in units of the smallest radius; empty: no
  /// limit. A larger displacement could carry a body through an obstacle that should repel it.
  std::optional<double> largest_move;
  bool dissipates = false;  ///< true: forces that dissipate energy, Effect::dissipated_power()
};

/// Input of an effect at one instant: time, bodies, neighbour pairs and threads.
struct State {
  double time = 0;  ///< s
  const Bodies& bodies;
  /// Pairs of neighbouring bodies; empty unless an effect needs them. Pairs beyond the effect's range may be included.
  std::span<const Pair> neighbours;
  /// Threads for loops with enough work.
  parallel::Team& team = parallel::Team::single();
  /// Requested bodies, in ascending order; empty: all. If some bodies are not requested, `neighbours` holds the pairs
  /// with a requested body. Values added to the forces of other bodies are then ignored.
  std::span<const int> requested{};
};

/// Calls visit(i) for every requested body i in ascending order. Requested are the bodies of State::requested, whose
/// forces are needed, or all bodies if it is empty.
template <class Visit>
void for_each_requested(const State& state, const Visit& visit) {
  for (const int i : state.requested) visit(i);
  if (!state.requested.empty()) return;
  for (int i = 0; i < state.bodies.size(); ++i) visit(i);
}

/// Sparse Jacobian matrix: derivatives of forces by positions and by momenta, for implicit integrators. Component k of
/// the force on body i is row i * dimension + k. Columns count components of positions or momenta in the same way.
class ForceJacobian {
 public:
  /// One matrix entry.
  struct Entry {
    int row = 0, column = 0;
    double value = 0;
  };

  explicit ForceJacobian(int dimension) : dimension_(dimension) {}
  void clear() { by_position.clear(), by_momentum.clear(); }

  /// Adds the block along * n n' + across * (1 - n n') (N/m) to the derivative of the force on body i by the position
  /// of body j. n is a unit vector with `dimension` components. A central force along n has this form.
  void add_central(int i, int j, std::span<const double> n, double along, double across);
  /// Adds `rate` (1/s; negative for linear drag) to the derivative of each component of the force on body i by the same
  /// component of its momentum.
  void add_drag(int i, double rate);
  /// Adds the block along * n n' + across * (1 - n n') to the derivative of the force on body i by its momentum.
  /// `along` and `across` (1/s) are negative for drag. n is the direction of the velocity, a unit vector with
  /// `dimension` components.
  void add_drag(int i, std::span<const double> n, double along, double across);

  std::vector<Entry> by_position, by_momentum;  ///< entries of the same row and column are summed

 private:
  int dimension_;
};

/// Interface of one physical effect, such as a force, a current source or a contact law. A run contains the effect only
/// if the scene has its table [effects.NAME]. Functions that a class does not override change no result.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual const EffectKind& kind() const = 0;  ///< description of the effect: keys, requirements, factory
  std::string_view name() const;               ///< name of the effect's table in the scene
  virtual Needs needs() const { return {}; }

  /// Adds the effect's forces on the requested bodies to `force` (N, [N * dimension]). Forces on grains must depend
  /// only on positions and charges and have a potential (stored_energy). They must change little while a grain moves by
  /// a small part of StepLimits::force_length, because they may be constant over several contact substeps.
  virtual void add_forces(const State& state, std::span<double> force) const { (void)state, (void)force; }
  /// Adds the derivatives of the forces of add_forces() by positions and momenta. Missing terms slow the Newton
  /// iteration of an implicit integrator, but do not change its limit.
  virtual void add_jacobian(const State& state, ForceJacobian& jacobian) const { (void)state, (void)jacobian; }
  /// Returns the potential energy (J) of the effect's forces, such as that of springs, of weight, or of the charges of
  /// grains. The energy of the electric field of conductors is not included.
  virtual double stored_energy(const State& state) const { return (void)state, 0; }
  /// Returns the power (W) that the effect's forces dissipate, apart from drag; only with Needs::dissipates.
  virtual double dissipated_power(const State& state) const { return (void)state, 0; }
  /// Sets interacting[i] of each body on which the effect's forces may act while each body k moves by at most travel[k]
  /// (m). Both bodies of a pair are marked. By default an effect that overrides add_forces marks all bodies. Unmarked
  /// bodies are integrated separately, and forces on marked bodies are computed with old positions of the unmarked
  /// ones. Additional marks cost time but no accuracy.
  virtual void mark_interacting(const Bodies& bodies, std::span<const double> travel,
                                std::vector<bool>& interacting) const;
  /// Returns the drag law of a body, which must not depend on time, velocity or the present position; a drag that
  /// varies with the position is DragLaw::by_position. The model adds the drag force and its derivative, and counts its
  /// heat in the energy balance. add_forces() and mark_interacting() must leave drag out. An effect of grains overrides
  /// drive() instead.
  virtual DragLaw drag(const Bodies& bodies, int body) const { return (void)bodies, (void)body, DragLaw{}; }

  /// Adds the currents that the effect injects into the bodies to `current` (A, [N]). State::neighbours is empty.
  virtual void add_currents(const State& state, std::span<double> current) const { (void)state, (void)current; }
  /// Returns the charge relaxation time (s), in which this effect alone reduces every charge to 1/e; by default
  /// infinite.
  virtual double charge_relaxation_time() const { return INFINITY; }

  // The following functions are for grains, which src/granular moves.

  /// Returns the contact law of the grains, if this effect defines it; null otherwise.
  virtual const GrainContactLaw* grain_contact() const { return nullptr; }
  /// Sets the parts of the surface law of grains (friction, adhesion, walls) that this effect defines.
  virtual void set_surface(SurfaceLaw& law) const { (void)law; }
  /// Transfers charge between grains in contact by changing `charge` (reduced units, [N]). `bodies` still has the
  /// charges before the exchange.
  virtual void exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) {
    (void)contacts, (void)bodies, (void)charge;
  }
  /// Changes the momenta of the grains from `time` to `time` + dt by an external drive, such as a surrounding gas or
  /// weight. Returns the energy that the grains gain (reduced units); empty: no momentum has changed.
  virtual std::optional<double> drive(double time, double dt, Bodies& bodies) {
    return (void)time, (void)dt, (void)bodies, std::nullopt;
  }

  // The following functions are for effects that have a state in addition to the bodies and the options.

  /// Updates the effect's own state after a step of length dt (s) that ends at state.time. The function is called once
  /// for each accepted step of conductors, never for a step that may be rolled back. The bodies have their positions at
  /// the end of the step, and State::neighbours is empty. Between two calls the state changed here must be constant.
  virtual void accept(const State& state, double dt) { (void)state, (void)dt; }
  /// Adds the effect's own state to a checkpoint that holds no other data.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  /// Returns true if save() never changes later results. It may change them if it discards cached data.
  virtual bool saves_exactly() const { return true; }
  /// Restores the effect's own state from a checkpoint of save(). Throws Failure if the checkpoint does not fit.
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
  /// Returns the wall time (s) of the effect's force computations, by named part of the computation; empty if it is not
  /// timed.
  virtual std::map<std::string, double> seconds() const { return {}; }
  /// Returns warnings for the user before the run continues, such as an exceeded error bound.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Adds the effect's columns (named quantities) to a frame of the result file. The recorder refuses duplicate names.
  virtual void add_columns(const State& state, Frame& frame) const { (void)state, (void)frame; }
  /// Adds the effect's lines of text and numbers to the summary of a run.
  virtual void summarize(const State& state, Summary& summary) const { (void)state, (void)summary; }
};

}  // namespace lichtenberg
