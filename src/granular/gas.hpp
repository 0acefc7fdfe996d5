#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/granular/contact_motion.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/grain_statistics.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_list.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Energy budget of a gas of grains, in m0 v0^2. The change of `total` since the start is the error of the run.
struct GasEnergy {
  double kinetic = 0;
  double contact = 0;     ///< elastic energy of contacts
  double potential = 0;   ///< of charges and dipoles, and of uniform forces
  double dissipated = 0;  ///< by contacts
  double exchanged = 0;   ///< given to the field by charges that moved between grains
  double driven = 0;      ///< given to the grains by surrounding gas and by rescaling
  /// Change of `total` by the integration of contacts; the rest is due to other forces.
  double contact_error = 0;

  double total() const { return kinetic + contact + potential + dissipated - exchanged - driven; }
};

/// Wall time (s) since this program started, by part.
struct GasSeconds {
  double contacts = 0;
  double forces = 0;    ///< smooth forces
  double lists = 0;     ///< neighbour lists
  double exchange = 0;  ///< of charge
};

/// Results that a step needs at its end: smooth forces, or these with their energy.
enum class Want { forces, energy };

/// Values that follow from the grains at one instant. Functions of Gas that change the grains and take an Instant
/// update it; after any other change a new Instant is needed.
struct Instant {
  GrainStatistics statistics;
  std::vector<double> force{};        ///< smooth forces on the grains, [N * d]; empty: not found, or there are none
  double acceleration = 0;            ///< the largest that these forces make
  std::optional<double> potential{};  ///< the energy of these forces; empty: not found
  /// Estimate of the largest speed (v0) at which a contact releases two grains; empty: not found.
  std::optional<double> release{};
  /// Bound on the change of a velocity (v0) since contacts were followed; infinite: positions may have changed, too.
  double velocity_change = INFINITY;
};

/// State of a gas: grains in a periodic box with the effects that act on them, at one instant. Integrators advance it.
class Gas {
 public:
  explicit Gas(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const Bodies& bodies() const { return model_.bodies; }
  Model& model() { return model_; }
  const Model& model() const { return model_; }
  double time() const { return time_; }
  const std::vector<GrainContact>& contacts() const { return contacts_; }
  /// Contact law of the present stage.
  const GrainContactLaw& law() const { return law_; }
  parallel::Team& team() { return *team_; }

  /// Returns the energy budget. `potential`: the potential energy, if it is known.
  GasEnergy energy(std::optional<double> potential = {});
  double fastest() const { return instant().statistics.fastest; }  ///< v0, largest speed
  double kinetic_energy() const { return instant().statistics.kinetic; }
  /// Returns the present instant, without forces.
  Instant instant() const { return {.statistics = grain_statistics(model_.bodies, *team_)}; }
  /// Returns the present instant with forces; with Want::energy it includes the energy of smooth forces.
  Instant instant(Want want);
  /// Adds forces to an instant that lacks them.
  void find_forces(Instant& now, Want want = Want::forces);
  /// Returns the smooth forces on the grains, [N * d]; empty if there are none.
  std::vector<double> smooth_forces() { return instant(Want::forces).force; }
  /// Returns a bound on impact speeds (v0): the largest relative speed that grains have or a contact may give them.
  double fastest_impact(const Instant& now) const;
  /// Returns the time (t0) that contact substeps must resolve for impact speeds up to `impact` (pace.hpp).
  double time_to_resolve(double impact) const;
  const GrainProperties& grain_properties() const { return grain_properties_; }

  /// Returns the pairs that may touch within dt. Throws Failure if grains may move too far for the box within dt.
  std::span<const Pair> candidate_pairs(double dt);
  /// Returns the contact forces; `pairs`: all candidate pairs.
  ContactLoad contact_load(std::span<const Pair> pairs);
  /// Moves each grain by `path` (d0, [N * d]) and sets the time.
  void move(std::span<const double> path, double time);
  /// Records the contacts since the time `begin` and the energy that they dissipated. Called once per step.
  void note(std::vector<StepContact> step_contacts, double begin, double dissipated);

  /// Changes momenta by dt times these forces ([N * d] or empty).
  void add_impulse(double dt, std::span<const double> force);
  bool has_smooth_forces() const;
  /// Returns the wall time (s) of one evaluation of an effect's forces, with this gas's threads.
  double seconds_of_forces(const Effect& effect);
  /// Applies Effect::drive of all effects from the time `begin` to begin + dt.
  void drive(Instant& now, double begin, double dt);
  /// Advances the grains to `end` under contact forces and the present smooth forces, in substeps that resolve the
  /// shortest contact. Momenta are then corrected for a linear change of the smooth forces. Returns the instant `end`.
  /// Throws Failure if the shortest contact is too short for the step, or if grains may move too far for the box.
  /// Throws Failure if grains fly through each other, or if positions are not finite.
  Instant follow_contacts(const Instant& now, double end, Want want = Want::forces);
  /// Exchanges charges between grains in contact, once per step.
  void exchange_charges(Instant& now);

  /// Time (t0) at which the present stage began.
  double stage_begin() const;
  /// Returns true if contacts are elastic and move no charge, in a stage that mixes the grains.
  bool in_elastic_stage() const;
  /// Time (t0) at which the present stage ends; infinite in the last one.
  double stage_end() const;
  /// Returns true if temperature and charges are continuous at the end of the stage.
  bool cools_on_after_stage() const;
  /// Begins the next stage, with another contact law and perhaps another temperature. Returns the updated instant.
  /// Throws Failure for a temperature if all grains are at rest.
  Instant leave_stage(Instant now = {});

  Checkpoint save() const;
  void restore(const Checkpoint& checkpoint);

  // Counters since the start.
  std::int64_t steps = 0, contact_steps = 0, collisions = 0;
  double largest_overlap = 0;  ///< over the sum of radii
  RestitutionCheck restitution;
  const GasSeconds& seconds() const { return seconds_; }
  /// Number of searches for candidate pairs since this program started.
  std::int64_t searches() const { return searches_ + list_.searches(); }

 private:
  ContactsFollowed advance_contacts(const Instant& now, double dt, int times, double gain);
  int contact_steps_within(const Instant& now, double dt, double gain) const;
  [[noreturn]] void refuse_travel(double dt, double fastest, double gain) const;
  void record_step(ContactRecord record);
  double potential_energy(std::optional<double> known);
  /// Returns kinetic and elastic energy.
  double mechanical_energy() const;
  State state();
  void set_law();
  void rescale(double temperature);

  Scene scene_;
  std::unique_ptr<parallel::Team> team_;
  Model model_;
  GrainContactLaw law_;
  std::unique_ptr<ContactMotion> contact_motion_;
  PairList list_;                        ///< candidate pairs of contacts
  std::optional<PairList> smooth_list_;  ///< pairs for smooth forces; empty: not needed
  std::vector<GrainContact> contacts_;   ///< in ascending order of pairs
  ContactRecord record_;
  GasEnergy budget_;  ///< dissipated, exchanged and driven energy
  GasSeconds seconds_;
  std::int64_t searches_ = 0;  ///< by contact_motion_
  GrainProperties grain_properties_;
  double time_ = 0;
  std::size_t stage_ = 0;
};

}  // namespace lichtenberg::granular
