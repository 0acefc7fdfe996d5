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

/// What holds a group at its potential.
struct Holder {
  std::string name;
  double potential = 0;
};

/// The holder of each group, by the group's id.
class Holders {
 public:
  void add(int group, const Holder& holder) {
    const auto [held, is_new] = holders_.try_emplace(group, holder);
    const Holder& first = held->second;
    if (!is_new && first.potential != holder.potential)
      throw InputError(
          fmt::format("the group of conductor {} connects {} at {:g} V with {} at {:g} V: a short circuit of perfect "
                      "conductors, whose current has no limit, is not allowed",
                      group, first.name, first.potential, holder.name, holder.potential));
  }
  std::optional<double> potential(int group) const {
    const auto held = holders_.find(group);
    return held == holders_.end() ? std::nullopt : std::optional(held->second.potential);
  }

 private:
  std::map<int, Holder> holders_;
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

ElectricalGroups electrical_groups(const Scene& scene, std::span<const Contact> contacts) {
  const int n = static_cast<int>(scene.conductors.size());
  Sets sets = connect(scene, contacts);
  Holders holders;
  for (int i = 0; i < n; ++i) {
    const int wire = scene.conductors[i].group;
    if (wire < 0 || !scene.groups[wire].potential) continue;
    holders.add(sets.find(i),
                {fmt::format("the group \"{}\"", scene.groups[wire].name), *scene.groups[wire].potential});
  }
  const std::vector<Terminal> terminals = terminals_of(scene);
  for (const Contact& contact : contacts)
    if (contact.partner >= n) {
      const Terminal& terminal = terminals[contact.partner - n];
      holders.add(sets.find(contact.conductor), {terminal.name, terminal.potential});
    }

  ElectricalGroups groups;
  std::map<double, int> first_held_at;
  for (int i = 0; i < n; ++i) {
    const int group = sets.find(i);
    groups.potential.push_back(holders.potential(group));
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
