#include "src/mechanics/electrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "src/mechanics/step_control.hpp"
#include "src/model/body_ranges.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg::mechanics {

namespace {

/// A node without charge at the start stands for each terminal behind a resistor.
std::vector<double> with_terminals(std::vector<double> charge, const Scene& scene) {
  charge.resize(effects::node_count(scene));
  return charge;
}

/// The error of a charge that a step may leave, over the largest charge; infinite if no accuracy is asked for. Steps
/// are of second order: where each leaves t of a decay, t goes like the cube of its length, and all together leave C
/// t^(2/3), with C of .09 to .2 (tests/circuit_test.cpp, an electrode behind a resistor). With 5 a^(3/2) that is .6 a
/// at most.
double charge_tolerance(const FieldOptions& field) {
  return field.chosen_for ? 5 * std::pow(field.chosen_for->asked, 1.5) : INFINITY;
}

}  // namespace

Electrics::Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
                     const effects::ContactDischarge* discharge, Counters& counters)
    : scene_(scene),
      model_(model),
      counters_(counters),
      field_(field),
      discharge_(discharge),
      terminals_(effects::terminals_of(scene)),
      supplies_(effects::supplies_of(scene)),
      relaxation_time_(model.charge_relaxation_time()),
      now_{.ledger = {with_terminals(model.bodies.charge, scene), supplies_.size()}} {
  const std::size_t n = model.bodies.size();
  now_.held = {.force = std::vector<Vec3>(n),
               .force_rate = std::vector<Vec3>(n),
               .charge = std::vector<double>(n),
               .charge_rate = std::vector<double>(n)};
  if (effects::has_circuit(scene)) now_.energy.emplace(scene, relaxation_time_);
  field_.follow(now_.held);
}

double Electrics::contact_gap() const {
  return discharge_ && discharge_->make_gap() > 0 ? discharge_->make_gap() : INFINITY;
}

void Electrics::connect() {
  if (discharge_) counters_.contacts_made += std::ssize(discharge_->update(model_.bodies, now_.contacts).made);
  now_.groups = effects::electrical_groups(scene_, now_.contacts);
  update_resistors(true);
}

/// The resistors of the contacts as they are. After a jump no current is known, and none leads smoothly to the next
/// step's.
void Electrics::update_resistors(bool groups_changed) {
  std::vector<effects::Resistor> resistors = effects::resistors_of(scene_, now_.contacts);
  const auto same_place = [](const effects::Resistor& one, const effects::Resistor& other) {
    return one.of_state ? one.a == other.a && one.b == other.b && one.supply == other.supply : one == other;
  };
  if (std::ranges::equal(resistors, now_.carried.resistors, same_place) && !groups_changed) return;
  const std::vector<double> none(resistors.size());
  now_.carried = {.resistors = std::move(resistors), .current = none, .remaining = none, .plain = none};
  if (now_.field.potential.empty()) return;
  linearize();
  guess_currents();
}

bool Electrics::has_laws_of_state() const {
  return std::ranges::any_of(now_.carried.resistors, &effects::Resistor::of_state);
}

effects::ContactState Electrics::state_of(const effects::Resistor& resistor,
                                          std::span<const double> node_potential) const {
  return {discharge_->gap(model_.bodies, contact_of(resistor)), difference_over(resistor, node_potential)};
}

/// Contacts whose law depends on their state, about that of the last accepted field.
void Electrics::linearize() {
  if (!has_laws_of_state()) return;
  const std::vector<double> potential = node_potentials(now_.field);
  for (effects::Resistor& resistor : now_.carried.resistors)
    if (resistor.of_state) effects::linearize(scene_, contact_of(resistor), state_of(resistor, potential), resistor);
}

/// The most charge (C) that a contact carries in the trial's step beside what its law says at the end, but for the
/// solver's error.
double Electrics::linearization_error(const Trial& trial) const {
  if (!has_laws_of_state()) return 0;
  const std::vector<double> potential = node_potentials(trial.field);
  const double noise = scene_.field().moving_tolerance * largest_potential(potential);
  double worst = 0;
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (!resistor.of_state) continue;
    const effects::Contact contact = contact_of(resistor);
    const effects::ContactState state = state_of(resistor, potential);
    effects::Resistor at_end;
    effects::linearize(scene_, contact, state, at_end);
    const double off =
        std::abs(effects::contact_current(scene_, contact, state) - resistor_current(resistor, potential));
    worst = std::max(worst, off - noise * std::max(resistor.conductance, at_end.conductance));
  }
  return trial.step.weight * worst;
}

