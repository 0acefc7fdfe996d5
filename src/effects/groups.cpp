#include "src/effects/groups.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg::effects {
namespace {

/// Disjoint sets whose representative is their smallest member.
class Sets {
 public:
  explicit Sets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

/// What holds each component at its potential, by the component's first conductor.
class Holders {
 public:
  explicit Holders(std::vector<Supply> supplies) : supplies_(std::move(supplies)) {}
  void add(int component, int supply) {
    const auto [held, is_new] = holders_.try_emplace(component, supply);
    const Supply &first = supplies_[held->second], &other = supplies_[supply];
    if (first.potential != other.potential)
      throw InputError(
          fmt::format("the group of conductor {} connects {} at {:g} V with {} at {:g} V: a short circuit of perfect "
                      "conductors, whose current has no limit, is not allowed",
                      component, first.name, first.potential, other.name, other.potential));
    held->second = std::min(held->second, supply);
  }
  /// -1: none.
  int supply(int component) const {
    const auto held = holders_.find(component);
    return held == holders_.end() ? -1 : held->second;
  }
  std::optional<double> potential(int component) const {
    const int held_by = supply(component);
    return held_by < 0 ? std::nullopt : std::optional(supplies_[held_by].potential);
  }

 private:
  std::vector<Supply> supplies_;
  std::map<int, int> holders_;
};

Sets connect(const Scene& scene, std::span<const Contact> contacts) {
  const int n = static_cast<int>(scene.conductors.size());
  Sets sets(n);
  std::vector<int> first_of_wire(scene.groups.size(), -1);
  for (int i = 0; i < n; ++i) {
    const int wire = scene.conductors[i].group;
    if (wire < 0) continue;
    if (first_of_wire[wire] < 0) first_of_wire[wire] = i;
    sets.unite(first_of_wire[wire], i);
  }
  for (const Contact& contact : contacts)
    if (contact.partner < n) sets.unite(contact.conductor, contact.partner);
  return sets;
}

}  // namespace

std::vector<Terminal> terminals_of(const Scene& scene) {
  static constexpr const char* side_names[] = {"left", "right", "bottom", "top"};
  std::vector<Terminal> terminals;
  for (const Electrode& electrode : scene.electrodes)
    terminals.push_back(
        {fmt::format("the electrode \"{}\"", electrode.name), surface_of(electrode.shape), electrode.potential});
  const std::array<Surface, 4> sides = sides_of(scene.domain);
  for (std::size_t s = 0; s < sides.size(); ++s)
    if (scene.domain.sides[s].electrode)
      terminals.push_back(
          {fmt::format("the {} side of the domain", side_names[s]), sides[s], scene.domain.sides[s].potential});
  return terminals;
}

std::vector<Supply> supplies_of(const Scene& scene) {
  std::vector<Supply> supplies;
  for (const Terminal& terminal : terminals_of(scene)) supplies.push_back({terminal.name, terminal.potential});
  for (const PrescribedGroup& wire : scene.groups)
    if (wire.potential) supplies.push_back({fmt::format("the group \"{}\"", wire.name), *wire.potential});
  return supplies;
}

ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts) {
  const int n = static_cast<int>(scene.conductors.size());
  Sets sets = connect(scene, contacts);
  std::vector<int> supply_of_wire;  // -1: it floats
  int next = static_cast<int>(terminals_of(scene).size());
  for (const PrescribedGroup& wire : scene.groups) supply_of_wire.push_back(wire.potential ? next++ : -1);
  Holders holders(supplies_of(scene));
  for (int i = 0; i < n; ++i)
    if (const int wire = scene.conductors[i].group; wire >= 0 && supply_of_wire[wire] >= 0)
      holders.add(sets.find(i), supply_of_wire[wire]);
  for (const Contact& contact : contacts)
    if (contact.partner >= n) holders.add(sets.find(contact.conductor), contact.partner - n);

  ElectricalGroups groups;
  std::map<double, int> first_held_at;
  for (int i = 0; i < n; ++i) {
    const int group = sets.find(i);
    groups.potential.push_back(holders.potential(group));
    groups.supply.push_back(holders.supply(group));
    groups.id.push_back(groups.potential[i] ? first_held_at.try_emplace(*groups.potential[i], i).first->second : group);
  }
  return groups;
}

bool parts(const ElectricalGroups& before, const ElectricalGroups& after) {
  // A group's id is its first conductor: all others must have stayed with it.
  for (std::size_t i = 0; i < before.id.size(); ++i)
    if (after.id[i] != after.id[before.id[i]] || (before.potential[i] && after.potential[i] != before.potential[i]))
      return true;
  return false;
}

}  // namespace lichtenberg::effects
