#include "src/effects/electrostatics.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace lichtenberg::effects {
namespace {

/// Returns true for a resistor between nodes of one equipotential group, which carries no current.
bool is_within_group(const Resistor& resistor, const ElectricalGroups& groups) {
  return resistor.b >= 0 && groups.id[resistor.a] == groups.id[resistor.b];
}

}  // namespace

NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth) {
  NodeGroups nodes;
  find_groups_of_nodes(groups, charges, depth, nodes);
  return nodes;
}

/// Converts equipotential groups to groups of a field problem. The loops have no branches on group membership, because
/// branch prediction fails for many small groups.
void find_groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth, NodeGroups& nodes) {
  const std::size_t n = groups.id.size();
  nodes.group_of_node.resize(n);
  nodes.groups.resize(n + 1);  // one extra element, because the next group is written before it is known to exist
  int found = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_first = groups.id[i] == static_cast<int>(i);
    nodes.groups[found] = {.floating = !groups.potential[i], .potential = groups.potential[i].value_or(0)};
    nodes.group_of_node[i] = found;
    nodes.group_of_node[i] = nodes.group_of_node[groups.id[i]];
    found += is_first;
  }
  nodes.groups.resize(found);
  for (std::size_t i = 0; i < std::min(n, charges.charge.size()); ++i) {
    laplace::Group& group = nodes.groups[nodes.group_of_node[i]];
    group.charge += group.floating ? charges.charge[i] / depth : 0;
  }
  if (charges.supply_potential.empty()) return;
  for (std::size_t i = 0; i < n; ++i)
    if (const int supply = groups.supply[i]; supply >= 0)
      nodes.groups[nodes.group_of_node[i]].potential = charges.supply_potential[supply];
}

std::vector<FloatingSides> floating_sides(const Scene& scene, const std::vector<int>& group_of_node) {
  std::vector<FloatingSides> all;
  const std::size_t first_circuit = group_of_node.size() - scene.circuits.size();
  for (int s = 0; s < static_cast<int>(scene.domain.sides.size()); ++s) {
    const int circuit = scene.domain.sides[s].circuit;
    if (circuit < 0) continue;
    const int group = group_of_node[first_circuit + circuit];
    const auto found = std::ranges::find(all, group, &FloatingSides::group);
    if (found != all.end())
      found->sides.push_back(s);
    else
      all.push_back({group, {s}});
  }
  return all;
}

std::array<double, 6> side_potentials(const Scene& scene, const NodeCharges& charges) {
  std::array<double, 6> potential{};
  int supply = static_cast<int>(scene.electrodes.size());
  for (std::size_t s = 0; s < potential.size(); ++s) {
    const DomainSide& side = scene.domain.sides[s];
    potential[s] = side.electrode ? charges.potential_of(supply++, side.potential.value) : side.potential.value;
  }
  return potential;
}

std::vector<double> circuit_potentials(const std::vector<double>& group_potential,
                                       const std::vector<int>& group_of_node, std::size_t conductors) {
  std::vector<double> potential;
  for (std::size_t node = conductors; node < group_of_node.size(); ++node)
    potential.push_back(group_potential[group_of_node[node]]);
  return potential;
}

void add_couplings(const ElectricalGroups& groups, const NodeCharges& charges, const std::vector<int>& group_of_node,
                   double depth, std::vector<laplace::Group>& to, std::vector<laplace::Coupling>& couplings) {
  std::map<int, int> group_of_supply;
  for (const Resistor& resistor : charges.resistors) {
    if (is_within_group(resistor, groups)) continue;
    int b = 0;
    if (resistor.b >= 0) {
      b = group_of_node[resistor.b];
    } else {
      const auto [known, is_new] = group_of_supply.try_emplace(resistor.supply, static_cast<int>(to.size()));
      if (is_new)
        to.push_back({.floating = false, .potential = charges.potential_of(resistor.supply, resistor.potential)});
      b = known->second;
    }
    couplings.push_back({group_of_node[resistor.a], b, charges.weight * resistor.conductance / depth});
  }
  const std::size_t first = group_of_node.size() - charges.capacitance.size();
  int ground = -1;
  for (std::size_t c = 0; c < charges.capacitance.size(); ++c) {
    if (charges.capacitance[c] == 0) continue;
    if (ground < 0) ground = static_cast<int>(to.size()), to.push_back({.floating = false});
    couplings.push_back({group_of_node[first + c], ground, charges.capacitance[c] / depth});
  }
}

void add_circuits(const std::vector<Terminal>& terminals, const NodeCharges& charges, std::vector<double> potential,
                  Electrostatics& result) {
  const int first = static_cast<int>(result.potential.size());
  result.circuit_charge.assign(potential.size(), 0);
  for (std::size_t t = 0; t < terminals.size(); ++t)
    if (const int node = terminals[t].node; node >= 0) {
      result.circuit_charge[node - first] += result.terminal_charge[t];
      result.terminal_potential[t] = potential[node - first];
    }
  for (std::size_t c = 0; c < charges.capacitance.size(); ++c) {
    result.circuit_charge[c] += charges.capacitance[c] * potential[c];
    result.energy += 0.5 * charges.capacitance[c] * potential[c] * potential[c];
  }
  result.circuit_potential = std::move(potential);
  result.supply_potential = charges.supply_potential;
}

std::vector<double> carried_by_resistors(const ElectricalGroups& groups, const NodeCharges& charges,
                                         const std::vector<double>& flowed, double depth) {
  std::vector<double> carried;
  auto next = flowed.begin();
  for (const Resistor& resistor : charges.resistors)
    carried.push_back(is_within_group(resistor, groups) ? 0 : depth * *next++);
  return carried;
}

void neutralize(std::vector<laplace::Group>& groups) {
  double net = 0;
  int floating = 0;
  for (const laplace::Group& group : groups)
    if (group.floating) net += group.charge, ++floating;
  for (laplace::Group& group : groups)
    if (group.floating) group.charge -= net / floating;
}

void set_level(Electrostatics& field, const NodeCharges& charges) {
  const int conductors = static_cast<int>(field.potential.size());
  double missing = charges.injected_current, conductance = 0;
  for (const Resistor& resistor : charges.resistors) {
    if (resistor.b >= 0) continue;
    const double potential =
        resistor.a < conductors ? field.potential[resistor.a] : field.circuit_potential[resistor.a - conductors];
    const double supply = charges.potential_of(resistor.supply, resistor.potential);
    missing -= resistor.conductance * (potential - supply) + resistor.source;
    conductance += resistor.conductance;
  }
  if (conductance == 0) return;
  for (std::vector<double>* potentials : {&field.potential, &field.terminal_potential, &field.circuit_potential})
    for (double& potential : *potentials) potential += missing / conductance;
}

}  // namespace lichtenberg::effects
