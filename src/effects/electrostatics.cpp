#include "src/effects/electrostatics.hpp"

namespace lichtenberg::effects {

NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth) {
  NodeGroups nodes{.groups = {}, .of_node = std::vector<int>(groups.id.size())};
  for (std::size_t i = 0; i < groups.id.size(); ++i) {
    if (groups.id[i] == static_cast<int>(i)) {
      nodes.of_node[i] = static_cast<int>(nodes.groups.size());
      nodes.groups.push_back({.floating = !groups.potential[i], .potential = groups.potential[i].value_or(0)});
    }
    nodes.of_node[i] = nodes.of_node[groups.id[i]];
    laplace::Group& group = nodes.groups[nodes.of_node[i]];
    if (group.floating && i < charges.charge.size()) group.charge += charges.charge[i] / depth;
  }
  return nodes;
}

}  // namespace lichtenberg::effects
