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
#include "src/granular/rough_motion.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Energy budget of a gas of grains, in m0 v0^2. total() is conserved except for numerical errors, so its change since
/// the start is the energy error of the run.
struct GasEnergy {
  double kinetic = 0;
  std::optional<double> rotational{};  ///< kinetic energy of rotation; empty: grains do not rotate
  double contact = 0;                  ///< elastic and adhesive energy of contacts
  double potential = 0;                ///< potential energy of all effects, such as that of charges and dipoles
  double dissipated = 0;               ///< energy dissipated by contacts since the start
  double exchanged = 0;                ///< energy that charge exchange has given to the electric field since the start
  double driven = 0;  ///< energy that Effect::drive and changes of stages have given to the grains since the start
  /// Part of the change of total() that the time integration of contacts causes; 0 if the integrator does not compute
  /// it.
  double contact_error = 0;

  double total() const {
    return kinetic + rotational.value_or(0) + contact + potential + dissipated - exchanged - driven;
  }
};

/// Wall time (s) of the parts of a step, since this process started.
struct GasSeconds {
  double contacts = 0;
  double forces = 0;    ///< smooth forces
  double lists = 0;     ///< neighbour lists
  double exchange = 0;  ///< of charge
};

/// Result that is required at the end of a step: smooth forces (all forces except contacts) only, or smooth forces and
/// their potential energy.
enum class Want { forces, energy };

/// Quantities computed from the grains of a gas at one instant, kept for reuse, in reduced units. Functions of Gas that
/// change the grains and take an Instant update it or return a new one. After any other change a new Instant is needed.
struct Instant {
  GrainStatistics statistics;
  /// Smooth forces (all forces except contacts) on the grains, [N * d]; empty: not computed, or there are none
  std::vector<double> force{};
  double acceleration = 0;            ///< largest acceleration of a grain by these forces
  std::optional<double> potential{};  ///< potential energy of these forces; empty: not computed
  /// Largest relative speed (v0) that the elastic energy of a contact can give its grains; empty: not computed.
  std::optional<double> release{};
  /// Bound on the change of a velocity (v0) since the last follow_contacts(); infinite: positions may have changed,
  /// too.
  double velocity_change = INFINITY;
};