/// From the potentials of the last solve: right but for the solver's error, which counts if a conductance is large.
void Electrics::guess_currents() {
  if (now_.carried.resistors.empty()) return;
  const std::vector<double> potential = node_potentials(now_.field);
  auto& [resistors, current, remaining, plain, noise, last_step] = now_.carried;
  for (std::size_t k = 0; k < resistors.size(); ++k) current[k] = resistor_current(resistors[k], potential);
}

void Electrics::show_charges() {
  for_ranges(*model_.team, model_.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) model_.bodies.charge[i] = now_.ledger.charge(i);
  });
}

effects::Contact Electrics::contact_of(const effects::Resistor& resistor) const {
  const int n = model_.bodies.size();
  if (resistor.b < 0) return {resistor.a, n + resistor.supply};
  if (resistor.b < n) return {resistor.a, resistor.b};
  const auto terminal = std::ranges::find(terminals_, resistor.b, &effects::Terminal::node);
  return {resistor.a, n + static_cast<int>(terminal - terminals_.begin())};
}

bool Electrics::is_held_at_both_ends(const effects::Resistor& resistor) const {
  const std::vector<std::optional<double>>& held = now_.groups.potential;
  return held[resistor.a] && (resistor.b < 0 || held[resistor.b]);
}

std::string Electrics::sentence_about(const effects::Resistor& resistor, double difference) const {
  const auto [conductor, partner] = contact_of(resistor);
  const int n = model_.bodies.size();
  const std::string who = partner < n ? fmt::format("conductors {} and {}", conductor, partner)
                                      : fmt::format("conductor {} and {}", conductor, terminals_[partner - n].name);
  const std::string remedy =
      is_held_at_both_ends(resistor)
          ? "both are held at their potentials, so that no contact makes them one: keep them apart"
          : fmt::format(
                "lower the resistance in [effects.{}] or widen effects.contact_discharge.gap, so that they "
                "share their charge before they touch",
                effects::sharing_effect(scene_)->name);
  return fmt::format("{} touch while their potentials are {:.3g} V apart, and the force between such has no limit: {}",
                     who, difference, remedy);
}

/// As far as positions are known, and if one of both can move.
bool Electrics::touch(effects::Contact contact) const {
  const auto is_free = [&](int i) { return i < model_.bodies.size() && !scene_.conductors[i].held; };
  return (is_free(contact.conductor) || is_free(contact.partner)) &&
         discharge_->gap(model_.bodies, contact) <= scene_.mechanics.position_tolerance;
}

std::string Electrics::pressed_apart_in_potential() const {
  if (!discharge_ || now_.field.potential.empty() || now_.carried.resistors.empty()) return "";
  const std::vector<double> potential = node_potentials(now_.field);
  const double noise = scene_.field().moving_tolerance * largest_potential(potential);
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (resistor.series || !touch(contact_of(resistor))) continue;
    const double difference = std::abs(difference_over(resistor, potential));
    if (difference > noise) return sentence_about(resistor, difference);
  }
  return "";
}

/// V, of nodes and supplies.
double Electrics::largest_potential(std::span<const double> node_potential) const {
  double largest = 0;
  for (const double potential : node_potential) largest = std::max(largest, std::abs(potential));
  for (const effects::Supply& supply : supplies_) largest = std::max(largest, std::abs(supply.potential));
  return largest;
}

/// Bodies that are held would attract each other for ever.
void Electrics::check_held_contacts() const {
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (resistor.series || !is_held_at_both_ends(resistor)) continue;
    const double other = resistor.b < 0 ? resistor.potential : *now_.groups.potential[resistor.b];
    const double difference = std::abs(*now_.groups.potential[resistor.a] - other);
    if (difference > 0 && discharge_->gap(model_.bodies, contact_of(resistor)) <= 0)
      throw Failure(sentence_about(resistor, difference));
  }
}

/// A, by the effects, into each conductor.
std::vector<double> Electrics::currents(double time) const {
  std::vector<double> current(model_.bodies.size());
  model_.currents(time, current);
  return current;
}

