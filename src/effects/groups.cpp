#include "src/effects/groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"
#include "solvers/geometry/box.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/circuits.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {
namespace {

/// Potential source of each connected component of nodes. A component is named by its smallest node index.
class SourceAssignment {
 public:
  SourceAssignment(const Scene& scene, std::size_t nodes)
      : path_(scene.path), supplies_(potential_sources_of(scene)), source_(nodes, -1) {}
  /// Connects a source with a component. Throws InputError if the component has a source of another potential.
  void add(int component, int supply) {
    int& assigned = source_[component];
    if (assigned < 0) assigned = supply;
    const PotentialSource &first = supplies_[assigned], &other = supplies_[supply];
    if (!(first.potential == other.potential))
      throw InputError(
          fmt::format("the group of conductor {} connects {} at {} with {} at {}: a short circuit of perfect "
                      "conductors, whose current has no limit, is not allowed: the scene {} gives them these "
                      "potentials, in electrode.potential, the side's potential in [domain] or group.potential",
                      component, first.name, in_words(first.potential), other.name, in_words(other.potential), path_));
    assigned = std::min(assigned, supply);
  }
  /// Returns the index of the component's first source; -1: none.
  int supply(int component) const { return source_[component]; }
  /// Returns the potential (V) of a component that has a source.
  double potential(int component) const { return supplies_[supply(component)].potential.value; }
  /// Returns ElectricalGroups::same_source.
  std::vector<int> same_source() const {
    std::vector<int> first;
    std::multimap<double, int> by_value;  // sources that differ from earlier ones
    for (int k = 0; k < static_cast<int>(supplies_.size()); ++k) {
      const Signal& own = supplies_[k].potential;
      const auto [from, to] = by_value.equal_range(own.value);
      const auto same =
          std::find_if(from, to, [&](const auto& other) { return supplies_[other.second].potential == own; });
      first.push_back(same == to ? k : same->second);
      if (same == to) by_value.emplace(own.value, k);
    }
    return first;
  }

 private:
  std::string path_;
  std::vector<PotentialSource> supplies_;
  std::vector<int> source_;
};

/// Returns the connected components of the nodes, which wires and the given contacts connect.
DisjointSets connect(const Scene& scene, std::span<const Contact> contacts, const std::vector<Terminal>& terminals) {
  const int n = static_cast<int>(scene.conductors.size());
  DisjointSets sets(node_count(scene));
  std::vector<int> first_of_wire(scene.groups.size(), -1);
  for (int i = 0; i < n && !scene.groups.empty(); ++i) {
    const int wire = scene.conductors[i].group;
    if (wire < 0) continue;
    if (first_of_wire[wire] < 0) first_of_wire[wire] = i;
    sets.unite(first_of_wire[wire], i);
    if (const int circuit = scene.groups[wire].circuit; circuit >= 0)
      sets.unite(i, node_count(scene) - static_cast<int>(scene.circuits.size()) + circuit);
  }
  for (const Contact& contact : contacts) {
    const int partner = contact.partner < n ? contact.partner : terminals[contact.partner - n].node;
    if (partner >= 0) sets.unite(contact.conductor, partner);
  }
  return sets;
}

/// Returns the index of each wire's potential source, -1: none.
std::vector<int> wire_sources(const Scene& scene, const std::vector<Terminal>& terminals) {
  std::vector<int> supply;
  int next = static_cast<int>(terminals.size());
  for (const PrescribedGroup& wire : scene.groups) supply.push_back(wire.potential ? next++ : -1);
  return supply;
}

/// Calls add(conductor, supply) for each conductor that a wire or a contact joins to a potential source.
void for_each_source_connection(const Scene& scene, std::span<const Contact> contacts,
                                const std::vector<Terminal>& terminals, const auto& add) {
  const int n = static_cast<int>(scene.conductors.size());
  const std::vector<int> supply_of_wire = wire_sources(scene, terminals);
  for (int i = 0; i < n && !scene.groups.empty(); ++i)
    if (const int wire = scene.conductors[i].group; wire >= 0 && supply_of_wire[wire] >= 0)
      add(i, supply_of_wire[wire]);
  for (const Contact& contact : contacts)
    if (contact.partner >= n && terminals[contact.partner - n].node < 0) add(contact.conductor, contact.partner - n);
}

/// Returns ElectricalGroups::connected. `sets`: connected components of `contacts` and wires.
std::vector<int> connections(const Scene& scene, std::span<const Contact> contacts,
                             const std::vector<Terminal>& terminals, DisjointSets sets) {
  const int n = static_cast<int>(scene.conductors.size());
  std::vector<char> grounded(node_count(scene));
  for (const CircuitNode& circuit : circuit_nodes(scene))
    if (circuit.circuit.resistance > 0) grounded[sets.find(circuit.node)] = true;
  for_each_source_connection(scene, contacts, terminals, [&](int i, int) { grounded[sets.find(i)] = true; });
  std::vector<int> connected(n);
  for (int i = 0; i < n; ++i) {
    const int component = sets.find(i);
    connected[i] = grounded[component] ? -1 : component;
  }
  return connected;
}

}  // namespace

