// Contacts made and lost: whom they join, when they are events, and what happens first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/step_control.hpp"

namespace lichtenberg::mechanics {

Regrouping Electrics::reconnect(double time, double due_since, FieldGrid grid) {
  if (!discharge_) return {};
  const auto [made, lost] = look_at_contacts();
  if (made.empty() && lost.empty()) return {};
  std::vector<Merger> due = mergers(made, time, due_since);
  const std::vector<effects::Contact> later = lost_after(due, lost, time);
  const bool later_parts = !later.empty() && keep(later);
  const bool merged = regroup(time, grid);
  if (later_parts) {
    drop(later);
    regroup(time, grid);
  }
  return merged ? Regrouping{true, std::move(due)} : Regrouping{};
}

/// Has contacts again that are lost. Not if that were a short circuit, as of a conductor that one electrode hands over
/// to another: which was first is known to within a tolerance of its way alone. Returns whether.
bool Electrics::keep(std::span<const effects::Contact> lost) {
  const auto first_added = now_.contacts.insert(now_.contacts.end(), lost.begin(), lost.end());
  std::inplace_merge(now_.contacts.begin(), first_added, now_.contacts.end());
  const auto other = [&](const effects::Supply& supply) { return supply.potential != supplies_.front().potential; };
  if (std::ranges::none_of(supplies_, other)) return true;
  try {
    effects::electrical_groups(scene_, now_.contacts);
    return true;
  } catch (const InputError&) {
    drop(lost);
    return false;
  }
}

void Electrics::drop(std::span<const effects::Contact> lost) {
  std::erase_if(now_.contacts, [&](effects::Contact contact) { return std::ranges::binary_search(lost, contact); });
}

effects::ContactDischarge::Changes Electrics::look_at_contacts() {
  const Stopwatch watch(counters_.contact_seconds);
  effects::ContactDischarge::Changes changes = discharge_->update(model_.bodies, now_.contacts);
  counters_.contacts_made += std::ssize(changes.made);
  counters_.contacts_lost += std::ssize(changes.lost);
  return changes;
}

/// Of those that are lost, what was made one before: they part with the charges that they have then. From ascending to
/// ascending order. Of one that goes apart no longer it is not known when it was lost: first.
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

/// Groups as contacts are. Solves if charges move; returns whether.
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
  update_resistors(changed);
  if (!changed) return false;
  ++counters_.regroupings;
  if (!effects::parts(now_.groups, before)) return false;
  accept(solve(time, grid), true);
  return true;
}

