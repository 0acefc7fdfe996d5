#pragma once

#include <cmath>
#include <functional>
#include <optional>

#include "solvers/error.hpp"

namespace lichtenberg::effects {

/// An electrical contact between a conductor and a partner. The partner is a conductor with a larger index, or a
/// terminal (an electrode or an electrode side). Indices of terminals start at the number of conductors.
struct Contact {
  int conductor = 0, partner = 0;
  friend auto operator<=>(const Contact&, const Contact&) = default;
};

/// State of an electrical contact at one instant: potential difference and gap.
struct ContactState {
  double potential_difference = 0;    ///< V, conductor minus partner
  std::optional<double> known_gap{};  ///< m; empty for a law without SharingLaw::gap_scale

  /// Returns the distance (m) from surface to surface; below 0 the two overlap. Throws InputError for a law without
  /// SharingLaw::gap_scale.
  double gap() const {
    if (known_gap) return *known_gap;
    throw InputError(
        "a law of charge sharing that reads the gap of a contact must state its gap_scale, the distance in m over "
        "which the conductance changes");
  }
};

/// Law of the conductance of an electrical contact, by which its two bodies share charge. The conductance is constant
/// if and only if `conductance_in_state` is empty.
struct SharingLaw {
  /// Conductance (S), at least 0. Infinite: the two bodies are one conductor; 0: no charge passes.
  double conductance = INFINITY;
  /// Conductance (S, at least 0 and finite) as a function of the contact's state. It is evaluated at each accepted
  /// field solve and at the end of each trial step. The step is shortened if the linearized current differs too much.
  /// Empty: the conductance is always `conductance`.
  std::function<double(const ContactState&)> conductance_in_state{};
  /// Distance (m, greater than 0) over which a change of the gap changes the conductance of `conductance_in_state`.
  /// Steps with error control change the gap by at most half of it. Infinite: the conductance does not depend on the
  /// gap.
  double gap_scale = INFINITY;

  /// Returns true if the contact always joins its two bodies to one conductor (constant, infinite conductance).
  bool joins() const { return !conductance_in_state && std::isinf(conductance); }
  /// Returns true if no charge ever passes through the contact (constant conductance 0).
  bool isolates() const { return !conductance_in_state && conductance == 0; }
};

}  // namespace lichtenberg::effects
