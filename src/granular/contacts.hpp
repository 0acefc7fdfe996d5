#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// How the grains of that model push each other. Throws InputError unless one of its effects says so, and one alone.
GrainContactLaw contact_law(const Scene& scene, const Model& model);

/// What the contacts of grains do at one instant.
struct ContactLoad {
  std::vector<double> force;  ///< on the grains, [N * d]
  double dissipation = 0;     ///< power, never below 0
};

/// Of those of the pairs that overlap.
ContactLoad contact_load(const GrainContactLaw& law, const Bodies& bodies, std::span<const Pair> pairs);

/// The elastic energy of contacts.
double stored_energy(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// The largest relative speed that what is stored in a contact can still give to its two.
double fastest_release(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts);

/// A pair that was in contact at the beginning of a step or has touched within it.
struct Touch {
  GrainContact contact;
  bool begun = false;  ///< within the step
  bool open = true;    ///< at its end
};

/// The touches of a step whose forces are known at its ends alone: overlaps then and before, when the grains were at
/// `from`, and if there is none before, the instant at which the straight way between the two has none left. `pairs`:
/// all that may touch, in ascending order.
std::vector<Touch> touches_between(std::span<const double> from, const Bodies& bodies,
                                   std::span<const GrainContact> contacts, std::span<const Pair> pairs, double begin,
                                   double dt);

/// Throws Failure: the centres of two grains have come closer than `too_close` (pair_state.hpp). `stiffer`: the factor
/// of the contact's stiffness with which they would stop there, all forces counted; 0: not known.
[[noreturn]] void refuse_flight_through(const GrainContact& contact, double stiffer = 0);

/// Writes down the touches of a step, in ascending order of pairs, that has brought the grains to where they are at
/// `end`; `contacts` become those that are open. Throws Failure if the centres of two come so close that they would fly
/// through each other.
void note(std::vector<Touch> touches, const Bodies& bodies, double end, std::vector<GrainContact>& contacts,
          ContactRecord& record);

}  // namespace lichtenberg::granular