/// State of a gas of grains at one instant: grains in a periodic box, their contacts, the effects that act on them, and
/// the energy budget. Integrators (GasIntegrator) advance it. Reduced units.
class Gas {
 public:
  explicit Gas(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const Bodies& bodies() const { return model_.bodies; }
  Model& model() { return model_; }
  const Model& model() const { return model_; }
  double time() const { return time_; }
  const std::vector<GrainContact>& contacts() const { return contacts_; }
  /// Returns the contact law of the current stage of equilibration; after the last stage it is that of the scene.
  const GrainContactLaw& law() const { return law_; }
  /// Returns the surface law of the current stage of equilibration; null for smooth grains.
  const SurfaceLaw* surface() const { return rough_ ? &rough_->surface() : nullptr; }
  parallel::Team& team() { return *team_; }

  /// Returns the energy budget of the gas. `potential`: the potential energy (m0 v0^2) if it is known; otherwise it is
  /// computed.
  GasEnergy energy(std::optional<double> potential = {});
  double fastest() const { return instant().statistics.fastest; }         ///< largest speed of a grain (v0)
  double kinetic_energy() const { return instant().statistics.kinetic; }  ///< m0 v0^2
  /// Returns kinetic energy and largest speed of the grains at this instant, without forces.
  Instant instant() const { return {.statistics = grain_statistics(model_.bodies, *team_)}; }
  /// Returns kinetic energy, largest speed and smooth forces (all forces except contacts) at this instant. Want::energy
  /// adds the potential energy, if there are smooth forces.
  Instant instant(Want want);
  /// Computes the smooth forces (all forces except contacts) in `now`, and with Want::energy their potential energy, if
  /// `now` has no forces.
  void find_forces(Instant& now, Want want = Want::forces);
  /// Returns the smooth forces (all forces except contacts) on the grains, [N * d]; empty if there are none.
  std::vector<double> smooth_forces() { return instant(Want::forces).force; }
  /// Estimates the largest impact speed (v0). It is the larger of two speeds: twice the largest speed of a grain, and
  /// the largest relative speed that the elastic energy of a contact can give its grains.
  double fastest_impact(const Instant& now) const;
  /// Returns the largest speed (v0) of a grain. Without smooth forces it is at least half of the speed that a contact's
  /// elastic energy can give its grains. These may be at rest, and a step may last longer than the contact.
  double speed_to_follow(const Instant& now) const;
  /// Returns the time (t0) that contact substeps must resolve for impact speeds up to `impact` (v0): the shortest
  /// contact duration, or the damping time of typical impacts if that is shorter.
  double time_to_resolve(double impact) const;
  const GrainProperties& grain_properties() const { return grain_properties_; }

  /// Returns, from a neighbour list, the candidate pairs: all pairs that may touch within a time dt (t0) at the present
  /// speeds, and some others. Throws Failure if grains may move too far for the box within dt.
  std::span<const Pair> candidate_pairs(double dt);
  /// Returns the contact forces and the power that contacts dissipate. `pairs`: all candidate pairs.
  ContactLoad contact_load(std::span<const Pair> pairs);
  /// Moves each grain by `path` (d0, [N * d]), wraps it into the box, and sets the time.
  void move(std::span<const double> path, double time);
  /// Records the contacts from the time `begin` to the current time, and the energy that they dissipated. Integrators
  /// that do not use follow_contacts() call it after each step or part of a step.
  void note(std::vector<StepContact> step_contacts, double begin, double dissipated);

  /// Adds dt * force to the momenta; `force`: [N * d] or empty.
  void add_impulse(double dt, std::span<const double> force);
  /// Returns true if an effect of the scene computes forces other than contact forces.
  bool has_smooth_forces() const;
  /// Measures the wall time (s) of one evaluation of an effect's forces, with the threads of this gas.
  double seconds_of_forces(const Effect& effect);
  /// Applies Effect::drive (external drives, such as a surrounding gas) of all effects to the momenta, from the time
  /// `begin` to begin + dt. It has no effect in an elastic stage.
  void drive(Instant& now, double begin, double dt);
  /// Advances the grains to the time `end` under contact forces and constant smooth forces, in substeps that resolve
  /// the shortest contact. Then it corrects momenta for a linear change of the smooth forces, and returns the
  /// quantities at `end`. `now`: quantities at the start, with smooth forces.
  ///
  /// Throws Failure if the shortest contact is too short for the step, or if grains may move too far for the box.
  /// Throws Failure if grains fly through each other, or if positions are not finite.
  Instant follow_contacts(const Instant& now, double end, Want want = Want::forces);
  /// Exchanges charge between grains by all effects (Effect::exchange_charges), for the contacts of the last recorded
  /// step. Forces in `now` are computed again if charges have changed. It has no effect in an elastic stage.
  void exchange_charges(Instant& now);

  /// Returns the time (t0) at which the current stage of equilibration began, or at which the last stage ended; 0
  /// without stages.
  double stage_begin() const;
  /// Returns true in an elastic stage of equilibration, in which contacts dissipate no energy and exchange no charge.
  bool in_elastic_stage() const;
  /// Returns the time (t0) at which the current stage of equilibration ends; infinite after the last stage.
  double stage_end() const;
  /// Returns true in a stage of equilibration after which the gas continues to cool: the stage is not elastic, and no
  /// temperature is set at its end.
  bool cools_on_after_stage() const;
  /// Ends the current stage of equilibration and sets the next contact law. Rescales the velocities if the stage
  /// prescribes a temperature. Returns `now` with updated statistics. Throws Failure if velocities must be rescaled and
  /// all grains are at rest.
  Instant leave_stage(Instant now = {});

  Checkpoint save() const;
  void restore(const Checkpoint& checkpoint);

  // Counters since the start.
  std::int64_t steps = 0, contact_steps = 0, collisions = 0;
  double largest_overlap = 0;  ///< largest ratio of overlap to sum of radii
  RestitutionCheck restitution;
  const GasSeconds& seconds() const { return seconds_; }
  /// Returns the number of searches for candidate pairs (pairs that may touch) since this process started.
  std::int64_t searches() const { return searches_ + list_.searches(); }

 private:
  /// Advances the grains by dt in `times` contact substeps; `gain`: bound on velocity changes by smooth forces (v0).
  ContactsFollowed advance_contacts(const Instant& now, double dt, int times, double gain);
  /// Returns the number of contact substeps for a step of length dt; `gain`: bound on velocity changes by smooth forces
  /// (v0). Throws Failure if contacts are too short.
  int contact_steps_within(const Instant& now, double dt, double gain) const;
  /// Throws Failure because a grain may move too far for the box within dt.
  [[noreturn]] void refuse_travel(double dt, double fastest, double gain) const;
  /// Adds the contact events of a completed step to the counters and the energy budget.
  void record_step(ContactRecord record);
  double potential_energy(std::optional<double> known);
  /// Returns elastic and adhesive energy of contacts (m0 v0^2).
  double contact_energy() const;
  /// Returns kinetic energy plus elastic energy of contacts (m0 v0^2).
  double mechanical_energy() const;
  State state();
  /// Sets the contact law of the current stage of equilibration; after the last stage, that of the scene.
  void set_law();
  /// Scales all momenta to a temperature (m0 v0^2). Throws Failure if all grains are at rest.
  void rescale(double temperature);

  Scene scene_;
  std::unique_ptr<parallel::Team> team_;
  Model model_;
  GrainContactLaw law_;
  std::unique_ptr<ContactMotion> contact_motion_;
  RoughMotion* rough_ = nullptr;         ///< contact_motion_ if the scene has surface forces; null otherwise
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
