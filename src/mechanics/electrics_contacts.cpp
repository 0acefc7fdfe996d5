// Contacts that are made and lost: the groups that they join, and the order of events.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"
#include "src/mechanics/electrics.hpp"

namespace lichtenberg::mechanics {

Regrouping Electrics::reconnect(double time, double due_since, FieldGrid grid) {
  if (!discharge_) return {};
  const auto [made, lost] = detect_contact_events();
  if (made.empty() && lost.empty()) return {};
  std::vector<Merger> due = mergers(made, time, due_since);
  const std::vector<effects::Contact> later = lost_after(due, lost, time);
  const bool later_parts = !later.empty() && restore_contacts(later);
  const bool merged = regroup(time, grid);
  if (later_parts) {
    remove_contacts(later);
    regroup(time, grid);
  }
  return merged ? Regrouping{true, std::move(due)} : Regrouping{};
}

/// Restores lost contacts until the group merges are done. Returns false, without a change, if they make a short
/// circuit: the order of two events of a conductor between two electrodes is known only to within a position tolerance.
bool Electrics::restore_contacts(std::span<const effects::Contact> lost) {
  const auto first_added = now_.contacts.insert(now_.contacts.end(), lost.begin(), lost.end());
  std::inplace_merge(now_.contacts.begin(), first_added, now_.contacts.end());
  const auto other = [&](const effects::PotentialSource& supply) {
    return !(supply.potential == supplies_.front().potential);
  };
  if (std::ranges::none_of(supplies_, other)) return true;
  try {
    effects::electrical_groups(scene_, now_.contacts);
    return true;
  } catch (const InputError&) {
    remove_contacts(lost);
    return false;
  }
}

void Electrics::remove_contacts(std::span<const effects::Contact> lost) {
  std::erase_if(now_.contacts, [&](effects::Contact contact) { return std::ranges::binary_search(lost, contact); });
}

effects::ContactDischarge::Changes Electrics::detect_contact_events() {
  const Stopwatch watch(counters_.contact_seconds);
  effects::ContactDischarge::Changes changes = discharge_->update(model_.bodies, now_.contacts);
  counters_.contacts_made += std::ssize(changes.made);
  counters_.contacts_lost += std::ssize(changes.lost);
  return changes;
}

/// Returns the lost contacts that opened after the first group merge was due, in ascending order as `lost`. A contact
/// that no longer opens has no known time of loss and counts as earlier.
std::vector<effects::Contact> Electrics::lost_after(std::span<const Merger> mergers,
                                                    std::span<const effects::Contact> lost, double time) const {
  if (mergers.empty()) return {};
  const double first = std::ranges::min(mergers, {}, &Merger::due).due;
  std::vector<effects::Contact> later;
  for (const effects::Contact contact : lost) {
    const double beyond = discharge_->gap(model_.bodies, contact) - discharge_->release_gap(),
                 opening = discharge_->gap_rate(model_.bodies, contact);
    if (opening > 0 && time - beyond / opening >= first) later.push_back(contact);
  }
  return later;
}

/// Updates the equipotential groups to the present contacts. If groups have merged, charges move: solves and accepts
/// the new field and returns true.
bool Electrics::regroup(double time, FieldGrid grid) {
  effects::ElectricalGroups before;
  {
    const Stopwatch watch(counters_.contact_seconds);
    try {
      before = std::exchange(now_.groups, effects::electrical_groups(scene_, now_.contacts));
    } catch (const InputError& error) {
      throw Failure(fmt::format("at t = {:.6g} s {}", time, error.what()));
    }
  }
  const bool changed = !(now_.groups == before);
  resistors_.update(changed);
  if (!changed) return false;
  ++counters_.regroupings;
  if (!effects::splits_group(now_.groups, before)) return false;
  accept(solve(time, grid), true);
  return true;
}

/// Returns the contacts that merge groups, with the times at which they were due, in this order. A contact between
/// groups that earlier ones have merged is left out.
std::vector<Merger> Electrics::mergers(std::span<const effects::Contact> made, double time, double due_since) const {
  std::vector<Merger> all;
  for (const effects::Contact contact : made) {
    if (discharge_->are_joined(now_.groups, model_.bodies.size(), contact)) continue;
    if (!effects::sharing_law(scene_, contact).joins()) continue;
    const double beyond = discharge_->make_gap() - discharge_->gap(model_.bodies, contact),
                 closing = -discharge_->gap_rate(model_.bodies, contact);
    all.push_back({contact, closing > 0 ? std::max(due_since, time - beyond / closing) : due_since});
  }
  std::ranges::stable_sort(all, {}, &Merger::due);
  const int nodes = static_cast<int>(now_.groups.id.size());
  DisjointSets joined(nodes + static_cast<int>(supplies_.size()));
  std::erase_if(all, [&](const Merger& merger) {
    const auto [a, b] = groups_of(merger.contact);
    return !joined.unite(a, b);
  });
  return all;
}

/// Returns the numbers of the two groups of a contact. Groups at a prescribed potential have numbers above all nodes.
std::pair<int, int> Electrics::groups_of(effects::Contact contact) const {
  const auto group_at_source = [&](int supply) {
    return static_cast<int>(std::ssize(now_.groups.id)) + now_.groups.same_source[supply];
  };
  const auto group_of_node = [&](int node) {
    const int supply = now_.groups.supply[node];
    return supply >= 0 ? group_at_source(supply) : now_.groups.id[node];
  };
  const int a = group_of_node(contact.conductor), terminal = contact.partner - model_.bodies.size();
  if (terminal < 0) return {a, group_of_node(contact.partner)};
  return {a, terminals_[terminal].node >= 0 ? group_of_node(terminals_[terminal].node) : group_at_source(terminal)};
}

}  // namespace lichtenberg::mechanics