Trial Electrics::solve(double time, FieldGrid grid) {
  check_held_contacts();
  Trial trial{.time = time,
              .field = {},
              .step = effects::charge_step(time - now_.time, now_.carried.last_step, relaxation_time_),
              .fed = currents(time)};
  effects::NodeCharges charges{.resistors = now_.carried.resistors,
                               .weight = trial.step.weight,
                               .fed = std::accumulate(trial.fed.begin(), trial.fed.end(), 0.0)};
  charges.charge.resize(now_.ledger.size());
  for_ranges(*model_.team, now_.ledger.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i)
      charges.charge[i] =
          trial.step.decay * now_.ledger.charge(i) + (i < model_.bodies.size() ? trial.fed[i] * trial.step.fed : 0);
  });
  for (std::size_t k = 0; k < charges.resistors.size(); ++k) {
    const double inherited =
        trial.step.inherited * now_.carried.remaining[k] + trial.step.weight * charges.resistors[k].source;
    charges.charge[charges.resistors[k].a] -= inherited;
    if (charges.resistors[k].b >= 0) charges.charge[charges.resistors[k].b] += inherited;
  }
  const Stopwatch watch(counters_.field_seconds);
  trial.field = grid == FieldGrid::predictor ? field_.predict(model_.bodies, now_.groups, charges)
                                             : field_.solve(model_.bodies, now_.groups, charges);
  if (model_.bodies.keep_height)
    for (Vec3& force : trial.field.force) force.z = 0;  // what the bodies lie on takes it up
  counters_.field_solves = field_.solves();
  counters_.predictions = field_.predictions();
  counters_.iterations = field_.iterations();
  return trial;
}

/// The conductors' values, then those of the terminals behind a resistor.
std::vector<double> Electrics::by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const {
  for (std::size_t t = 0; t < terminals_.size(); ++t)
    if (terminals_[t].node >= 0) by_conductor.push_back(by_terminal[t]);
  return by_conductor;
}

std::vector<double> Electrics::node_potentials(const effects::Electrostatics& field) const {
  return by_node(field.potential, field.terminal_potential);
}

/// V, its a less the other end.
double Electrics::difference_over(const effects::Resistor& resistor, std::span<const double> node_potential) const {
  return node_potential[resistor.a] - (resistor.b >= 0 ? node_potential[resistor.b] : resistor.potential);
}

double Electrics::resistor_current(const effects::Resistor& resistor, std::span<const double> node_potential) const {
  return resistor.conductance * difference_over(resistor, node_potential) + resistor.source;
}

double Electrics::charge_error(const Trial& trial) const {
  const double dt = trial.time - now_.time;
  const CarriedCharges& carried = now_.carried;
  if (carried.resistors.empty() || dt == 0) return 0;
  double largest_charge = 0, largest_supply = 0;
  for (const std::vector<double>* charges : {&trial.field.charge, &trial.field.terminal_charge})
    for (const double charge : *charges) largest_charge = std::max(largest_charge, std::abs(charge));
  for (const effects::Supply& supply : supplies_) largest_supply = std::max(largest_supply, std::abs(supply.potential));
  double worst = linearization_error(trial);
  for (std::size_t k = 0; k < carried.resistors.size(); ++k) {
    const double current = trial.field.carried[k] / trial.step.weight + carried.resistors[k].source;
    const double noise =
        carried.noise * scene_.field().moving_tolerance * carried.resistors[k].conductance * largest_supply;
    worst =
        std::max(worst, effects::charge_error(trial.step.weight * current + trial.step.inherited * carried.remaining[k],
                                              dt, carried.current[k], current, noise));
  }
  const double of_positions = scene_.mechanics.position_tolerance / *std::ranges::min_element(model_.bodies.radius);
  const double tolerance = std::min(of_positions, charge_tolerance(scene_.field()));
  // Charges that are but the noise of potentials, where nothing drives any, are not worth a step.
  const double no_charge =
      scene_.field().moving_tolerance * scene_.medium.permittivity * scene_.medium.depth * largest_supply;
  largest_charge = std::max(largest_charge, no_charge);
  return worst == 0 ? 0 : worst / (tolerance * largest_charge);
}

void Electrics::share(double time, std::span<const double> by_field) {
  const double dt = time - now_.time;
  const std::vector<double> fed = currents(time);
  now_.ledger.feed(fed, dt, relaxation_time_);
  now_.time = time;
  now_.ledger.settle(now_.groups, by_field, *model_.team);
  if (now_.energy) now_.energy->note(fed, dt, now_.ledger.leaked_in_step());
  show_charges();
}

