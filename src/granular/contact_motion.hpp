#pragma once

#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "src/effects/linear_spring.hpp"
#include "src/effects/viscoelastic.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// How grains in contact push each other.
using ContactLaw = std::variant<effects::ViscoelasticLaw, effects::LinearSpringLaw>;

/// Two grains in contact, from touch to release.
struct GrainContact {
  Pair pair;
  double since = 0;         ///< time of touch
  double impact_speed = 0;  ///< at which they closed then, along the line of centres
  bool alone = true;        ///< neither has touched a third since

  friend auto operator<=>(const GrainContact& a, const GrainContact& b) { return a.pair <=> b.pair; }
  friend bool operator==(const GrainContact& a, const GrainContact& b) { return a.pair == b.pair; }
};

/// A contact that has ended.
struct Collision {
  GrainContact contact;
  double release_speed = 0;  ///< at which they separate when their surfaces part
  double end = 0;            ///< time of that
};

/// What contacts did while they were advanced.
struct ContactRecord {
  std::vector<GrainContact> begun;  ///< in ascending order within each step
  std::vector<Collision> ended;
  double dissipated = 0;
  double largest_overlap = 0;
  std::int64_t steps = 0;
};

/// Grains that feel their contacts and nothing else: each contact is integrated by itself (pair_motion.hpp), with the
/// forces of the other contacts of its two grains as they are at the beginning and in the middle of a step. A pair that
/// collides alone so has the restitution of its law to the sixth digit at the default step, and momentum is conserved
/// by construction: a contact gives its two grains opposite impulses. Errors of grains in several contacts are of
/// second order in the step.
class ContactMotion {
 public:
  virtual ~ContactMotion() = default;

  /// Advances places and momenta from `time` by `dt`, in `steps` equal steps. `pairs`: all that may touch in that time,
  /// in ascending order. Adds to `record`. The same bits for any number of threads. Throws Failure if grains overlap
  /// by more than a radius: they would fly through each other.
  virtual void advance(Bodies& bodies, std::span<const Pair> pairs, double time, double dt, int steps,
                       parallel::Team& team, ContactRecord& record) = 0;
  /// The elastic energy of the contacts.
  virtual double stored_energy(const Bodies& bodies) const = 0;

  /// In ascending order of pairs.
  const std::vector<GrainContact>& contacts() const { return contacts_; }
  void set_contacts(std::vector<GrainContact> contacts) { contacts_ = std::move(contacts); }

 protected:
  std::vector<GrainContact> contacts_;
};

/// For bodies of `dimension` 2 or 3.
std::unique_ptr<ContactMotion> make_contact_motion(const ContactLaw& law, int dimension);

}  // namespace lichtenberg::granular
