#pragma once

#include <vector>

#include "src/effects/groups.hpp"
#include "src/model/effect.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Parameters of electrical contacts (ContactDischarge): the gaps between surfaces at which they close and open.
struct ContactDischargeOptions {
  double contact_distance = 0;  ///< gap between surfaces (m) at which an electrical contact closes
  double hysteresis = 0.05;     ///< a contact opens at a gap of contact_distance * (1 + hysteresis)
  static const EffectKind& kind();
};

/// Effect of electrical contacts between close conductors, or a conductor and an electrode (Stephenson 2018, eq. 6.40).
/// A contact joins both to one equipotential group, unless an effect gives it a finite conductance (sharing_law()).
///
/// A contact closes when the gap between two surfaces falls to the contact distance `make_gap`. It opens when the gap
/// rises to the larger `release_gap` (hysteresis). Conductors can come to rest at the contact distance, because their
/// attraction ends if a contact makes their potentials equal. Without hysteresis, rounding would close and open such a
/// contact repeatedly. The two gaps differ by at least one position tolerance (mechanics.position_tolerance, the
/// accuracy of positions).
class ContactDischarge : public Effect {
 public:
  explicit ContactDischarge(const Scene& scene);  ///< `scene` must have the effect.

  const EffectKind& kind() const override { return ContactDischargeOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }

  double make_gap() const { return make_gap_; }        ///< gap at which a contact closes (m)
  double release_gap() const { return release_gap_; }  ///< gap at which a contact opens (m)
  /// Returns the gap (m) between the surfaces of a contact: two conductors, or a conductor and a terminal (electrode or
  /// electrode side).
  double gap(const Bodies& bodies, Contact contact) const;
  /// Returns the rate of change (m/s) of the gap of a contact; negative while the surfaces approach.
  double gap_rate(const Bodies& bodies, Contact contact) const;

  /// Contacts that have closed (`made`) and opened (`lost`), in ascending order.
  struct Changes {
    std::vector<Contact> made, lost;
  };
  /// Closes and opens contacts for the current positions, and returns the changes. `contacts`: closed contacts in
  /// ascending order, updated. A contact also changes shortly before its gap reaches the threshold, by at most a
  /// position tolerance. Nearly simultaneous changes are thus one event.
  Changes update(const Bodies& bodies, std::vector<Contact>& contacts) const;

  /// A contact that may close or open soon.
  struct Watch {
    Contact contact;
    bool made = false;  ///< true: the contact is closed and may open; false: it is open and may close
  };
  /// Returns the contacts that could close or open if each body i moved by at most travel[i] (m). Open contacts between
  /// bodies of one equipotential group are left out. `contacts`: closed contacts, in ascending order.
  std::vector<Watch> watch(const Bodies& bodies, std::span<const Contact> contacts, const ElectricalGroups& groups,
                           std::span<const double> travel) const;
  /// Returns true if both bodies of a contact are in one equipotential group. `bodies`: number of conductors.
  bool are_joined(const ElectricalGroups& groups, int bodies, Contact contact) const;
  /// Event function of a contact that may close or open: its gap minus the threshold (m), whose sign changes at the
  /// event. For opening, the threshold is above the release gap by at most a position tolerance, because forces do not
  /// jump when a contact opens.
  double excess(const Bodies& bodies, const Watch& watch) const {
    return gap(bodies, watch.contact) - (watch.made ? release_gap_ + simultaneity_margin_ : make_gap_);
  }
  /// Event function of an open contact whose closing is deferred. Its sign changes from positive to negative where the
  /// deferral must end. This is where the gap has fallen to 15/16 of the contact distance, or where it increases again
  /// below the contact distance. The value is a distance (m), or the closing speed (m/s) where the latter is smaller.
  double excess_of_deferred(const Bodies& bodies, const Watch& watch) const;
  /// Returns the largest relative displacement (m) of the two bodies of a contact until the next test of its gap. It is
  /// the distance of the gap from its threshold, but at least a length l. On a straight path on which the gap passes
  /// the threshold by one position tolerance, it stays beyond for at least l. Tests therefore detect such grazing
  /// contacts.
  double undetected_travel(const Bodies& bodies, const Watch& watch) const;

 private:
  /// A contact that may close (made = false) or open (made = true) while each body moves by at most its skin.
  struct Close {
    Contact contact;
    bool made = false;
  };
  /// Returns all pairs of conductors, and of a conductor and a terminal, in ascending order. Their gap is below `range`
  /// plus travel[i] of each conductor i in the pair (m).
  std::vector<Contact> pairs_within(const Bodies& bodies, double range, std::span<const double> travel) const;
  void update_terminal_gaps(const Bodies& bodies) const;
  void update_close_pairs(const Bodies& bodies, std::span<const Contact> contacts,
                          std::span<const double> travel) const;
  bool is_valid_for(const Bodies& bodies, std::span<const double> travel) const;
  template <int d>
  bool is_valid_for(const Bodies& bodies, std::span<const double> travel) const;
  void find_close(const Bodies& bodies, std::span<const Contact> contacts) const;

  double tolerance_;  ///< position tolerance (m)
  /// m; simultaneity_margin_: distance from the threshold within which contacts change together
  double make_gap_, release_gap_, simultaneity_margin_;
  std::vector<Terminal> terminals_;
  // Cache of nearby pairs of the last search; does not affect results.
  mutable ReachList near_;
  mutable int searches_ = 0;                  ///< rebuild number of near_ for which terminal_gap_ is valid
  mutable std::vector<double> terminal_gap_;  ///< m, by conductor and terminal
  // Only pairs in close_ can close or open their contact while every body is within its skin of its position in
  // search_positions_.
  double least_skin_;                             ///< m
  mutable std::vector<double> skin_;              ///< m, by body
  mutable std::vector<Close> close_;              ///< in ascending order
  mutable std::vector<double> search_positions_;  ///< positions of all bodies at the last search (m)
  mutable std::vector<Contact> search_contacts_;  ///< closed contacts for which close_ is valid
};

}  // namespace lichtenberg::effects
