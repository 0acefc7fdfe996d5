#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/granular/contact_motion.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/gas_energy.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_list.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/granular/survey.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Wall time (s) since this program started, by what it was spent on.
struct GasSeconds {
  double contacts = 0;
  double forces = 0;    ///< of charges, and all else that is smooth
  double lists = 0;     ///< of neighbours
  double exchange = 0;  ///< of charge
};

/// Grains in a periodic box with all that acts on them, at one instant: what an integrator carries on.
class Gas {
 public:
  explicit Gas(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const Bodies& bodies() const { return model_.bodies; }
  /// Pairs are searched for anew after that.
  Model& model_to_change() {
    forget();
    return model_;
  }
  const Model& model() const { return model_; }
  double time() const { return time_; }
  const std::vector<GrainContact>& contacts() const { return contacts_; }
  /// The law of contacts in the stage that the scene is in.
  const GrainContactLaw& law() const { return law_; }
  parallel::Team& team() { return *team_; }

  /// The energy as it is, with what has been booked so far. `potential`: what is known of it already.
  GasEnergy energy(std::optional<double> potential = {});
  double fastest() const { return surveyed().fastest; }  ///< the largest speed
  double kinetic_energy() const { return surveyed().kinetic; }
  /// The largest relative speed that two grains may have, or that a contact may still give to its two.
  double fastest_impact() const;
  /// Time (t0) that steps of contacts must resolve where two grains meet at that speed at most (pace.hpp).
  double time_to_resolve(double impact) const;
  const GrainsSeen& grains_seen() const { return grains_seen_; }

  /// The pairs that may touch within dt, in which smooth forces make a grain faster by at most `gain`.
  std::span<const Pair> near(double dt, double gain = 0);
  /// What contacts do to the grains as they are; `pairs`: all that may touch.
  ContactLoad contact_load(std::span<const Pair> pairs);
  /// The smooth forces on the grains as they are, [N * d].
  const std::vector<double>& smooth_forces();
  double largest_smooth_acceleration();
  /// From then on the energy will be asked for: it is found together with the smooth forces.
  void expect_energy_at(double time) { energy_at_ = time; }
  /// Moves each grain by so much, [N * d]; it is then `time`.
  void move(std::span<const double> path, double time);
  /// Writes down what contacts did since `begin` and what they dissipated. Each step does so once.
  void note(std::vector<Touch> touches, double begin, double dissipated);

  /// Changes momenta by dt times the smooth forces at this instant.
  void kick(double dt);
  bool has_smooth_forces() const;
  /// Wall time (s) that the forces of an effect take once, with this gas's threads.
  double seconds_of_forces(const Effect& effect);
  /// What surrounds the grains acts on them from `begin` on for dt.
  void drive(double begin, double dt);
  /// Contacts, and the smooth forces as they are now, move the grains until `end`, in steps that resolve the shortest
  /// contact; then momenta change as if smooth forces had changed linearly in time.
  void follow_contacts(double end);
  /// What happens once a step: charges move between grains that are in contact, and all that counts contacts does so.
  void settle_contacts();

  /// When the current stage began.
  double stage_begin() const;
  /// Whether contacts lose nothing and move no charge, because the scene is still being mixed.
  bool in_elastic_stage() const;
  /// The time at which the current stage ends; infinite in the last.
  double stage_end() const;
  /// Whether, when the stage ends, temperature and charges go on as they are.
  bool cools_on_after_stage() const;
  /// Goes on to the next stage: another law of contact, perhaps another temperature.
  void leave_stage();

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
  ContactsFollowed advance_contacts(std::span<const double> held, double dt, int times, double gain);
  int contact_steps_within(double dt, double gain) const;
  [[noreturn]] void refuse_travel(double dt, double gain) const;
  void book(ContactRecord record);
  double potential_energy();
  /// What contacts keep: kinetic energy and that stored in them.
  double mechanical_energy() const;
  State state();
  const Survey& surveyed() const;
  void forget_smooth_forces();
  void set_law();
  void rescale(double temperature);
  /// A velocity has changed by `most` or less, and not by contacts.
  void change_velocities(double most);
  /// Anything may have changed.
  void forget();

  Scene scene_;
  std::unique_ptr<parallel::Team> team_;
  Model model_;
  GrainContactLaw law_;
  std::unique_ptr<ContactMotion> contact_motion_;
  PairList list_;                        ///< of those that may touch
  std::optional<PairList> smooth_list_;  ///< of those that smooth forces need; empty: none
  std::vector<GrainContact> contacts_;   ///< in ascending order of pairs
  ContactRecord record_;
  std::vector<double> smooth_force_;           ///< [N * d]; empty: to be evaluated
  std::vector<double> held_;                   ///< those of the step's beginning
  std::optional<double> smooth_acceleration_;  ///< the largest that these forces make; empty: to be found
  double energy_at_ = INFINITY;
  GasEnergy book_;  ///< the flows
  GasSeconds seconds_;
  std::int64_t searches_ = 0;             ///< of contact_motion_
  mutable std::optional<Survey> survey_;  ///< of the grains as they are; empty: to be made
  std::optional<double> release_;  ///< to which one contact might bring its two, by and large; empty: to be found
  double kicked_ = INFINITY;       ///< by which velocities may have changed since contacts were followed
  GrainsSeen grains_seen_;
  double time_ = 0;
  std::size_t stage_ = 0;
};

}  // namespace lichtenberg::granular