/// When these were due, each that makes one of two that the earlier have not.
std::vector<Merger> Electrics::mergers(std::span<const effects::Contact> made, double time, double due_since) const {
  std::vector<Merger> all;
  for (const effects::Contact contact : made) {
    if (discharge_->one_already(now_.groups, model_.bodies.size(), contact)) continue;
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

/// The groups that a contact touches; what is held at a potential is numbered behind the nodes.
std::pair<int, int> Electrics::groups_of(effects::Contact contact) const {
  const auto held_at = [&](double potential) {
    const auto first = std::ranges::find(supplies_, potential, &effects::Supply::potential);
    return static_cast<int>(std::ssize(now_.groups.id) + (first - supplies_.begin()));
  };
  const auto of_node = [&](int node) {
    const std::optional<double> potential = now_.groups.potential[node];
    return potential ? held_at(*potential) : now_.groups.id[node];
  };
  const int a = of_node(contact.conductor), terminal = contact.partner - model_.bodies.size();
  if (terminal < 0) return {a, of_node(contact.partner)};
  return {a,
          terminals_[terminal].node >= 0 ? of_node(terminals_[terminal].node) : held_at(supplies_[terminal].potential)};
}

void Electrics::widen(std::span<double> ways) const {
  for (double& way : ways) way = 1.01 * way + scene_.mechanics.position_tolerance;
}

Lookahead Electrics::look_ahead(std::span<const double> reach, const std::optional<std::vector<int>>& thrown) const {
  if (!discharge_) return {};
  const Stopwatch watch(counters_.contact_seconds);
  Lookahead ahead{.watched = discharge_->watch(model_.bodies, now_.contacts, now_.groups, reach),
                  .least_reach = std::ranges::min(reach)};
  const int d = model_.bodies.dimension;
  const auto foresee = [&](int body) {
    ahead.foreseen.push_back({.body = body, .reach = reach[body]});
    std::copy_n(&model_.bodies.position[body * d], d, ahead.foreseen.back().start.begin());
  };
  // What is neither thrown nor watched is where it was.
  if (thrown)
    for (const int body : *thrown) foresee(body);
  else
    for (int body = 0; body < model_.bodies.size(); ++body) foresee(body);
  for (const Watch& w : ahead.watched)
    for (const int body : {w.contact.conductor, w.contact.partner})
      if (body < model_.bodies.size()) foresee(body);
  return ahead;
}

/// Of `watched`, as long as that is there.
Events Electrics::foreseen_events(std::span<const Watch> watched, bool mergers_wait) const {
  Events events;
  for (const Watch& w : watched) events.direction.push_back(w.made ? +1 : -1);
  events.foreseen_values = [this, watched, mergers_wait](std::span<double> value) {
    for (std::size_t k = 0; k < watched.size(); ++k)
      value[k] = mergers_wait && !watched[k].made ? discharge_->excess_of_waiting(model_.bodies, watched[k])
                                                  : discharge_->excess(model_.bodies, watched[k]);
  };
  for (const Watch& w : watched)
    for (const int body : {w.contact.conductor, w.contact.partner})
      if (body < model_.bodies.size()) events.watched.push_back(body);
  return events;
}

Events Electrics::events(const Lookahead& ahead, bool mergers_wait) const {
  if (!discharge_) return {};
  Events events = foreseen_events(ahead.watched, mergers_wait);
  events.direction.push_back(+1);
  events.values = [this, &ahead, foreseen = events.foreseen_values](std::span<double> value) {
    foreseen(value);
    value.back() = farthest_beyond(ahead.foreseen, -ahead.least_reach);
  };
  events.longest_step = [this, &ahead](std::span<const double> force) { return longest_step(ahead.watched, force); };
  events.only = [this, &ahead, mergers_wait](std::span<const int> numbers) {
    auto some = std::make_shared<std::vector<Watch>>();
    for (const int k : numbers) some->push_back(ahead.watched[k]);
    Events only = foreseen_events(*some, mergers_wait);
    only.values = [some, values = std::exchange(only.foreseen_values, {})](std::span<double> value) { values(value); };
    return only;
  };
  return events;
}

Electrics::Due Electrics::due(const Lookahead& ahead) const {
  Due due;
  for (const Watch& w : ahead.watched) {
    const double excess = discharge_->excess(model_.bodies, w);
    (w.made ? due.lost : due.made) |= w.made ? excess >= 0 : excess <= 0;
  }
  return due;
}

/// The most (m) by which one of these bodies has moved beyond its reach, `farthest` at least. Roots are drawn for those
/// alone that may be it.
double Electrics::farthest_beyond(std::span<const Lookahead::Foreseen> foreseen, double farthest) const {
  const int d = model_.bodies.dimension;
  for (const auto& [body, start, reach] : foreseen) {
    const double* position = &model_.bodies.position[body * d];
    double moved2 = 0;
    for (int k = 0; k < d; ++k) moved2 += (position[k] - start[k]) * (position[k] - start[k]);
    const double least = farthest + reach;
    if (least < 0 || moved2 > least * least) farthest = std::max(farthest, std::sqrt(moved2) - reach);
  }
  return farthest;
}

/// The time (s) in which no watched contact can come and go unseen.
double Electrics::longest_step(const std::vector<Watch>& watched, std::span<const double> force) const {
  const Bodies& bodies = model_.bodies;
  const auto acceleration = [&](int i) { return vector_at(force, bodies.dimension, i) / bodies.mass[i]; };
  double longest = INFINITY;
  for (const Watch& w : watched) {
    const int i = w.contact.conductor, j = w.contact.partner;
    const bool both_move = j < bodies.size();
    const Vec3 v = velocity_in_space(bodies, i) - (both_move ? velocity_in_space(bodies, j) : Vec3{});
    const Vec3 a = acceleration(i) - (both_move ? acceleration(j) : Vec3{});
    longest = std::min(longest, time_to_move(discharge_->blind_way(bodies, w), norm(v), norm(a)));
  }
  return longest;
}

}  // namespace lichtenberg::mechanics
