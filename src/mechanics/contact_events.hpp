#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/mechanics/electrical_state.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Contacts that may be made or lost along predicted paths.
struct ContactPrediction {
  /// Position of a body at the start of its path, and the distance (m) that the prediction covers.
  struct PredictedPath {
    int body = 0;
    std::array<double, 3> start{};  ///< m
    double reach = 0;               ///< m
  };
  std::vector<effects::ContactDischarge::Watch> watched;  ///< contacts that may change
  std::vector<PredictedPath> paths;                       ///< bodies that may move beyond their reach
  double least_reach = 0;                                 ///< m, smallest of all bodies
};

/// Returns the time (s) in which the relative motion of the two of a contact changes their gap by at most `change` (m).
/// `force`: N, all components of all bodies. The relative speed bounds the change, also at the closest approach, where
/// the gap's own rate is 0.
double time_to_change_gap(const Bodies& bodies, effects::Contact contact, std::span<const double> force, double change);

/// Events of an integration: contacts that are made or lost. Without contact_discharge there are none.
class ContactEvents {
 public:
  /// `discharge` may be null. All arguments must outlive this object.
  ContactEvents(const Model& model, const effects::ContactDischarge* discharge, double tolerance, Counters& counters)
      : model_(model), discharge_(discharge), tolerance_(tolerance), counters_(counters) {}

  /// Returns the contacts that may change while body i moves by less than reach[i] (m). `colliding`: bodies that may
  /// move farther, because elastic collisions are not predicted; empty: all.
  ContactPrediction predict_contacts(const ElectricalState& now, std::span<const double> reach,
                                     const std::optional<std::vector<int>>& colliding = {}) const;
  /// Returns an event for each of these contacts, and as the last event a body that moves beyond its reach. If group
  /// merges wait, a contact that is made is an event only if it cannot wait longer. `prediction` must outlive the
  /// events. Without contact_discharge there are no events.
  Events events(const ContactPrediction& prediction, bool mergers_wait = false) const;
  /// Adds 1 % and a position tolerance to distances (m), so that a body that moves exactly as far as it can is no
  /// event.
  void widen(std::span<double> distances) const;
  /// Returns the gap (m) below which a contact is made; infinite without contacts.
  double contact_gap() const;
  /// True members: a candidate contact must be made, or lost, at the present positions.
  struct Due {
    bool made = false, lost = false;
  };
  Due due(const ContactPrediction& prediction) const;

 private:
  using Watch = effects::ContactDischarge::Watch;
  Events predicted_events(std::span<const Watch> watched, bool mergers_wait) const;
  double longest_step(const std::vector<Watch>& watched, std::span<const double> force) const;
  double largest_overshoot(std::span<const ContactPrediction::PredictedPath> paths, double farthest) const;

  const Model& model_;
  const effects::ContactDischarge* discharge_;
  double tolerance_;  ///< m, position_tolerance
  Counters& counters_;
};

}  // namespace lichtenberg::mechanics
