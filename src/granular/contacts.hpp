#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Returns the contact law of the model's grains. Throws InputError unless exactly one effect defines a law. Throws
/// InputError if its damping is beyond the table of theory::RestitutionCurve.
GrainContactLaw contact_law(const Scene& scene, const Model& model);

/// Contact forces at one instant.
struct ContactLoad {
  std::vector<double> force;  ///< on the grains, [N * d]
  double dissipation = 0;     ///< power, at least 0
};

/// Returns the contact forces of the pairs that overlap.
ContactLoad contact_load(const GrainContactLaw& law, const Bodies& bodies, std::span<const Pair> pairs);

/// Returns the elastic energy in contacts.
double stored_energy(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// Returns the largest relative speed (v0) that the elastic energy in a contact can give to its two grains.
double fastest_release(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// A pair that was in contact at the start of a step, or came into contact within it.
struct StepContact {
  GrainContact contact;
  bool begun = false;  ///< within the step
  bool open = true;    ///< at its end
};

/// Returns the contacts of a step of an integrator that computes forces at its ends only. A pair is in contact where it
/// overlaps. The onset of a new contact is the zero of the gap on the straight path from `from`, the positions at the
/// start ([N * d]). `pairs`: all candidate pairs, in ascending order.
std::vector<StepContact> contacts_in_step(std::span<const double> from, const Bodies& bodies,
                                          std::span<const GrainContact> contacts, std::span<const Pair> pairs,
                                          double begin, double dt);

/// Throws Failure: the centres of two grains have come closer than `too_close` (pair_state.hpp). `stiffer`: the factor
/// of the contact's stiffness with which they would stop there, all forces counted; 0: not known.
[[noreturn]] void refuse_flight_through(const GrainContact& contact, double stiffer = 0);

/// Records the contacts of a step that ends at the time `end`, in ascending order of pairs. `contacts` become the open
/// ones. Throws Failure if the centres of two grains come closer than `too_close`.
void note(std::vector<StepContact> step_contacts, const Bodies& bodies, double end, std::vector<GrainContact>& contacts,
          ContactRecord& record);

}  // namespace lichtenberg::granular
