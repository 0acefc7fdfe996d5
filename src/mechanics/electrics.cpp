#include "src/mechanics/electrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "src/mechanics/step_control.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg::mechanics {

namespace {

/// A node without charge at the start stands for each terminal behind a resistor.
std::vector<double> with_terminals(std::vector<double> charge, const Scene& scene) {
  charge.resize(effects::node_count(scene));
  return charge;
}

}  // namespace

Electrics::Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
                     effects::ContactDischarge* discharge, Counters& counters)
    : scene_(scene),
      model_(model),
      counters_(counters),
      field_(field),
      discharge_(discharge),
      terminals_(effects::terminals_of(scene)),
      supplies_(effects::supplies_of(scene)),
      ledger_(with_terminals(model.bodies.charge, scene), supplies_.size()),
      current_(model.bodies.size()),
      relaxation_time_(model.charge_relaxation_time()) {
  if (effects::has_circuit(scene)) energy_.emplace(scene, relaxation_time_);
}

double Electrics::contact_gap() const {
  return discharge_ && discharge_->make_gap() > 0 ? discharge_->make_gap() : INFINITY;
}

void Electrics::connect() {
  if (discharge_) counters_.contacts_made += discharge_->update(model_.bodies).made;
  groups_ = groups_of(discharge_);
  update_resistors(true);
}

effects::ElectricalGroups Electrics::groups_of(const effects::ContactDischarge* discharge) const {
  return effects::electrical_groups(scene_, discharge ? discharge->contacts() : std::vector<effects::Contact>{});
}

/// The resistors of the contacts as they are. After a jump no current is known, and none leads smoothly to the next
/// step's.
void Electrics::update_resistors(bool groups_changed) {
  std::vector<effects::Resistor> now =
      effects::resistors_of(scene_, discharge_ ? discharge_->contacts() : std::vector<effects::Contact>{});
  if (now == resistors_ && !groups_changed) return;
  resistors_ = std::move(now);
  remaining_.assign(resistors_.size(), 0);
  plain_.assign(resistors_.size(), 0);
  resistor_current_.assign(resistors_.size(), 0);
  last_step_ = 0;
  current_noise_ = 1;
  if (!field_.last().potential.empty()) guess_currents();
}

/// From the potentials of the last solve: right but for the solver's error, which counts if a conductance is large.
void Electrics::guess_currents() {
  const std::vector<double> potential = node_potentials();
  for (std::size_t k = 0; k < resistors_.size(); ++k) resistor_current_[k] = resistor_current(resistors_[k], potential);
}

void Electrics::show_charges() {
  for (int i = 0; i < model_.bodies.size(); ++i) model_.bodies.charge[i] = ledger_.charge(i);
}

effects::Contact Electrics::contact_of(const effects::Resistor& resistor) const {
  const int n = model_.bodies.size();
  if (resistor.b < 0) return {resistor.a, n + resistor.supply};
  if (resistor.b < n) return {resistor.a, resistor.b};
  const auto terminal = std::ranges::find(terminals_, resistor.b, &effects::Terminal::node);
  return {resistor.a, n + static_cast<int>(terminal - terminals_.begin())};
}

bool Electrics::is_held_at_both_ends(const effects::Resistor& resistor) const {
  return groups_.potential[resistor.a] && (resistor.b < 0 || groups_.potential[resistor.b]);
}

std::string Electrics::sentence_about(const effects::Resistor& resistor, double difference) const {
  const auto [conductor, partner] = contact_of(resistor);
  const int n = model_.bodies.size();
  const std::string who = partner < n ? fmt::format("conductors {} and {}", conductor, partner)
                                      : fmt::format("conductor {} and {}", conductor, terminals_[partner - n].name);
  const std::string remedy =
      is_held_at_both_ends(resistor)
          ? "both are held at their potentials, so that no contact makes them one: keep them apart"
          : "lower the resistance in [effects.contact_resistance] or widen effects.contact_discharge.gap, so that they "
            "share their charge before they touch";
  return fmt::format("{} touch while their potentials are {:.3g} V apart, and the force between such has no limit: {}",
                     who, difference, remedy);
}

std::string Electrics::pressed_apart_in_potential() const {
  if (!discharge_ || field_.last().potential.empty()) return "";
  const std::vector<double> potential = node_potentials();
  double largest = 0;
  for (const double p : potential) largest = std::max(largest, std::abs(p));
  for (const effects::Supply& supply : supplies_) largest = std::max(largest, std::abs(supply.potential));
  for (const effects::Resistor& resistor : resistors_) {
    if (resistor.series || discharge_->gap(model_.bodies, contact_of(resistor)) > 0) continue;
    const double difference = std::abs(resistor_current(resistor, potential)) / resistor.conductance;
    if (difference > scene_.field().moving_tolerance * largest) return sentence_about(resistor, difference);
  }
  return "";
}

