#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/charging.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Contacts that may change on a way that is foreseen.
struct Lookahead {
  /// Place of a body at the start of the way, and how far (m) it may move.
  struct Foreseen {
    int body = 0;
    std::array<double, 3> start{};  ///< m
    double reach = 0;               ///< m
  };
  std::vector<effects::ContactDischarge::Watch> watched;  ///< contacts that may change
  std::vector<Foreseen> foreseen;                         ///< bodies that may move farther
  double least_reach = 0;                                 ///< m, of any body
};

/// Returns the time (s) in which the relative motion of the two of a contact changes their gap by at most `change` (m).
/// `force`: N, all components of all bodies. The relative speed bounds the change, also at the closest approach, where
/// the gap's own rate is 0.
double time_to_change_gap(const Bodies& bodies, effects::Contact contact, std::span<const double> force, double change);

/// When contacts that are made or lost end an integration. Nothing ends one without contact_discharge.
class ContactEvents {
 public:
  /// `discharge` may be null. All must outlive this.
  ContactEvents(const Model& model, const effects::ContactDischarge* discharge, double tolerance, Counters& counters)
      : model_(model), discharge_(discharge), tolerance_(tolerance), counters_(counters) {}

  /// The contacts that may change while body i moves by less than reach[i] (m). `thrown`: the bodies that may move
  /// farther, since what elastic contacts do to them is not known beforehand; empty: all.
  Lookahead look_ahead(const Charging& now, std::span<const double> reach,
                       const std::optional<std::vector<int>>& thrown = {}) const;
  /// Their changes as events, and as the last event the first body that moves farther. If mergers wait, contacts
  /// that are made are events only where they can do so no longer. `ahead` must outlive them. No events without
  /// contact_discharge.
  Events events(const Lookahead& ahead, bool mergers_wait = false) const;
  /// Ways become a little longer: a body that moves exactly as far as it can is no event.
  void widen(std::span<double> ways) const;
  /// The gap (m) below which conductors are one; infinite without contacts.
  double contact_gap() const;
  /// Whether a contact that is looked ahead for is to be made, or lost, where the bodies are.
  struct Due {
    bool made = false, lost = false;
  };
  Due due(const Lookahead& ahead) const;

 private:
  using Watch = effects::ContactDischarge::Watch;
  Events foreseen_events(std::span<const Watch> watched, bool mergers_wait) const;
  double longest_step(const std::vector<Watch>& watched, std::span<const double> force) const;
  double farthest_beyond(std::span<const Lookahead::Foreseen> foreseen, double farthest) const;

  const Model& model_;
  const effects::ContactDischarge* discharge_;
  double tolerance_;  ///< m, of positions
  Counters& counters_;
};

}  // namespace lichtenberg::mechanics
