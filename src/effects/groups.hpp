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

/// A fixed-potential body that conductors can touch: an electrode, or an electrode side of the domain.
struct Terminal {
  std::string name;
  Surface surface;
  double potential = 0;          ///< V, of the potential source if there is a resistor
  double series_resistance = 0;  ///< ohm, between source and surface; 0: none
  int node = -1;                 ///< node of ElectricalGroups, if there is a resistor
};

/// Returns the electrodes in the scene's order, then the sides of the domain that are electrodes.
std::vector<Terminal> terminals_of(const Scene& scene);

/// Returns the number of nodes: conductors, and terminals behind a resistor.
int node_count(const Scene& scene);

/// A potential source, which fixes the potential of conductors and supplies or collects their charge.
struct PotentialSource {
  std::string name;
  double potential = 0;  ///< V
};

/// Returns the terminals, in their order, then the wires (the scene's [[group]]s) at a prescribed potential.
std::vector<PotentialSource> potential_sources_of(const Scene& scene);

/// Equipotential groups of nodes. Nodes are the conductors, then the terminals behind a resistor. All nodes at the same
/// prescribed potential are one group, whether they touch or not.
struct ElectricalGroups {
  std::vector<int> id;  ///< by node: smallest index in its group (D 6.41)
  /// V, by node: prescribed potential of its group; empty: the group floats
  std::vector<std::optional<double>> potential;
  /// By node: first of potential_sources_of that is connected with its component, -1 if it floats. Components at one
  /// prescribed potential are one group, but each of them has its own source that collects its charge. If several
  /// sources are connected with one component, the division of charge among them is undetermined, and the first takes
  /// it all.
  std::vector<int> supply;
  /// By conductor: smallest index of the conductors that contacts and wires connect with it. -1 if they connect it with
  /// a terminal or the source of a wire. Connected conductors are in different equipotential groups if a contact does
  /// not join its bodies.
  std::vector<int> connected;
  friend bool operator==(const ElectricalGroups&, const ElectricalGroups&) = default;
};

/// Returns true if a conductor is in one equipotential group with a terminal. A terminal behind a resistor does not
/// have the potential of its source.
bool shares_group(const ElectricalGroups& groups, int conductor, const Terminal& terminal);

/// Returns the effect that gives contacts their conductance (EffectKind::sharing). Null: all contacts join their bodies
/// to one equipotential group.
const EffectKind* sharing_effect(const Scene& scene);

/// Returns the law of a contact. Throws InputError for a conductance below 0.
SharingLaw sharing_law(const Scene& scene, Contact contact);

/// Returns the connected components of wires (the scene's [[group]]s) and joining contacts. A component has the
/// potential of a wire at a prescribed potential or of a terminal without a resistor in it. Throws InputError for a
/// short circuit between two potentials.
ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts);

/// Returns true if `after` splits a group of `before`: conductors of one group, or a group and its prescribed
/// potential.
bool splits_group(const ElectricalGroups& before, const ElectricalGroups& after);

}  // namespace lichtenberg::effects