/// Bodies that are held would attract each other for ever.
void Electrics::check_held_contacts() const {
  for (const effects::Resistor& resistor : resistors_) {
    if (resistor.series || !is_held_at_both_ends(resistor)) continue;
    const double other = resistor.b < 0 ? resistor.potential : *groups_.potential[resistor.b];
    const double difference = std::abs(*groups_.potential[resistor.a] - other);
    if (difference > 0 && discharge_->gap(model_.bodies, contact_of(resistor)) <= 0)
      throw Failure(sentence_about(resistor, difference));
  }
}

const effects::Electrostatics& Electrics::solve(double time) {
  check_held_contacts();
  model_.currents(time, current_);
  const effects::ChargeStep step = effects::charge_step(time - booked_until_, last_step_, relaxation_time_);
  std::vector<double> charge;
  for (int i = 0; i < ledger_.size(); ++i)
    charge.push_back(step.decay * ledger_.charge(i) + (i < model_.bodies.size() ? current_[i] * step.fed : 0));
  for (std::size_t k = 0; k < resistors_.size(); ++k) {
    const double inherited = step.inherited * remaining_[k];
    charge[resistors_[k].a] -= inherited;
    if (resistors_[k].b >= 0) charge[resistors_[k].b] += inherited;
  }
  const auto terminals = charge.begin() + model_.bodies.size();
  std::copy(charge.begin(), terminals, model_.bodies.charge.begin());
  implicit_ = {
      {terminals, charge.end()}, resistors_, step.weight, std::accumulate(current_.begin(), current_.end(), 0.0)};
  const Stopwatch watch(counters_.field_seconds);
  if (predicting_)
    field_.predict(model_.bodies, groups_, implicit_);
  else
    field_.solve(model_.bodies, groups_, implicit_);
  counters_.field_solves = field_.solves();
  counters_.predictions = field_.predictions();
  counters_.iterations = field_.iterations();
  return field_.last();
}

/// The conductors' values, then those of the terminals behind a resistor.
std::vector<double> Electrics::by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const {
  for (std::size_t t = 0; t < terminals_.size(); ++t)
    if (terminals_[t].node >= 0) by_conductor.push_back(by_terminal[t]);
  return by_conductor;
}

std::vector<double> Electrics::node_potentials() const {
  return by_node(field_.last().potential, field_.last().terminal_potential);
}

double Electrics::resistor_current(const effects::Resistor& resistor, std::span<const double> node_potential) const {
  const double other = resistor.b >= 0 ? node_potential[resistor.b] : resistor.potential;
  return resistor.conductance * (node_potential[resistor.a] - other);
}

double Electrics::charge_error(double time) const {
  const double dt = time - booked_until_;
  if (resistors_.empty() || dt == 0) return 0;
  const effects::ChargeStep step = effects::charge_step(dt, last_step_, relaxation_time_);
  const effects::Electrostatics& field = field_.last();
  double largest_charge = 0, largest_potential = 0;
  for (const std::vector<double>* charges : {&field.charge, &field.terminal_charge})
    for (const double charge : *charges) largest_charge = std::max(largest_charge, std::abs(charge));
  for (const effects::Supply& supply : supplies_)
    largest_potential = std::max(largest_potential, std::abs(supply.potential));
  double worst = 0;
  for (std::size_t k = 0; k < resistors_.size(); ++k) {
    const double now = field.carried[k] / step.weight;
    const double noise =
        current_noise_ * scene_.field().moving_tolerance * resistors_[k].conductance * largest_potential;
    worst = std::max(worst, effects::charge_error(step.weight * now + step.inherited * remaining_[k], dt,
                                                  resistor_current_[k], now, noise));
  }
  const double tolerance = scene_.mechanics.position_tolerance / *std::ranges::min_element(model_.bodies.radius);
  // Charges that are but the noise of potentials, where nothing drives any, are not worth a step.
  const double no_charge =
      scene_.field().moving_tolerance * scene_.medium.permittivity * scene_.medium.depth * largest_potential;
  largest_charge = std::max(largest_charge, no_charge);
  return worst == 0 ? 0 : worst / (tolerance * largest_charge);
}

void Electrics::share(double time, std::span<const double> by_field) {
  const double dt = time - booked_until_;
  model_.currents(time, current_);
  ledger_.feed(current_, dt, relaxation_time_);
  booked_until_ = time;
  ledger_.settle(groups_, by_field);
  if (energy_) energy_->note(current_, dt, ledger_.leaked_in_step());
  show_charges();
}

/// Books what the resistors have carried in a step.
void Electrics::carry_resistors(const effects::ChargeStep& step) {
  for (std::size_t k = 0; k < resistors_.size(); ++k) {
    resistor_current_[k] = field_.last().carried[k] / step.weight;
    remaining_[k] = step.weight * resistor_current_[k] + step.inherited * remaining_[k];
    plain_[k] = step.plain_weight * resistor_current_[k] + step.plain_inherited * plain_[k];
    ledger_.carry(resistors_[k], remaining_[k], plain_[k]);
  }
}

