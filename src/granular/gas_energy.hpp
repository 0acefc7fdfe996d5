#pragma once

namespace lichtenberg::granular {

/// Where the energy of a gas of grains is, and where it went. What `total` has lost since the start is the error of
/// the run. In units of m0 v0^2.
struct GasEnergy {
  double kinetic = 0;
  double contact = 0;     ///< stored in contacts
  double potential = 0;   ///< of charges and dipoles, and of uniform forces
  double dissipated = 0;  ///< by contacts
  double exchanged = 0;   ///< given to the field by charges that moved between grains
  double driven = 0;      ///< given to the grains by the gas around them and by rescaling
  /// What `total` has changed by while contacts were followed by themselves; other forces did the rest.
  double contact_error = 0;

  double total() const { return kinetic + contact + potential + dissipated - exchanged - driven; }
};

}  // namespace lichtenberg::granular
