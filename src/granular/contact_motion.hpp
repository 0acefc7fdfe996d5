#pragma once

#include <memory>
#include <optional>
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
};

/// All pairs that may touch within a time, in ascending order; others change nothing. Empty: they are looked for, with
/// grains sorted in space, which pays from a few steps on.
using NearPairs = std::optional<std::span<const Pair>>;

/// Grains that feel their contacts and nothing else: each contact is integrated by itself (pair_motion.hpp), with the
/// forces of the other contacts of its two grains as they are at the beginning and in the middle of a step. A pair that
/// collides alone so has the restitution of its law to the sixth digit at the default step, and momentum is conserved
/// by construction: a contact gives its two grains opposite impulses. Errors of grains in several contacts are of
/// second order in the step.
class ContactMotion {
 public:
  virtual ~ContactMotion() = default;

  /// Advances places and momenta from `time` by `dt`, in `steps` equal steps, with other forces `held` ([N * d]; empty:
  /// none); `contacts`, in ascending order, are those at the beginning and become those at the end. The same bits for
  /// any number of threads, and whatever number of pairs a processor computes at once.
  /// Throws Failure if the centres of two grains come so close that they would fly through each other.
  virtual ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, const NearPairs& pairs,
                                   std::span<const double> held, double time, double dt, int steps,
                                   parallel::Team& team) = 0;
};

/// For bodies of `dimension` 2 or 3.
std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension);

}  // namespace lichtenberg::granular
