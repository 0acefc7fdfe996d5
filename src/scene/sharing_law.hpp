#pragma once

#include <cmath>
#include <functional>

namespace lichtenberg::effects {

/// An electrical contact. The partner is a conductor with a larger index, or a terminal. Indices of terminals start at
/// the number of conductors.
struct Contact {
  int conductor = 0, partner = 0;
  friend auto operator<=>(const Contact&, const Contact&) = default;
};

/// A contact at one instant.
struct ContactState {
  double gap = 0;                   ///< m, surface to surface; below 0 the two overlap
  double potential_difference = 0;  ///< V, conductor minus partner
};

/// Conductance of a contact. The conductance is constant if and only if `of_state` is empty.
struct SharingLaw {
  /// S, at least 0. Infinite: the two bodies are one conductor; 0: no charge passes.
  double conductance = INFINITY;
  /// Conductance (S, at least 0 and finite) in a state. It is evaluated at each accepted field solve and at the end of
  /// each trial step. The step is shortened if the linearized current differs too much. A change that reverts within a
  /// step is not detected. Empty: the conductance is always `conductance`.
  std::function<double(const ContactState&)> of_state{};

  bool joins() const { return !of_state && std::isinf(conductance); }
  bool isolates() const { return !of_state && conductance == 0; }
};

}  // namespace lichtenberg::effects