std::vector<Terminal> terminals_of(const Scene& scene) {
  std::vector<Terminal> terminals;
  int next_node = static_cast<int>(scene.conductors.size());
  const int first_circuit = node_count(scene) - static_cast<int>(scene.circuits.size());
  const auto connect_to_circuit = [&](Terminal& terminal, int circuit) {
    if (circuit < 0) return;
    terminal.potential = scene.circuits[circuit].potential;
    terminal.node = first_circuit + circuit;
  };
  for (const Electrode& electrode : scene.electrodes) {
    terminals.push_back({fmt::format("the electrode \"{}\"", electrode.name), surface_of(electrode, scene.domain),
                         electrode.potential, electrode.series_resistance,
                         electrode.series_resistance > 0 ? next_node++ : -1});
    connect_to_circuit(terminals.back(), electrode.circuit);
  }
  const std::vector<Surface> sides = sides_of(scene.domain);
  for (std::size_t s = 0; s < sides.size(); ++s)
    if (scene.domain.sides[s].electrode) {
      terminals.push_back(
          {fmt::format("the {} side of the domain", side_names[s]), sides[s], scene.domain.sides[s].potential});
      connect_to_circuit(terminals.back(), scene.domain.sides[s].circuit);
    }
  for (std::size_t t = 0; t < terminals.size(); ++t) terminals[t].supply = static_cast<int>(t);
  return terminals;
}

std::vector<CircuitNode> circuit_nodes(const Scene& scene) {
  std::vector<CircuitNode> nodes;
  int node = static_cast<int>(scene.conductors.size());
  for (std::size_t e = 0; e < scene.electrodes.size(); ++e)
    if (const Electrode& electrode = scene.electrodes[e]; electrode.series_resistance > 0)
      nodes.push_back(
          {node++, static_cast<int>(e),
           Circuit{
               .name = electrode.name, .resistance = electrode.series_resistance, .potential = electrode.potential}});
  if (scene.circuits.empty()) return nodes;
  int supply = static_cast<int>(scene.electrodes.size());
  supply += static_cast<int>(std::ranges::count_if(scene.domain.sides, &DomainSide::electrode));
  supply += static_cast<int>(
      std::ranges::count_if(scene.groups, [](const PrescribedGroup& wire) { return wire.potential.has_value(); }));
  for (const Circuit& circuit : scene.circuits) nodes.push_back({node++, supply++, circuit});
  return nodes;
}

std::vector<double> initial_node_charges(const Scene& scene) {
  std::vector<double> charge = initial_charges(scene);
  for (const CircuitNode& node : circuit_nodes(scene)) charge.push_back(node.circuit.charge);
  return charge;
}

int node_count(const Scene& scene) {
  const auto resistors = std::ranges::count_if(scene.electrodes, [](auto& e) { return e.series_resistance > 0; });
  return static_cast<int>(scene.conductors.size() + scene.circuits.size()) + static_cast<int>(resistors);
}

