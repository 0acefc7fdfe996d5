#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// Result of following contacts, in reduced units.
struct ContactsFollowed {
  ContactRecord record;
  double stored_at_start = 0, stored_at_end = 0;  ///< elastic energy in contacts
  double work = 0;                                ///< of the slow forces
  int searches = 0;                               ///< number of searches for candidate pairs
  double fastest_release = 0;  ///< v0, largest relative speed that a contact's elastic energy can give
};

/// Equal contact substeps, with bounds on the grains' speeds.
struct ContactSteps {
  double begin = 0, time = 0;  ///< t0, start and total duration
  int steps = 1;
  double fastest = 0;  ///< v0, largest speed at the start
  /// v0, bound on velocity changes since the last call; infinite: positions may have changed
  double velocity_change = INFINITY;
  double gain = 0;           ///< v0, bound on the velocity change by slow forces
  double search_path = 0.3;  ///< d0, path of the fastest grain between two searches
};

/// Motion of grains under contact forces and slow forces, which are constant over the steps of a call. Each contact is
/// integrated separately (pair_motion.hpp). The forces of the other contacts of its two grains enter by their values at
/// the start and in the middle of a step. An isolated pair has the restitution of its law to the sixth digit at the
/// default step. Momentum is conserved, because a contact gives its two grains opposite impulses. Errors of grains in
/// several contacts are of second order in the step.
class ContactMotion {
 public:
  virtual ~ContactMotion() = default;

  /// Advances positions and momenta under the slow forces `slow_force` ([N * d]; empty: none). `contacts`, in ascending
  /// order of pairs, are the open contacts at the start and are replaced by those at the end. Results are bitwise
  /// identical for any number of threads, any vector width and any earlier calls. Throws Failure if the centres of two
  /// grains come closer than `too_close`.
  virtual ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts,
                                   std::span<const double> slow_force, const ContactSteps& substeps,
                                   parallel::Team& team) = 0;
};

/// Makes the motion for bodies of `dimension` 2 or 3.
std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension);

}  // namespace lichtenberg::granular