/// Books what the resistors have carried in a step.
void Electrics::carry_resistors(const Trial& trial) {
  const effects::ChargeStep& step = trial.step;
  auto& [resistors, current, remaining, plain, noise, last_step] = now_.carried;
  for (std::size_t k = 0; k < resistors.size(); ++k) {
    current[k] = now_.field.carried[k] / step.weight + resistors[k].source;
    remaining[k] = step.weight * current[k] + step.inherited * remaining[k];
    plain[k] = step.plain_weight * current[k] + step.plain_inherited * plain[k];
    now_.ledger.carry(resistors[k], remaining[k], plain[k]);
  }
  last_step = trial.time - now_.time;
  noise = 0;
}

void Electrics::accept(Trial trial, bool merged) {
  const double dt = trial.time - now_.time;
  now_.field = std::move(trial.field);
  now_.ledger.feed(trial.fed, dt, relaxation_time_);
  if (dt > 0)
    carry_resistors(trial);
  else if (now_.carried.noise > 0)
    guess_currents();
  now_.ledger.settle(now_.groups, by_node(now_.field.charge, now_.field.terminal_charge), *model_.team);
  if (now_.energy) now_.energy->note(trial.fed, dt, now_.ledger.leaked_in_step());
  if (now_.energy) book_energy(trial, merged);
  now_.time = trial.time;
  linearize();
  show_charges();
  note_largest();
  // Else they would press each other with a force that no grid follows, and bounce for ever.
  if (const std::string touching = pressed_apart_in_potential(); !touching.empty()) throw Failure(touching);
}

/// The largest force and speed until now.
void Electrics::note_largest() {
  const Bodies& bodies = model_.bodies;
  const double force2 = largest_of_ranges(*model_.team, bodies.size(), 0, [&](int first, int end) {
    double largest = 0;
    for (int i = first; i < end; ++i) largest = std::max(largest, norm2(now_.field.force[i]));
    return largest;
  });
  const double speed2 = largest_of_ranges(*model_.team, bodies.size(), 0, [&](int first, int end) {
    double largest = 0;
    for (int i = first; i < end; ++i) largest = std::max(largest, norm2(velocity_in_space(bodies, i)));
    return largest;
  });
  now_.largest_force = std::max(now_.largest_force, std::sqrt(force2));
  now_.largest_speed = std::max(now_.largest_speed, std::sqrt(speed2));
}

void Electrics::hold(double time, Rates rates) {
  effects::HeldField& held = now_.held;
  const effects::Electrostatics& field = now_.field;
  const double dt = time - held.time;
  for_ranges(*model_.team, model_.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end && rates == Rates::since_then; ++i) {
      held.force_rate[i] = (field.force[i] - held.force[i]) / dt;
      held.charge_rate[i] = (field.charge[i] - held.charge[i]) / dt;
    }
    for (int i = first; i < end && rates == Rates::forgotten; ++i) held.force_rate[i] = {}, held.charge_rate[i] = 0;
    std::copy(&field.force[first], &field.force[end - 1] + 1, &held.force[first]);
    std::copy(&field.charge[first], &field.charge[end - 1] + 1, &held.charge[first]);
  });
  held.time = time;
  if (rates != Rates::kept) held.rates_known = rates == Rates::since_then;
}

/// What the field's forces have done on the bodies since energy was last booked (J), by the trapezoidal rule.
double Electrics::work_since_booking(double time) const {
  double work = 0;
  for (int i = 0; i < model_.bodies.size(); ++i) {
    const Vec3 moved = model_.bodies.box.difference(position_in_space(model_.bodies, i),
                                                    vector_at(now_.booked_at, model_.bodies.dimension, i));
    work += 0.5 * dot(now_.booked_force[i] + now_.held.force_at(i, time), moved);
  }
  return work;
}

void Electrics::book_energy(const Trial& trial, bool merged) {
  EnergyBook::Instant instant{trial.time, now_.field.energy, node_potentials(now_.field), now_.field.terminal_charge,
                              now_.ledger.drained_by_supply()};
  const bool time_passed = trial.time > now_.time;  // if not, resistors have carried nothing
  if (merged)
    now_.energy->book_merger(std::move(instant),
                             model_.bodies.position == now_.booked_at ? 0 : work_since_booking(trial.time));
  else
    now_.energy->book(std::move(instant), now_.carried.resistors,
                      time_passed ? now_.carried.plain : std::vector<double>());
  now_.booked_at = model_.bodies.position;
  now_.booked_force = now_.field.force;
}

