#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// Result of ContactMotion::advance(): contact events, elastic energies and work, in reduced units.
struct ContactsFollowed {
  ContactRecord record;
  double stored_at_start = 0, stored_at_end = 0;  ///< elastic energy of all contacts
  double work = 0;                                ///< work of the slow forces
  double rotation = 0;                            ///< change of the kinetic energy of rotation
  int searches = 0;                               ///< number of searches for candidate pairs
  double fastest_release = 0;  ///< largest relative speed (v0) that the elastic energy of a contact can give its grains
};

/// Contact substeps of equal length, with bounds on the speeds of the grains, as input of ContactMotion::advance().
struct ContactSteps {
  double begin = 0, time = 0;  ///< start and total duration (t0)
  int steps = 1;               ///< number of substeps
  double fastest = 0;          ///< largest speed at the start (v0)
  /// Bound on velocity changes since the last call (v0); infinite: positions may have changed, too
  double velocity_change = INFINITY;
  double gain = 0;           ///< bound on the velocity change by slow forces in this call (v0)
  double search_path = 0.3;  ///< path of the fastest grain between two searches for candidate pairs (d0)
};

/// Time integration of grains under contact forces and slow forces. Slow forces are all forces except contacts; they
/// are constant during a call. Each contact is integrated separately (pair_motion.hpp). The forces of the other
/// contacts of its two grains enter by their values at the start and in the middle of a substep.
///
/// Contacts conserve momentum, because each gives its two grains opposite impulses. Errors of grains in several
/// contacts are of second order in the substep.
class ContactMotion {
 public:
  virtual ~ContactMotion() = default;

  /// Advances positions and momenta of the grains through the substeps. `slow_force`: constant forces ([N * d]; empty:
  /// none). `contacts`: the contacts that have begun and not ended, in ascending order of pairs; on return those at the
  /// end. Results are bitwise identical for any number of threads and vector width. Throws Failure if after a substep
  /// the centres of two grains are closer than `too_close` times the sum of their radii.
  virtual ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts,
                                   std::span<const double> slow_force, const ContactSteps& substeps,
                                   parallel::Team& team) = 0;
};

/// Makes the time integration of contacts for a contact law and bodies of `dimension` 2 or 3.
std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension);

}  // namespace lichtenberg::granular
