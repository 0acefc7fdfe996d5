#include "src/mechanics/electrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/mechanics/checkpoint.hpp"
#include "src/mechanics/step_control.hpp"

namespace lichtenberg::mechanics {

Electrics::Electrics(const Scene& scene, Model& model, Counters& counters)
    : scene_(scene),
      model_(model),
      counters_(counters),
      field_(*model.find<effects::FloatingConductors>()),
      discharge_(model.find<effects::ContactDischarge>()),
      supplies_(effects::supplies_of(scene)),
      ledger_(model.bodies.charge, supplies_.size()),
      current_(model.bodies.size()) {}

void Electrics::connect() {
  if (discharge_) counters_.contacts_made += discharge_->update(model_.bodies).made;
  groups_ = groups_of(discharge_);
}

effects::ElectricalGroups Electrics::groups_of(const effects::ContactDischarge* discharge) const {
  return effects::electrical_groups(scene_, discharge ? discharge->contacts() : std::vector<effects::Contact>{});
}

void Electrics::charge_bodies(double time) {
  for (int i = 0; i < ledger_.size(); ++i)
    model_.bodies.charge[i] = ledger_.charge(i) + current_[i] * (time - booked_until_);
}

const effects::Electrostatics& Electrics::solve(double time) {
  model_.currents(time, current_);
  charge_bodies(time);
  const Stopwatch watch(counters_.field_seconds);
  field_.solve(model_.bodies, groups_);
  counters_.field_solves = field_.solves();
  counters_.iterations = field_.iterations();
  return field_.last();
}

void Electrics::share(double time, std::span<const double> by_field) {
  model_.currents(time, current_);
  ledger_.feed(current_, time - booked_until_);
  booked_until_ = time;
  ledger_.settle(groups_, by_field);
  charge_bodies(time);
}

void Electrics::settle(double time) {
  share(time, field_.last().charge);
  for (int i = 0; i < ledger_.size(); ++i) {
    largest_force_ = std::max(largest_force_, norm(field_.last().force[i]));
    largest_speed_ = std::max(largest_speed_, norm(velocity(model_.bodies, i)));
  }
}

bool Electrics::reconnect(double time) {
  if (!discharge_) return false;
  const effects::ElectricalGroups before = groups_;
  {
    const Stopwatch watch(counters_.contact_seconds);
    const effects::ContactDischarge::Changes changes = discharge_->update(model_.bodies);
    if (changes.made == 0 && changes.lost == 0) return false;
    counters_.contacts_made += changes.made;
    counters_.contacts_lost += changes.lost;
    try {
      groups_ = groups_of(discharge_);
    } catch (const InputError& error) {
      throw Failure(fmt::format("at t = {:.6g} s {}", time, error.what()));
    }
  }
  if (groups_ == before) return false;
  ++counters_.regroupings;
  if (!effects::parts(groups_, before)) return false;
  solve(time);
  settle(time);
  return true;
}

Events Electrics::events(std::span<const double> travel) const {
  if (!discharge_) return {};
  const Stopwatch watch(counters_.contact_seconds);
  // A little more than it takes: a body that moves exactly as far as it can is no event.
  std::vector<double> reach;
  for (const double way : travel) reach.push_back(1.01 * way + scene_.mechanics.position_tolerance);
  const std::vector<Watch> watched = discharge_->watch(model_.bodies, groups_, reach);
  Events events;
  for (const Watch& w : watched) events.direction.push_back(w.made ? +1 : -1);
  events.direction.push_back(+1);
  events.values = [this, watched, reach, start = model_.bodies.position](std::span<double> value) {
    for (std::size_t k = 0; k < watched.size(); ++k) value[k] = discharge_->excess(model_.bodies, watched[k]);
    value.back() = -INFINITY;
    for (int i = 0; i < model_.bodies.size(); ++i) {
      const Vec2 moved = position(model_.bodies, i) - Vec2{start[2 * i], start[2 * i + 1]};
      value.back() = std::max(value.back(), norm(moved) - reach[i]);
    }
  };
  events.longest_step = [this, watched](std::span<const double> force) { return longest_step(watched, force); };
  return events;
}

/// The time (s) in which no watched contact can come and go unseen.
double Electrics::longest_step(const std::vector<Watch>& watched, std::span<const double> force) const {
  const Bodies& bodies = model_.bodies;
  const auto acceleration = [&](int i) { return Vec2{force[2 * i], force[2 * i + 1]} / bodies.mass[i]; };
  double longest = INFINITY;
  for (const Watch& w : watched) {
    const int i = w.contact.conductor, j = w.contact.partner;
    const bool both_move = j < bodies.size();
    const Vec2 v = velocity(bodies, i) - (both_move ? velocity(bodies, j) : Vec2{});
    const Vec2 a = acceleration(i) - (both_move ? acceleration(j) : Vec2{});
    longest = std::min(longest, time_to_move(discharge_->blind_way(bodies, w), norm(v), norm(a)));
  }
  return longest;
}

bool Electrics::stationary(double fraction) const {
  const Bodies& bodies = model_.bodies;
  for (int i = 0; i < bodies.size(); ++i)
    if (!groups_.potential[i] || norm(field_.last().force[i]) > fraction * largest_force_ ||
        norm(velocity(bodies, i)) > fraction * largest_speed_)
      return false;
  return true;
}

std::vector<TerminalReading> Electrics::terminals() const {
  const std::vector<double> drained = ledger_.drained_by_supply();
  std::vector<TerminalReading> readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k)
    readings.push_back({supplies_[k].name, supplies_[k].potential, drained[k]});
  return readings;
}

void Electrics::save(Checkpoint& checkpoint) const {
  checkpoint.reals["charge_ledger"] = ledger_.save();
  checkpoint.reals["largest_force_and_speed"] = {largest_force_, largest_speed_};
  std::vector<std::int64_t>& contacts = checkpoint.integers["contacts"];
  if (!discharge_) return;
  for (const effects::Contact& contact : discharge_->contacts())
    contacts.insert(contacts.end(), {contact.conductor, contact.partner});
}

void Electrics::restore(const Checkpoint& checkpoint, double time) {
  ledger_.restore(reals(checkpoint, "charge_ledger", ledger_.saved_size()));
  booked_until_ = time;
  const std::vector<double>& largest = reals(checkpoint, "largest_force_and_speed", 2);
  largest_force_ = largest[0];
  largest_speed_ = largest[1];
  field_.set_counters(counters_.field_solves, counters_.iterations);
  if (discharge_) {
    const std::vector<std::int64_t>& ends = integers(checkpoint, "contacts");
    std::vector<effects::Contact> contacts;
    for (std::size_t k = 0; k + 1 < ends.size(); k += 2)
      contacts.push_back({static_cast<int>(ends[k]), static_cast<int>(ends[k + 1])});
    discharge_->set_contacts(std::move(contacts));
  }
  groups_ = groups_of(discharge_);
}

}  // namespace lichtenberg::mechanics
