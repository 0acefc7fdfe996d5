#include "src/mechanics/electrics.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "solvers/error.hpp"
#include "src/mechanics/checkpoint.hpp"

namespace lichtenberg::mechanics {

Electrics::Electrics(const Scene& scene, Model& model, Counters& counters)
    : scene_(scene),
      model_(model),
      counters_(counters),
      field_(*model.find<effects::FloatingConductors>()),
      discharge_(model.find<effects::ContactDischarge>()),
      ledger_(model.bodies.charge),
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

bool Electrics::about_to_part() const {
  if (!discharge_) return false;
  const Stopwatch watch(counters_.contact_seconds);
  effects::ContactDischarge tried = *discharge_;
  if (tried.update(model_.bodies).lost == 0) return false;
  try {
    return effects::parts(groups_, groups_of(&tried));
  } catch (const InputError&) {
    return false;  // a short circuit: `reconnect` says so
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
  std::vector<effects::ContactDischarge::Watch> watched = discharge_->watch(model_.bodies, groups_, travel);
  Events events;
  for (const auto& w : watched) events.direction.push_back(w.made ? +1 : -1);
  events.values = [this, list = std::move(watched)](std::span<double> value) {
    for (std::size_t k = 0; k < list.size(); ++k) value[k] = discharge_->excess(model_.bodies, list[k]);
  };
  return events;
}

bool Electrics::stationary(double fraction) const {
  const Bodies& bodies = model_.bodies;
  for (int i = 0; i < bodies.size(); ++i)
    if (!groups_.potential[i] || norm(field_.last().force[i]) > fraction * largest_force_ ||
        norm(velocity(bodies, i)) > fraction * largest_speed_)
      return false;
  return true;
}

void Electrics::save(Checkpoint& checkpoint) const {
  checkpoint.reals["charges"] = ledger_.save();
  checkpoint.reals["largest_force_and_speed"] = {largest_force_, largest_speed_};
  std::vector<std::int64_t>& contacts = checkpoint.integers["contacts"];
  if (!discharge_) return;
  for (const effects::Contact& contact : discharge_->contacts())
    contacts.insert(contacts.end(), {contact.conductor, contact.partner});
}

void Electrics::restore(const Checkpoint& checkpoint, double time) {
  ledger_.restore(reals(checkpoint, "charges", 2 * (ledger_.size() + 2)));
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