bool Electrics::stationary(double fraction) const {
  const Bodies& bodies = model_.bodies;
  for (int i = 0; i < bodies.size(); ++i)
    if (now_.groups.connected[i] != -1 ||
        (!scene_.conductors[i].held && (norm(now_.field.force[i]) > fraction * now_.largest_force ||
                                        norm(velocity_in_space(bodies, i)) > fraction * now_.largest_speed)))
      return false;
  return true;
}

std::vector<TerminalReading> Electrics::terminals() const {
  const std::vector<double> drained = now_.ledger.drained_by_supply();
  std::vector<TerminalReading> readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k)
    readings.push_back({supplies_[k].name, supplies_[k].potential, drained[k]});
  if (!now_.energy) return readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k) {
    const std::vector<double>& surface = now_.field.terminal_potential;
    if (k < scene_.electrodes.size()) readings[k].series_resistance = scene_.electrodes[k].series_resistance;
    readings[k].surface_potential = k < surface.size() ? surface[k] : supplies_[k].potential;
    readings[k].delivered = now_.energy->delivered()[k];
  }
  return readings;
}

void Electrics::save(Checkpoint& checkpoint) const {
  checkpoint.reals["charge_ledger"] = now_.ledger.save();
  if (has_resistors()) {
    checkpoint.reals["link_currents"] = now_.carried.current;
    checkpoint.reals["link_charges_left"] = now_.carried.remaining;
    checkpoint.reals["link_charges"] = now_.carried.plain;
    checkpoint.reals["last_charge_step"] = {now_.carried.last_step, now_.carried.noise};
    std::vector<double>& linear = checkpoint.reals["link_linearization"];
    for (const effects::Resistor& resistor : now_.carried.resistors)
      if (resistor.of_state) linear.insert(linear.end(), {resistor.conductance, resistor.source});
    if (linear.empty()) checkpoint.reals.erase("link_linearization");
  }
  if (now_.energy) checkpoint.reals["energy_book"] = now_.energy->save();
  checkpoint.reals["largest_force_and_speed"] = {now_.largest_force, now_.largest_speed};
  std::vector<std::int64_t>& contacts = checkpoint.integers["contacts"];
  for (const effects::Contact& contact : now_.contacts)
    contacts.insert(contacts.end(), {contact.conductor, contact.partner});
}

void Electrics::restore_linearization(const Checkpoint& checkpoint) {
  const auto count = std::ranges::count_if(now_.carried.resistors, &effects::Resistor::of_state);
  if (count == 0) return;
  const std::vector<double>& linear = reals(checkpoint, "link_linearization", 2 * count);
  auto next = linear.begin();
  for (effects::Resistor& resistor : now_.carried.resistors)
    if (resistor.of_state) resistor.conductance = *next++, resistor.source = *next++;
}

void Electrics::restore(const Checkpoint& checkpoint, double time) {
  now_.ledger.restore(reals(checkpoint, "charge_ledger", now_.ledger.saved_size()));
  now_.time = time;
  const std::vector<double>& largest = reals(checkpoint, "largest_force_and_speed", 2);
  now_.largest_force = largest[0];
  now_.largest_speed = largest[1];
  field_.set_counters(counters_.field_solves, counters_.iterations, counters_.predictions);
  now_.contacts.clear();
  if (discharge_) {
    const std::vector<std::int64_t>& ends = integers(checkpoint, "contacts");
    for (std::size_t k = 0; k + 1 < ends.size(); k += 2)
      now_.contacts.push_back({static_cast<int>(ends[k]), static_cast<int>(ends[k + 1])});
  }
  now_.groups = effects::electrical_groups(scene_, now_.contacts);
  update_resistors(true);
  if (has_resistors()) {
    CarriedCharges& carried = now_.carried;
    carried.current = reals(checkpoint, "link_currents", carried.resistors.size());
    carried.remaining = reals(checkpoint, "link_charges_left", carried.resistors.size());
    carried.plain = reals(checkpoint, "link_charges", carried.resistors.size());
    const std::vector<double>& last = reals(checkpoint, "last_charge_step", 2);
    carried.last_step = last[0];
    carried.noise = last[1];
    restore_linearization(checkpoint);
  }
  if (!now_.energy) return;
  now_.energy->restore(reals(checkpoint, "energy_book", now_.energy->saved_size()));
  now_.booked_at = model_.bodies.position;
}

}  // namespace lichtenberg::mechanics
