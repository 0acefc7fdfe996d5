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
/// InputError if the damping of viscoelastic grains is beyond the table of theory::RestitutionCurve for two unit grains
/// that meet at speed v0.
GrainContactLaw contact_law(const Scene& scene, const Model& model);

/// Total contact forces on grains at one instant, and the power that the contacts dissipate, in reduced units.
struct ContactLoad {
  std::vector<double> force;  ///< on each grain, [N * d]
  double dissipation = 0;     ///< dissipated power, at least 0
};

/// Returns the total contact forces on all grains, and the dissipated power, of the overlapping pairs among `pairs`.
ContactLoad contact_load(const GrainContactLaw& law, const Bodies& bodies, std::span<const Pair> pairs);

/// Returns the elastic energy (m0 v0^2) of all `contacts` at the current positions.
double stored_energy(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// Returns the largest relative speed (v0) that the elastic energy of a contact can give its two grains.
double fastest_release(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// A contact of two grains that exists at the start of a step, or begins in it.
struct StepContact {
  GrainContact contact;
  bool begun = false;  ///< true if the contact began in the step
  bool open = true;    ///< true if the contact lasts beyond the end of the step
};

/// Returns the contacts of one step, for integrators that compute forces only at the ends of a step. A pair is in
/// contact while it overlaps. Contacts that begin and end within the step are not found. The onset of a new contact is
/// the zero of the gap on a straight path from the start to the positions in `bodies`. `from`: positions at the start
/// ([N * d]). `contacts`: the contacts at the start. `pairs`: all candidate pairs (pairs that may touch). Both are in
/// ascending order. `begin`, dt: start and length of the step (t0).
std::vector<StepContact> contacts_in_step(std::span<const double> from, const Bodies& bodies,
                                          std::span<const GrainContact> contacts, std::span<const Pair> pairs,
                                          double begin, double dt);

/// Throws Failure with the message that two grains fly through each other. Their centres are closer than `too_close`
/// times the sum of the radii. `stiffer`: factor of the stiffness with which the grains would stop there, for the
/// message; 0: not known.
[[noreturn]] void refuse_flight_through(const GrainContact& contact, double stiffer = 0);
/// Throws Failure with the message that a grain flies through a flat wall at this side of the domain. Its centre is
/// closer to the wall than `too_close` times its radius, or beyond it.
[[noreturn]] void refuse_flight_through_wall(int grain, int side);

/// Adds new and ended contacts of a step and the largest overlap to `record`, and replaces `contacts` by the contacts
/// that last beyond its end. `step_contacts`: contacts of the step in ascending order of pairs; `end`: end of the step
/// (t0). Throws Failure if the centres of two grains are closer than `too_close` times the sum of their radii.
void note(std::vector<StepContact> step_contacts, const Bodies& bodies, double end, std::vector<GrainContact>& contacts,
          ContactRecord& record);

}  // namespace lichtenberg::granular
