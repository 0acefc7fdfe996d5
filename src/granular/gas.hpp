#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/granular/contact_motion.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_list.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/granular/survey.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Where the energy of a gas of grains is, and where it went. What `total` has lost since the start is the error of
/// the run. In units of m0 v0^2.
struct GasEnergy {
  double kinetic = 0;
  double contact = 0;     ///< stored in contacts
  double potential = 0;   ///< of charges and dipoles, and of uniform forces
  double dissipated = 0;  ///< by contacts
  double exchanged = 0;   ///< given to the field by charges that moved between grains
  double driven = 0;      ///< given to the grains by the gas around them and by rescaling
  /// What `total` has changed by while contacts were followed by themselves; other forces did the rest.
  double contact_error = 0;

  double total() const { return kinetic + contact + potential + dissipated - exchanged - driven; }
};

/// Wall time (s) since this program started, by what it was spent on.
struct GasSeconds {
  double contacts = 0;
  double forces = 0;    ///< of charges, and all else that is smooth
  double lists = 0;     ///< of neighbours
  double exchange = 0;  ///< of charge
};

/// Results that a step needs at its end: smooth forces, or these with their energy.
enum class Want { forces, energy };

/// Values that follow from the grains at one instant. Functions of Gas that change the grains and take an Instant keep
/// it true; after any other change a new one is needed.
struct Instant {
  Survey survey;
  std::vector<double> force{};        ///< smooth forces on the grains, [N * d]; empty: not found, or there are none
  double acceleration = 0;            ///< the largest that these forces make
  std::optional<double> potential{};  ///< the energy of these forces; empty: not found
  /// Estimate of the largest speed (v0) at which a contact releases two grains; empty: not found.
  std::optional<double> release{};
  /// Bound on the change of a velocity (v0) since contacts were followed; infinite: positions may have changed, too.
  double kicked = INFINITY;
};

/// Grains in a periodic box with all that acts on them, at one instant: what an integrator carries on.
class Gas {
 public:
  explicit Gas(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const Bodies& bodies() const { return model_.bodies; }
  Model& model() { return model_; }
  const Model& model() const { return model_; }
  double time() const { return time_; }
  const std::vector<GrainContact>& contacts() const { return contacts_; }
  /// The law of contacts in the stage that the scene is in.
  const GrainContactLaw& law() const { return law_; }
  parallel::Team& team() { return *team_; }

  /// The energy as it is, with what has been booked so far. `potential`: what is known of it already.
  GasEnergy energy(std::optional<double> potential = {});
  double fastest() const { return look().survey.fastest; }  ///< the largest speed
  double kinetic_energy() const { return look().survey.kinetic; }
  /// The grains as they are, without their forces; the second with them.
  Instant look() const { return {.survey = survey(model_.bodies, *team_)}; }
  Instant look(Want want);
  /// Adds forces to an instant that lacks them.
  void find_forces(Instant& now, Want want = Want::forces);
  /// The smooth forces on the grains as they are, [N * d]; empty if there are none.
  std::vector<double> smooth_forces() { return look(Want::forces).force; }
  /// The largest relative speed that two grains may have, or that a contact may still give to its two.
  double fastest_impact(const Instant& now) const;
  /// Time (t0) that steps of contacts must resolve where two grains meet at that speed at most (pace.hpp).
  double time_to_resolve(double impact) const;
  const GrainsSeen& grains_seen() const { return grains_seen_; }

  /// The pairs that may touch within dt.
  std::span<const Pair> near(double dt);
  /// What contacts do to the grains as they are; `pairs`: all that may touch.
  ContactLoad contact_load(std::span<const Pair> pairs);
  /// Moves each grain by so much, [N * d]; it is then `time`.
  void move(std::span<const double> path, double time);
  /// Writes down what contacts did since `begin` and what they dissipated. Each step does so once.
  void note(std::vector<Touch> touches, double begin, double dissipated);

  /// Changes momenta by dt times these forces, [N * d] or none.
  void push(double dt, std::span<const double> force);
  bool has_smooth_forces() const;
  /// Wall time (s) that the forces of an effect take once, with this gas's threads.
  double seconds_of_forces(const Effect& effect);
  /// What surrounds the grains acts on them from `begin` on for dt.
  void drive(Instant& now, double begin, double dt);
  /// Contacts, and the smooth forces as they are now, move the grains until `end`, in steps that resolve the shortest
  /// contact; then momenta change as if smooth forces had changed linearly in time. Returns that instant.
  Instant follow_contacts(const Instant& now, double end, Want want = Want::forces);
  /// What happens once a step: charges move between grains that are in contact, and all that counts contacts does so.
  void settle_contacts(Instant& now);

  /// When the current stage began.
  double stage_begin() const;
  /// Whether contacts lose nothing and move no charge, because the scene is still being mixed.
  bool in_elastic_stage() const;
  /// The time at which the current stage ends; infinite in the last.
  double stage_end() const;
  /// Whether, when the stage ends, temperature and charges go on as they are.
  bool cools_on_after_stage() const;
  /// Goes on to the next stage: another law of contact, perhaps another temperature. Returns `now` as it is then.
  Instant leave_stage(Instant now = {});

  Checkpoint save() const;
  void restore(const Checkpoint& checkpoint);

  // What has been counted since the start.
  std::int64_t steps = 0, contact_steps = 0, collisions = 0;
  double largest_overlap = 0;  ///< over the sum of radii
  RestitutionCheck restitution;
  const GasSeconds& seconds() const { return seconds_; }
  /// How often it has been looked for pairs that may touch, since this program started.
  std::int64_t searches() const { return searches_ + list_.searches(); }

 private:
  ContactsFollowed advance_contacts(const Instant& now, double dt, int times, double gain);
  int contact_steps_within(const Instant& now, double dt, double gain) const;
  [[noreturn]] void refuse_travel(double dt, double fastest, double gain) const;
  void book(ContactRecord record);
  double potential_energy();
  /// What contacts keep: kinetic energy and that stored in them.
  double mechanical_energy() const;
  State state();
  void set_law();
  void rescale(double temperature);

  Scene scene_;
  std::unique_ptr<parallel::Team> team_;
  Model model_;
  GrainContactLaw law_;
  std::unique_ptr<ContactMotion> contact_motion_;
  PairList list_;                        ///< of those that may touch
  std::optional<PairList> smooth_list_;  ///< of those that smooth forces need; empty: none
  std::vector<GrainContact> contacts_;   ///< in ascending order of pairs
  ContactRecord record_;
  GasEnergy book_;  ///< the flows
  GasSeconds seconds_;
  std::int64_t searches_ = 0;  ///< of contact_motion_
  GrainsSeen grains_seen_;
  double time_ = 0;
  std::size_t stage_ = 0;
};

}  // namespace lichtenberg::granular
