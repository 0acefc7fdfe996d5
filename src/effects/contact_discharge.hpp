#pragma once

#include <vector>

#include "src/effects/groups.hpp"
#include "src/model/effect.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct ContactDischargeOptions {
  double contact_distance = 0;  ///< m: contact closes when the surfaces come closer than this
  double hysteresis = 0.05;     ///< contact opens at contact_distance * (1 + hysteresis)
  static const EffectKind& kind();
};

/// Joins close conductors to one equipotential group, and also a conductor and an electrode (D 6.6, 6.40).
///
/// A contact closes when the gap between two surfaces falls to `contact_distance`, and opens when it rises to the
/// larger `release_gap` (hysteresis). Conductors come to rest at the contact distance, because their attraction ends
/// where their potentials become equal. Without hysteresis, rounding would close and open their contact repeatedly. The
/// release gap exceeds the gap by at least one position tolerance, the accuracy of positions.
class ContactDischarge : public Effect {
 public:
  explicit ContactDischarge(const Scene& scene);  ///< `scene` must have the effect.

  const EffectKind& kind() const override { return ContactDischargeOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }

  double make_gap() const { return make_gap_; }        ///< m
  double release_gap() const { return release_gap_; }  ///< m
  /// Surface-to-surface distance (m), and its rate of change (m/s).
  double gap(const Bodies& bodies, Contact contact) const;
  double gap_rate(const Bodies& bodies, Contact contact) const;

  struct Changes {
    std::vector<Contact> made, lost;
  };
  /// Closes and opens contacts for these positions; `contacts` is in ascending order. Contacts within a position
  /// tolerance of their threshold that approach it are included, so that nearly simultaneous events are one.
  Changes update(const Bodies& bodies, std::vector<Contact>& contacts) const;

  /// A contact that may close or open soon.
  struct Watch {
    Contact contact;
    bool made = false;  ///< true: the contact is closed and may open
  };
  /// Returns all contacts whose gap could reach its threshold if body i moved by at most travel[i] (m). Contacts that
  /// could close between conductors of one group are excluded. `contacts`: closed contacts, in ascending order.
  std::vector<Watch> watch(const Bodies& bodies, std::span<const Contact> contacts, const ElectricalGroups& groups,
                           std::span<const double> travel) const;
  /// Returns true if the contact's bodies are already in one of these groups. `bodies`: number of the scene's bodies.
  bool are_joined(const ElectricalGroups& groups, int bodies, Contact contact) const;
  /// Returns the distance of the gap from the threshold (m), whose sign changes at the event. An opening contact may
  /// wait for a position tolerance, because forces do not jump then.
  double excess(const Bodies& bodies, const Watch& watch) const {
    return gap(bodies, watch.contact) - (watch.made ? release_gap_ + simultaneity_margin_ : make_gap_);
  }
  /// Event function of a closing contact that may be deferred. Its sign changes where deferral must end, because the
  /// gap increases again or has fallen by 1/16 of `gap`. The value is not always a distance (m): near the minimum of
  /// the gap it is the closing speed.
  double excess_of_deferred(const Bodies& bodies, const Watch& watch) const;
  /// Returns the largest relative displacement (m) between two tests of the gap. If a gap passes its threshold by one
  /// position tolerance on a straight path, it is beyond the threshold for at least this path length. Therefore grazing
  /// contacts are detected.
  double undetected_travel(const Bodies& bodies, const Watch& watch) const;

 private:
  /// A pair whose contact may close or open soon.
  struct Close {
    Contact contact;
    bool made = false;
  };
  std::vector<Contact> pairs_within(const Bodies& bodies, double range, std::span<const double> travel) const;
  void update_terminal_gaps(const Bodies& bodies) const;
  void update_close_pairs(const Bodies& bodies, std::span<const Contact> contacts,
                          std::span<const double> travel) const;
  bool is_valid_for(const Bodies& bodies, std::span<const double> travel) const;
  template <int d>
  bool is_valid_for(const Bodies& bodies, std::span<const double> travel) const;
  void find_close(const Bodies& bodies, std::span<const Contact> contacts) const;

  double tolerance_;  ///< m, of positions
  /// m; together_: distance from the threshold within which contacts change together
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
  mutable std::vector<double> search_positions_;  ///< positions
  mutable std::vector<Contact> search_contacts_;  ///< closed contacts for which close_ is valid
};

}  // namespace lichtenberg::effects
