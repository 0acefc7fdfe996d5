#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/effects/surface.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/sharing_law.hpp"

namespace lichtenberg {
struct EffectKind;
}

namespace lichtenberg::effects {

/// A terminal: an electrode or an electrode side of the domain, which is connected to a potential source, directly or
/// through a series resistor. Conductors can touch it.
struct Terminal {
  std::string name;
  Surface surface;
  double potential = 0;          ///< potential of the source (V)
  double series_resistance = 0;  ///< resistance between source and surface (ohm); 0: connected directly
  int node = -1;                 ///< node of ElectricalGroups if there is a series resistor; -1: none
};

/// Returns the terminals of a scene: the electrodes in the scene's order, then the sides of the domain that are
/// electrodes.
std::vector<Terminal> terminals_of(const Scene& scene);

/// Returns the number of nodes with a potential and charge of their own: conductors, and electrodes behind a series
/// resistor.
int node_count(const Scene& scene);

/// A potential source (voltage supply), which fixes the potential of conductors and supplies or collects their charge.
struct PotentialSource {
  std::string name;
  double potential = 0;  ///< V
};

/// Returns the potential sources of a scene: one for each terminal (electrode or electrode side), in their order, then
/// one for each wire (the scene's [[group]]) at a prescribed potential.
std::vector<PotentialSource> potential_sources_of(const Scene& scene);

/// Equipotential groups of nodes, which contacts and wires connect. Nodes are the conductors, then the electrodes
/// behind a series resistor. All nodes at the same prescribed potential are one group, whether they touch or not.
struct ElectricalGroups {
  std::vector<int> id;  ///< for each node: smallest index in its group
  /// For each node: prescribed potential (V) of its group; empty: the group floats
  std::vector<std::optional<double>> potential;
  /// For each node: index in potential_sources_of() of the source that is connected with it; -1 if it floats. Separate
  /// components at one prescribed potential are one group, but each of them has its own source that collects its
  /// charge. If several sources are connected with one component, the division of charge among them is undetermined,
  /// and the first takes it all.
  std::vector<int> supply;
  /// For each conductor: smallest index of the conductors that wires and conducting contacts connect with it; -1 if
  /// they connect it with a terminal or the source of a wire. Connected conductors are in different equipotential
  /// groups if a resistive contact is between them.
  std::vector<int> connected;
  friend bool operator==(const ElectricalGroups&, const ElectricalGroups&) = default;
};

/// Returns true if a conductor is in one equipotential group with a terminal (electrode or electrode side). For a
/// terminal without a series resistor this is the group at the prescribed potential of the terminal.
bool shares_group(const ElectricalGroups& groups, int conductor, const Terminal& terminal);

/// Returns the description of the scene's effect that defines a conductance of contacts (EffectKind::sharing). Null:
/// all contacts join their bodies to one equipotential group.
const EffectKind* sharing_effect(const Scene& scene);

/// Returns the conductance law of an electrical contact; infinite conductance if no effect defines one. Throws
/// InputError for a conductance below 0.
SharingLaw sharing_law(const Scene& scene, Contact contact);

/// Returns the equipotential groups of a scene with these closed contacts: connected components of wires (the scene's
/// [[group]]s) and of contacts with infinite conductance. A component takes the potential of a wire at a prescribed
/// potential, or of a terminal without a series resistor. Components at the same prescribed potential are one group.
/// Throws InputError for a short circuit between two potentials.
ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts);

/// Returns true if the change from `before` to `after` splits an equipotential group, or disconnects a group from its
/// prescribed potential.
bool splits_group(const ElectricalGroups& before, const ElectricalGroups& after);

}  // namespace lichtenberg::effects
