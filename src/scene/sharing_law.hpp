#pragma once

#include <cmath>
#include <functional>

namespace lichtenberg::effects {

/// An electrical contact. The partner is a conductor with a larger index, or, from the number of conductors on, a
/// terminal.
struct Contact {
  int conductor = 0, partner = 0;
  friend auto operator<=>(const Contact&, const Contact&) = default;
};

/// A contact at one instant.
struct ContactState {
  double gap = 0;                   ///< m, surface to surface; below 0 the two overlap
  double potential_difference = 0;  ///< V, conductor minus partner
};

/// How a contact shares charge: by its conductance. The conductance is constant if and only if there is no
/// `of_state`.
struct SharingLaw {
  double conductance = INFINITY;  ///< S, at least 0. Infinite: the two are one conductor; 0: no charge passes
  /// The conductance (S, at least 0 and finite) in a state. It is evaluated at each accepted field solve
  /// and at the end of each trial step, which is shortened if the linearized current differs too much. A change that
  /// reverts within a step is not detected. Empty: it is `conductance` at any time.
  std::function<double(const ContactState&)> of_state{};

  bool joins() const { return !of_state && std::isinf(conductance); }
  bool isolates() const { return !of_state && conductance == 0; }
};

}  // namespace lichtenberg::effects
