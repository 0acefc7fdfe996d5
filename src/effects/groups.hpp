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

/// Something at a given potential that conductors can touch: an electrode, or a side of the domain that is one.
struct Terminal {
  std::string name;
  Surface surface;
  double potential = 0;          ///< V, of the supply if there is a resistor
  double series_resistance = 0;  ///< ohm, between supply and surface; 0: none
  int node = -1;                 ///< of ElectricalGroups, if there is a resistor
};

/// The electrodes in the scene's order, then those sides of the domain that are electrodes.
std::vector<Terminal> terminals_of(const Scene& scene);

/// Conductors, and terminals behind a resistor.
int node_count(const Scene& scene);

/// What holds conductors at a potential from outside, and takes or gives their charge.
struct Supply {
  std::string name;
  double potential = 0;  ///< V
};

/// The terminals, in their order, then the wires (the scene's [[group]]s) that are held at a potential.
std::vector<Supply> supplies_of(const Scene& scene);

/// Which nodes - the conductors, then the terminals behind a resistor - are one electrically. All that are held at one
/// potential are, whether they touch or not.
struct ElectricalGroups {
  std::vector<int> id;                           ///< by node: the smallest index in its group (D 6.41)
  std::vector<std::optional<double>> potential;  ///< V, by node: what holds its group; empty: the group floats
  /// By node: the first of supplies_of that its component is connected with, -1 if it floats. Components held at
  /// one potential are one group, but each drains to a supply of its own; several in one component have one potential,
  /// and how their charge is shared cannot be known: the first takes it all.
  std::vector<int> supply;
  /// By conductor: the smallest index of those that contacts and wires connect it with, -1 if they connect it with a
  /// terminal or what holds a wire. Not one electrically where a contact does not join its two.
  std::vector<int> connected;
  friend bool operator==(const ElectricalGroups&, const ElectricalGroups&) = default;
};

/// Whether a conductor is one electrically with a terminal. What a resistor stands before has not the supply's
/// potential.
bool is_one(const ElectricalGroups& groups, int conductor, const Terminal& terminal);

/// The effect whose law contacts follow (EffectKind::sharing). Null: they all join their two.
const EffectKind* sharing_effect(const Scene& scene);

/// The law of a contact.
SharingLaw sharing_law(const Scene& scene, Contact contact);

/// Connected components of wires (the scene's [[group]]s) and contacts that join their two; a component takes the
/// potential of a wire with a given potential or of a terminal without a resistor in it. Throws InputError for a short
/// circuit between two potentials.
ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts);

/// Whether `after` parts what is one in `before`: conductors of one group, or a group and the potential that holds it.
bool parts(const ElectricalGroups& before, const ElectricalGroups& after);

}  // namespace lichtenberg::effects
