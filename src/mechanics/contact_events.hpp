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

/// Candidate contacts: contacts of conductors that may close ("made") or open ("lost") along the bodies' predicted
/// paths.
struct ContactPrediction {
  /// Start of a body's path, and the largest distance (m) from it for which the prediction is valid.
  struct PredictedPath {
    int body = 0;
    std::array<double, 3> start{};  ///< m
    double reach = 0;               ///< m
  };
  std::vector<effects::ContactDischarge::Watch> watched;  ///< contacts that may change
  std::vector<PredictedPath> paths;                       ///< bodies that may leave their range of validity
  double least_reach = 0;                                 ///< m, smallest `reach` of all bodies
};

/// Returns a lower bound of the time (s) in which the gap of a contact changes by `change` (m) under constant forces.
/// `force`: forces (N, [N * dimension]) on all bodies. The bound uses the relative speed and acceleration. It therefore
/// also holds at the closest approach, where the rate of the gap is 0.
double time_to_change_gap(const Bodies& bodies, effects::Contact contact, std::span<const double> force, double change);

/// Event functions of an integration of the motion: electrical contacts that close ("made") or open ("lost"). Without
/// the effect contact_discharge there are no events.
class ContactEvents {
 public:
  /// Makes the event functions of a model. `discharge`: the effect that closes and opens contacts; may be null.
  /// `tolerance`: m, position_tolerance of the scene. All arguments must outlive this object.
  ContactEvents(const Model& model, const effects::ContactDischarge* discharge, double tolerance, Counters& counters)
      : model_(model), discharge_(discharge), tolerance_(tolerance), counters_(counters) {}

  /// Finds the contacts that may close or open while each body i moves by less than reach[i] (m). `now`: closed
  /// contacts and equipotential groups at the present positions. `colliding`: bodies that may move farther, because the
  /// prediction omits elastic collisions; no value: all bodies.
  ContactPrediction predict_contacts(const ElectricalState& now, std::span<const double> reach,
                                     const std::optional<std::vector<int>>& colliding = {}) const;
  /// Makes one event function for each candidate contact, and a last one for bodies that move farther than their reach.
  /// `mergers_wait`: true if closing contacts, which merge equipotential groups, may wait: the event is then where the
  /// deferral must end. `prediction` must outlive the events. Without contact_discharge there are no events.
  Events events(const ContactPrediction& prediction, bool mergers_wait = false) const;
  /// Enlarges distances (m) by 1 % and one position tolerance. A body that moves exactly as far as expected then
  /// triggers no event.
  void widen(std::span<double> distances) const;
  /// Returns the gap (m) at which a contact closes; infinite without contact_discharge, or if that gap is 0.
  double contact_gap() const;
  /// Kinds of contact changes that are due at the present positions: a candidate contact must close (`made`) or open
  /// (`lost`).
  struct Due {
    bool made = false, lost = false;
  };
  /// Determines if a candidate contact must close or open at the present positions.
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
