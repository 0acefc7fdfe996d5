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

/// How a contact shares charge: by its conductance. A law is constant if and only if it has no `of_state`, so that no
/// law can be taken as constant that is not.
struct SharingLaw {
  double conductance = INFINITY;  ///< S, at least 0. Infinite: the two are one conductor; 0: no charge passes
  /// The conductance (S, at least 0 and finite) in a state. Each accepted field solve asks for it. At the end
  /// of a step the current is compared with the law's, and the step is shortened where they differ. A change that comes
  /// and goes within a step is not seen. Empty: it is `conductance` at any time.
  std::function<double(const ContactState&)> of_state{};

  bool joins() const { return !of_state && std::isinf(conductance); }
  bool isolates() const { return !of_state && conductance == 0; }
};

}  // namespace lichtenberg::effects