void Electrics::settle(double time) { settle(time, false); }

void Electrics::settle(double time, bool merged) {
  const double dt = time - booked_until_;
  model_.currents(time, current_);
  ledger_.feed(current_, dt, relaxation_time_);
  if (dt > 0) {
    carry_resistors(effects::charge_step(dt, last_step_, relaxation_time_));
    last_step_ = dt;
    current_noise_ = 0;
  } else if (current_noise_ > 0) {
    guess_currents();
  }
  ledger_.settle(groups_, by_node(field_.last().charge, field_.last().terminal_charge));
  if (energy_) energy_->note(current_, dt, ledger_.leaked_in_step());
  booked_until_ = time;
  show_charges();
  if (energy_) book_energy(time, merged, dt > 0 ? plain_ : std::vector<double>());
  for (int i = 0; i < model_.bodies.size(); ++i) {
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
  const bool changed = !(groups_ == before);
  update_resistors(changed);
  if (!changed) return false;
  ++counters_.regroupings;
  if (!effects::parts(groups_, before)) return false;
  solve(time);
  settle(time, true);
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

/// What the field's forces have done on the bodies since energy was last booked (J), by the trapezoidal rule.
double Electrics::work_since_booking(double time) const {
  double work = 0;
  for (int i = 0; i < model_.bodies.size(); ++i) {
    const Vec2 moved = position(model_.bodies, i) - Vec2{booked_at_[2 * i], booked_at_[2 * i + 1]};
    work += 0.5 * dot(booked_force_[i] + field_.held_force(i, time), moved);
  }
  return work;
}

/// `carried`: C, by resistor since the last solve; none if no time has passed.
void Electrics::book_energy(double time, bool merged, std::span<const double> carried) {
  EnergyBook::Instant now{time, field_.last().energy, node_potentials(), field_.last().terminal_charge,
                          ledger_.drained_by_supply()};
  if (merged)
    energy_->book_merger(std::move(now), model_.bodies.position == booked_at_ ? 0 : work_since_booking(time));
  else
    energy_->book(std::move(now), resistors_, carried);
  booked_at_ = model_.bodies.position;
  booked_force_ = field_.last().force;
}

bool Electrics::stationary(double fraction) const {
  const Bodies& bodies = model_.bodies;
  for (int i = 0; i < bodies.size(); ++i)
    if (groups_.connected[i] != -1 ||
        (!scene_.conductors[i].held && (norm(field_.last().force[i]) > fraction * largest_force_ ||
                                        norm(velocity(bodies, i)) > fraction * largest_speed_)))
      return false;
  return true;
}

std::vector<TerminalReading> Electrics::terminals() const {
  const std::vector<double> drained = ledger_.drained_by_supply();
  std::vector<TerminalReading> readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k)
    readings.push_back({supplies_[k].name, supplies_[k].potential, drained[k]});
  if (!energy_) return readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k) {
    const std::vector<double>& surface = field_.last().terminal_potential;
    if (k < scene_.electrodes.size()) readings[k].series_resistance = scene_.electrodes[k].series_resistance;
    readings[k].surface_potential = k < surface.size() ? surface[k] : supplies_[k].potential;
    readings[k].delivered = energy_->delivered()[k];
  }
  return readings;
}

void Electrics::save(Checkpoint& checkpoint) const {
  checkpoint.reals["charge_ledger"] = ledger_.save();
  if (!resistors_.empty()) {
    checkpoint.reals["link_currents"] = resistor_current_;
    checkpoint.reals["link_charges_left"] = remaining_;
    checkpoint.reals["link_charges"] = plain_;
    checkpoint.reals["last_charge_step"] = {last_step_, current_noise_};
  }
  if (energy_) checkpoint.reals["energy_book"] = energy_->save();
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
  field_.set_counters(counters_.field_solves, counters_.iterations, counters_.predictions);
  if (discharge_) {
    const std::vector<std::int64_t>& ends = integers(checkpoint, "contacts");
    std::vector<effects::Contact> contacts;
    for (std::size_t k = 0; k + 1 < ends.size(); k += 2)
      contacts.push_back({static_cast<int>(ends[k]), static_cast<int>(ends[k + 1])});
    discharge_->set_contacts(std::move(contacts));
  }
  groups_ = groups_of(discharge_);
  update_resistors(true);
  if (!resistors_.empty()) {
    resistor_current_ = reals(checkpoint, "link_currents", resistors_.size());
    remaining_ = reals(checkpoint, "link_charges_left", resistors_.size());
    plain_ = reals(checkpoint, "link_charges", resistors_.size());
    const std::vector<double>& last = reals(checkpoint, "last_charge_step", 2);
    last_step_ = last[0];
    current_noise_ = last[1];
  }
  if (!energy_) return;
  energy_->restore(reals(checkpoint, "energy_book", energy_->saved_size()));
  booked_at_ = model_.bodies.position;
}

}  // namespace lichtenberg::mechanics
