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
  Signal potential = 0;          ///< potential of the source (V); of a circuit: that of its source, 0 without one
  double series_resistance = 0;  ///< resistance between source and surface (ohm); 0: connected directly
  int node = -1;                 ///< node of ElectricalGroups behind a series resistor or in a circuit; -1: none
  int supply = -1;               ///< its index in potential_sources_of()
};

/// Returns the terminals of a scene: the electrodes in the scene's order, then the sides of the domain that are
/// electrodes.
std::vector<Terminal> terminals_of(const Scene& scene);

/// A circuit's node: one potential and one charge of its own, for electrodes, sides and wires together. The node of an
/// electrode behind a series resistor has the electrode alone.
struct CircuitNode {
  int node = 0;    ///< node of ElectricalGroups
  int supply = 0;  ///< index of its source in potential_sources_of()
  Circuit circuit;
};

/// Returns the circuits' nodes: those of electrodes behind a series resistor in the scene's order, then those of the
/// scene's circuits.
std::vector<CircuitNode> circuit_nodes(const Scene& scene);

/// Returns the charges (C) of all nodes at the start: those of the conductors (initial_charges), then those of the
/// circuits' nodes.
std::vector<double> initial_node_charges(const Scene& scene);

/// Returns the number of nodes with a potential and charge of their own: conductors, and circuit_nodes().
int node_count(const Scene& scene);

/// A potential source (voltage supply), which fixes the potential of conductors and supplies or collects their charge.
struct PotentialSource {
  std::string name;
  Signal potential = 0;  ///< V
  /// False for a terminal in a circuit, whose source is the circuit's, and for a circuit without a voltage source.
  bool is_source = true;
};

/// Returns the potential sources of a scene: one for each terminal (electrode or electrode side), in their order. Then
/// follows one for each wire (the scene's [[group]]) at a prescribed potential, and one for each of the scene's
/// circuits.
std::vector<PotentialSource> potential_sources_of(const Scene& scene);

/// Returns the potentials (V) of all sources at `time` (s); empty if none of them varies in time. `after`: the limit
/// from later times at a jump.
std::vector<double> potentials_at(const std::vector<PotentialSource>& supplies, double time, bool after);

/// Equipotential groups of nodes, which contacts and wires connect. Nodes are the conductors, then circuit_nodes(). All
/// nodes at the same prescribed potential are one group, whether they touch or not.
struct ElectricalGroups {
  std::vector<int> id;  ///< for each node: smallest index in its group
  /// For each node: prescribed potential (V) of its group, at time 0 if it varies; empty: the group floats
  std::vector<std::optional<double>> potential;
  /// For each node: index in potential_sources_of() of the source that is connected with it; -1 if it floats. Separate
  /// components at one prescribed potential are one group, but each of them has its own source that collects its
  /// charge. If several sources are connected with one component, the division of charge among them is undetermined,
  /// and the first takes it all.
  std::vector<int> supply;
  /// For each potential source: the first source with the same potential at all times
  std::vector<int> same_source{};
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
