#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// What contacts did, and the elastic energy in them before and after.
struct ContactsFollowed {
  ContactRecord record;
  double stored_at_start = 0, stored_at_end = 0;
  double work = 0;             ///< of held forces
  int searches = 0;            ///< for pairs
  double fastest_release = 0;  ///< to which what is stored in one contact would bring its two, apart from rounding
};

/// Equal steps, and what is known of the grains' speeds.
struct ContactSteps {
  double begin = 0, time = 0;  ///< when, and how long all of them take
  int steps = 1;
  double fastest = 0;        ///< the largest speed, at the beginning
  double kicked = INFINITY;  ///< by which a velocity may have changed since the steps before; infinite: places may too
  double gain = 0;           ///< by which held forces may change one within these, evenly
  double way = 0.3;          ///< how far the fastest may fly before pairs are looked for anew
};

/// Grains that feel their contacts and nothing else: each contact is integrated by itself (pair_motion.hpp), with the
/// forces of the other contacts of its two grains as they are at the beginning and in the middle of a step. A pair that
/// collides alone so has the restitution of its law to the sixth digit at the default step, and momentum is conserved
/// by construction: a contact gives its two grains opposite impulses. Errors of grains in several contacts are of
/// second order in the step.
class ContactMotion {
 public:
  virtual ~ContactMotion() = default;

  /// Advances places and momenta, with other forces `held` ([N * d]; empty: none); `contacts`, in ascending order, are
  /// those at the beginning and become those at the end. The same bits for any number of threads, whatever number of
  /// pairs a processor computes at once, and whatever has been followed before.
  /// Throws Failure if the centres of two grains come so close that they would fly through each other.
  virtual ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const double> held,
                                   const ContactSteps& of, parallel::Team& team) = 0;
};

/// For bodies of `dimension` 2 or 3.
std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension);

}  // namespace lichtenberg::granular
