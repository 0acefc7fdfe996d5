#pragma once

#include <vector>

#include "src/effects/groups.hpp"
#include "src/model/effect.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct ContactDischargeOptions {
  double gap = 0;            ///< m: contact is made when the surfaces come closer than this
  double hysteresis = 0.05;  ///< contact is lost at gap * (1 + hysteresis)
  static const EffectKind& kind();
};

/// Conductors that come close become one electrically, and so do a conductor and an electrode (D 6.6, 6.40).
///
/// A contact is made when the gap between two surfaces falls to `gap` and lost when it rises to `release_gap`, a little
/// more (hysteresis): conductors come to rest right at the contact distance, because their attraction ends where their
/// potentials become equal, and without hysteresis rounding would make and break their contact for ever. The
/// release gap is at least one position tolerance beyond the gap, since positions are not known better.
class ContactDischarge : public Effect {
 public:
  explicit ContactDischarge(const Scene& scene);  ///< which has it

  const EffectKind& kind() const override { return ContactDischargeOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }

  double make_gap() const { return make_gap_; }        ///< m
  double release_gap() const { return release_gap_; }  ///< m
  /// Surface to surface (m), and its rate of change (m/s).
  double gap(const Bodies& bodies, Contact contact) const;
  double gap_rate(const Bodies& bodies, Contact contact) const;

  struct Changes {
    std::vector<Contact> made, lost;
  };
  /// Makes and loses the contacts (in ascending order) that these positions ask for. Those within a position tolerance
  /// of their threshold and on their way to it come along, so that events at all but the same time are one.
  Changes update(const Bodies& bodies, std::vector<Contact>& contacts) const;

  /// A contact that may be made or lost soon.
  struct Watch {
    Contact contact;
    bool made = false;  ///< it exists and may be lost
  };
  /// All whose gap could reach its threshold if body i moved by at most travel[i] (m), save contacts that could be made
  /// between conductors that are one already. `contacts`: those made, in ascending order.
  std::vector<Watch> watch(const Bodies& bodies, std::span<const Contact> contacts, const ElectricalGroups& groups,
                           std::span<const double> travel) const;
  /// Whether a contact (of a scene with so many bodies) would join what is one in these groups.
  bool one_already(const ElectricalGroups& groups, int bodies, Contact contact) const;
  /// Distance of the gap from the threshold (m): its sign changes where something must be done about the contact. One
  /// that is to be lost may wait for a position tolerance: forces do not jump then.
  double excess(const Bodies& bodies, const Watch& watch) const {
    return gap(bodies, watch.contact) - (watch.made ? release_gap_ + together_ : make_gap_);
  }
  /// The same of a contact that is to be made and may wait: its sign changes where it can wait no longer, since the two
  /// go apart again or are closer by a sixteenth of the gap. Not a distance (m) everywhere: near where they turn round
  /// it is their speed away from each other.
  double excess_of_waiting(const Bodies& bodies, const Watch& watch) const;
  /// How far (m) the two may move against each other between two looks at them. A gap that passes its threshold by one
  /// position tolerance, on a straight way past each other, is beyond it for at least this long: no graze is missed.
  double blind_way(const Bodies& bodies, const Watch& watch) const;

 private:
  /// A pair whose contact may be made or lost soon.
  struct Close {
    Contact contact;
    bool made = false;
  };
  std::vector<Contact> near(const Bodies& bodies, double range, std::span<const double> travel) const;
  void look_at_terminals(const Bodies& bodies) const;
  void look(const Bodies& bodies, std::span<const Contact> contacts, std::span<const double> travel) const;
  bool covers(const Bodies& bodies, std::span<const double> travel) const;
  template <int d>
  bool covers(const Bodies& bodies, std::span<const double> travel) const;
  void find_close(const Bodies& bodies, std::span<const Contact> contacts) const;

  double tolerance_;                          ///< m, of positions
  double make_gap_, release_gap_, together_;  ///< m; the last: how far from its threshold a contact may change
  std::vector<Terminal> terminals_;
  // What was near at the last search: makes looks faster, and changes no answer.
  mutable ReachList near_;
  mutable int searches_ = 0;                  ///< of near_ that the gaps below are of
  mutable std::vector<double> terminal_gap_;  ///< m, by conductor and terminal
  // No other pair than those that are close can make or lose its contact while no body is farther than its skin from
  // where it was when they were found.
  double least_skin_;                       ///< m
  mutable std::vector<double> skin_;        ///< m, by body
  mutable std::vector<Close> close_;        ///< in ascending order
  mutable std::vector<double> found_at_;    ///< positions
  mutable std::vector<Contact> made_then_;  ///< the contacts that close_ is of
};

}  // namespace lichtenberg::effects