std::vector<PotentialSource> potential_sources_of(const Scene& scene) {
  std::vector<PotentialSource> supplies;
  const int first_circuit = node_count(scene) - static_cast<int>(scene.circuits.size());
  for (const Terminal& terminal : terminals_of(scene)) {
    const bool in_circuit = terminal.node >= first_circuit;
    supplies.push_back({terminal.name, in_circuit ? Signal(0) : terminal.potential, !in_circuit});
  }
  for (const PrescribedGroup& wire : scene.groups)
    if (wire.potential) supplies.push_back({fmt::format("the group \"{}\"", wire.name), *wire.potential});
  for (const Circuit& circuit : scene.circuits)
    supplies.push_back({fmt::format("the circuit \"{}\"", circuit.name), circuit.potential, circuit.resistance > 0});
  return supplies;
}

std::vector<double> potentials_at(const std::vector<PotentialSource>& supplies, double time, bool after) {
  std::vector<double> potentials;
  if (std::ranges::none_of(supplies, [](const PotentialSource& supply) { return supply.potential.varies(); }))
    return potentials;
  for (const PotentialSource& supply : supplies) potentials.push_back(supply.potential.at(time, after));
  return potentials;
}

const EffectKind* sharing_effect(const Scene& scene) {
  const auto found = std::ranges::find_if(scene.effects, [](const auto& effect) { return effect.kind->sharing; });
  return found == scene.effects.end() ? nullptr : found->kind;
}

SharingLaw sharing_law(const Scene& scene, Contact contact) {
  const EffectKind* kind = sharing_effect(scene);
  if (!kind) return {};
  const SharingLaw law = kind->sharing(scene, contact);
  if (law.conductance >= 0) return law;
  throw InputError(fmt::format("{}: effects.{} gives a contact a conductance of {:g} S: it must be at least 0",
                               scene.path, kind->name, law.conductance));
}

ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts) {
  const std::vector<Terminal> terminals = terminals_of(scene);
  const bool all_join = !sharing_effect(scene);
  std::vector<Contact> joining, conducting;
  for (const Contact contact : all_join ? std::span<const Contact>() : contacts) {
    const SharingLaw law = sharing_law(scene, contact);
    if (law.joins()) joining.push_back(contact);
    if (!law.isolates()) conducting.push_back(contact);
  }
  const std::span<const Contact> joined = all_join ? contacts : joining;
  DisjointSets sets = connect(scene, joined, terminals);
  SourceAssignment assignment(scene, node_count(scene));
  for_each_source_connection(scene, joined, terminals,
                             [&](int i, int supply) { assignment.add(sets.find(i), supply); });

  const int nodes = node_count(scene);
  ElectricalGroups groups{.id = std::vector<int>(nodes),
                          .potential = std::vector<std::optional<double>>(nodes),
                          .supply = std::vector<int>(nodes),
                          .same_source = assignment.same_source(),
                          .connected = {}};
  std::map<int, int> first_at_source;
  for (int i = 0; i < nodes; ++i) {
    const int group = sets.find(i);  // first node of the component, which has been processed before the others
    groups.supply[i] = assignment.supply(group);
    groups.id[i] = group;
    if (groups.supply[i] < 0) continue;
    groups.potential[i] = assignment.potential(group);
    groups.id[i] = first_at_source.try_emplace(groups.same_source[groups.supply[i]], i).first->second;
  }
  groups.connected = all_join ? connections(scene, contacts, terminals, std::move(sets))
                              : connections(scene, conducting, terminals, connect(scene, conducting, terminals));
  return groups;
}

bool shares_group(const ElectricalGroups& groups, int conductor, const Terminal& terminal) {
  if (terminal.node >= 0) return groups.id[conductor] == groups.id[terminal.node];
  const int supply = groups.supply[conductor];
  return supply >= 0 && groups.same_source[supply] == groups.same_source[terminal.supply];
}

bool splits_group(const ElectricalGroups& before, const ElectricalGroups& after) {
  const auto keeps_source = [&](std::size_t i) {
    if (before.potential[i] != after.potential[i]) return false;
    return before.supply.empty() || before.same_source[before.supply[i]] == after.same_source[after.supply[i]];
  };
  // A group's id is its first conductor, so every other member must still be grouped with it.
  for (std::size_t i = 0; i < before.id.size(); ++i)
    if (after.id[i] != after.id[before.id[i]] || (before.potential[i] && !keeps_source(i))) return true;
  return false;
}

}  // namespace lichtenberg::effects
