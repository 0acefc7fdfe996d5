#include "src/mechanics/electrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "src/model/body_ranges.hpp"
#include "src/model/checkpoint.hpp"
#include "src/scene/circuits.hpp"

namespace lichtenberg::mechanics {

namespace {

/// Returns NodeCharges::capacitance.
std::vector<double> capacitances(const std::vector<effects::CircuitNode>& circuits) {
  std::vector<double> capacitance;
  for (const effects::CircuitNode& node : circuits) capacitance.push_back(node.circuit.capacitance);
  if (std::ranges::all_of(capacitance, [](double farad) { return farad == 0; })) capacitance.clear();
  return capacitance;
}

}  // namespace

Electrics::Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
                     const effects::ContactDischarge* discharge, Counters& counters)
    : scene_(scene),
      model_(model),
      counters_(counters),
      field_(field),
      discharge_(discharge),
      contact_events_(model, discharge, scene.mechanics.position_tolerance, counters),
      terminals_(effects::terminals_of(scene)),
      supplies_(effects::potential_sources_of(scene)),
      circuits_(effects::circuit_nodes(scene)),
      capacitance_(capacitances(circuits_)),
      signals_(varying_signals(scene)),
      relaxation_time_(model.charge_relaxation_time()),
      resistors_(scene, model, discharge, terminals_, supplies_, now_),
      now_{.charges = {effects::initial_node_charges(scene), supplies_.size()}} {
  const std::size_t n = model.bodies.size();
  now_.extrapolated = {.force = std::vector<Vec3>(n),
                       .force_rate = std::vector<Vec3>(n),
                       .charge = std::vector<double>(n),
                       .charge_rate = std::vector<double>(n)};
  if (effects::has_circuit(scene)) now_.energy.emplace(scene, relaxation_time_);
  if (!scene.circuits.empty()) now_.received.resize(terminals_.size());
  field_.follow(now_.extrapolated);
}

void Electrics::connect() {
  if (discharge_) counters_.contacts_made += std::ssize(discharge_->update(model_.bodies, now_.contacts).made);
  now_.groups = effects::electrical_groups(scene_, now_.contacts);
  resistors_.update(true);
}

/// Returns Trial::injected_current for a step to `time` (s).
std::vector<double> Electrics::currents(double time) const {
  std::vector<double> current(model_.bodies.size());
  model_.currents(time, current);
  for (const auto& [node, supply, circuit] : circuits_) {
    if (!circuit.current) continue;
    current.resize(now_.charges.size());
    const double dt = time - now_.time;
    current[node] = dt > 0 ? circuit.current->integral(now_.time, time) / dt : circuit.current->at(time, true);
  }
  return current;
}

double Electrics::next_corner(double time) const {
  double next = INFINITY;
  for (const Signal& signal : signals_) next = std::min(next, signal.next_corner(time));
  return next;
}

bool Electrics::pass_corner(double time, double rounding) {
  if (signals_.empty() || next_corner(now_.corner) > time + rounding) return false;
  now_.corner = time;
  if (now_.field.supply_potential == effects::potentials_at(supplies_, time, true)) return true;
  accept(solve(time));
  resistors_.update(true);
  return true;
}

Trial Electrics::solve(double time, FieldGrid grid) {
  resistors_.check_fixed_contacts();
  Trial trial{.time = time,
              .field = {},
              .step = effects::charge_step(time - now_.time, now_.carried.last_step, relaxation_time_),
              .injected_current = currents(time)};
  effects::NodeCharges charges{
      .charge = now_.charges.after(trial.step, trial.injected_current, *model_.team),
      .resistors = now_.carried.resistors,
      .weight = trial.step.weight,
      .injected_current = std::accumulate(trial.injected_current.begin(), trial.injected_current.end(), 0.0),
      .supply_potential = effects::potentials_at(supplies_, time, time == now_.corner),
      .capacitance = capacitance_};
  resistors_.add_charges(trial.step, charges.charge);
  const Stopwatch watch(counters_.field_seconds);
  trial.field = grid == FieldGrid::predictor ? field_.predict(model_.bodies, now_.groups, charges)
                                             : field_.solve(model_.bodies, now_.groups, charges);
  if (model_.bodies.fix_z)
    for (Vec3& force : trial.field.force) force.z = 0;  // the support of the bodies balances it
  counters_.field_solves = field_.solves();
  counters_.predictions = field_.predictions();
  counters_.iterations = field_.iterations();
  return trial;
}

void Electrics::accept_extrapolated(double time, std::span<const double> by_field) {
  const double dt = time - now_.time;
  const std::vector<double> injected_current = currents(time);
  now_.charges.inject(injected_current, dt, relaxation_time_);
  distribute(injected_current, dt, by_field);
  now_.time = time;
}

/// Ends a step of the charges of length dt (s) with `injected_current` (A). Divides each group's charge among its
/// members as the field does (`by_node`: C). Sets the bodies' charges, which pair laws read.
void Electrics::distribute(std::span<const double> injected_current, double dt, std::span<const double> by_node) {
  now_.charges.distribute(now_.groups, by_node, *model_.team);
  if (now_.energy) now_.energy->add_step_charges(injected_current, dt, now_.charges.leaked_in_step());
  for_ranges(*model_.team, model_.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) model_.bodies.charge[i] = now_.charges.charge(i);
  });
}

void Electrics::accept(Trial trial, bool merged) {
  const double dt = trial.time - now_.time;
  now_.field = std::move(trial.field);
  now_.charges.inject(trial.injected_current, dt, relaxation_time_);
  if (dt > 0) resistors_.commit_charges(trial);
  resistors_.linearize();
  if (dt == 0 && now_.carried.noise > 0) resistors_.estimate_currents();
  distribute(trial.injected_current, dt, resistors_.by_node(now_.field.charge, now_.field.circuit_charge));
  if (now_.energy) record_energy(trial, merged);
  now_.time = trial.time;
  update_largest();
  // The attraction of the bodies grows without limit, faster than any grid resolves, and they would bounce forever.
  if (const std::string touching = resistors_.unequal_contact_message(); !touching.empty()) throw Failure(touching);
}

/// Updates the largest force and speed of the run.
void Electrics::update_largest() {
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

void Electrics::set_extrapolation(double time, Rates rates) {
  effects::ExtrapolatedField& extrapolated = now_.extrapolated;
  const effects::Electrostatics& field = now_.field;
  const double dt = time - extrapolated.time;
  for_ranges(*model_.team, model_.bodies.size(), [&](int first, int end) {
    for (int i = first; i < end && rates == Rates::difference_quotient; ++i) {
      extrapolated.force_rate[i] = (field.force[i] - extrapolated.force[i]) / dt;
      extrapolated.charge_rate[i] = (field.charge[i] - extrapolated.charge[i]) / dt;
    }
    for (int i = first; i < end && rates == Rates::forgotten; ++i)
      extrapolated.force_rate[i] = {}, extrapolated.charge_rate[i] = 0;
    std::copy(&field.force[first], &field.force[end - 1] + 1, &extrapolated.force[first]);
    std::copy(&field.charge[first], &field.charge[end - 1] + 1, &extrapolated.charge[first]);
  });
  extrapolated.time = time;
  if (rates != Rates::kept) extrapolated.rates_known = rates == Rates::difference_quotient;
}

/// Returns the work (J) of the field's forces on the bodies since the last record of energy, by the trapezoidal rule.
double Electrics::work_since_record(double time) const {
  double work = 0;
  for (int i = 0; i < model_.bodies.size(); ++i) {
    const Vec3 moved = model_.bodies.box.difference(position_in_space(model_.bodies, i),
                                                    vector_at(now_.recorded_positions, model_.bodies.dimension, i));
    work += 0.5 * dot(now_.recorded_force[i] + now_.extrapolated.force_at(i, time), moved);
  }
  return work;
}

void Electrics::record_energy(const Trial& trial, bool merged) {
  EnergyBudget::Instant instant{trial.time,
                                now_.field.energy,
                                resistors_.node_potentials(now_.field),
                                now_.field.terminal_charge,
                                now_.charges.collected_by_source(),
                                now_.field.supply_potential};
  const bool time_passed = trial.time > now_.time;  // otherwise resistors have carried no charge
  if (merged)
    now_.energy->record_merger(std::move(instant),
                               model_.bodies.position == now_.recorded_positions ? 0 : work_since_record(trial.time));
  else
    now_.energy->record(std::move(instant), now_.carried.resistors,
                        time_passed ? now_.carried.total : std::vector<double>());
  now_.recorded_positions = model_.bodies.position;
  now_.recorded_force = now_.field.force;
}

bool Electrics::stationary(double fraction) const {
  const Bodies& bodies = model_.bodies;
  if (!std::ranges::all_of(signals_, [&](const Signal& signal) { return signal.is_constant_after(now_.time); }))
    return false;
  for (int i = 0; i < bodies.size(); ++i)
    if (now_.groups.connected[i] != -1 ||
        (!scene_.conductors[i].fixed && (norm(now_.field.force[i]) > fraction * now_.largest_force ||
                                         norm(velocity_in_space(bodies, i)) > fraction * now_.largest_speed)))
      return false;
  return true;
}

std::vector<TerminalReading> Electrics::terminals() const {
  const std::vector<double> drained = now_.charges.collected_by_source();
  const std::vector<double>& varying = now_.field.supply_potential;
  std::vector<TerminalReading> readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k)
    readings.push_back({.name = supplies_[k].name,
                        .potential = varying.empty() ? supplies_[k].potential.value : varying[k],
                        .drained = drained[k],
                        .is_source = supplies_[k].is_source});
  if (!now_.energy) return readings;
  for (std::size_t k = 0; k < supplies_.size(); ++k) {
    const std::vector<double>& surface = now_.field.terminal_potential;
    if (k < scene_.electrodes.size()) readings[k].series_resistance = scene_.electrodes[k].series_resistance;
    readings[k].surface_potential = k < surface.size() ? surface[k] : readings[k].potential;
    readings[k].delivered = now_.energy->delivered()[k];
  }
  // Charge that an electrode's circuit has delivered to it; unknown if ideal contacts join it with conductors.
  const bool known = !discharge_ || effects::sharing_effect(scene_);
  for (std::size_t t = 0; t < terminals_.size(); ++t)
    if (!supplies_[t].is_source) readings[t].delivered = known ? now_.field.terminal_charge[t] - now_.received[t] : NAN;
  for (std::size_t c = 0; c < circuits_.size(); ++c) {
    const auto& [node, supply, circuit] = circuits_[c];
    if (static_cast<std::size_t>(supply) < terminals_.size()) continue;  // an electrode behind a series resistor
    readings[supply].series_resistance = circuit.resistance;
    readings[supply].surface_potential = now_.field.circuit_potential[c];
    if (circuit.current) readings[supply].delivered += circuit.current->integral(0, now_.time);
  }
  return readings;
}

void Electrics::save(Checkpoint& checkpoint) const {
  checkpoint.reals["charge_ledger"] = now_.charges.save();
  resistors_.save(checkpoint);
  if (!now_.received.empty()) checkpoint.reals["charge_received"] = now_.received;
  if (now_.energy) checkpoint.reals["energy_book"] = now_.energy->save();
  checkpoint.reals["largest_force_and_speed"] = {now_.largest_force, now_.largest_speed};
  std::vector<std::int64_t>& contacts = checkpoint.integers["contacts"];
  for (const effects::Contact& contact : now_.contacts)
    contacts.insert(contacts.end(), {contact.conductor, contact.partner});
}

void Electrics::restore(const Checkpoint& checkpoint, double time) {
  now_.charges.restore(reals(checkpoint, "charge_ledger", now_.charges.saved_size()));
  now_.time = now_.corner = time;
  const std::vector<double>& largest = reals(checkpoint, "largest_force_and_speed", 2);
  now_.largest_force = largest[0];
  now_.largest_speed = largest[1];
  field_.set_counters(counters_.field_solves, counters_.iterations, counters_.predictions);
  now_.contacts.clear();
  if (discharge_) {
    const std::vector<std::int64_t>& ends = integers(checkpoint, "contacts");
    const auto bodies = model_.bodies.size(), partners = bodies + static_cast<int>(terminals_.size());
    if (ends.size() % 2 != 0) throw Failure("the checkpoint has a contact with one end");
    for (std::size_t k = 0; k < ends.size(); k += 2) {
      if (!(ends[k] >= 0 && ends[k] < std::min<std::int64_t>(bodies, ends[k + 1]) && ends[k + 1] < partners))
        throw Failure(
            fmt::format("the checkpoint has the contact {} - {}: bodies and terminals of this scene are 0 to {}, the "
                        "smaller one first",
                        ends[k], ends[k + 1], partners - 1));
      now_.contacts.push_back({static_cast<int>(ends[k]), static_cast<int>(ends[k + 1])});
    }
    if (std::ranges::adjacent_find(now_.contacts, std::greater_equal{}) != now_.contacts.end())
      throw Failure("the checkpoint has contacts that are not in ascending order");
  }
  now_.groups = effects::electrical_groups(scene_, now_.contacts);
  resistors_.restore(checkpoint);
  if (!now_.received.empty()) now_.received = reals(checkpoint, "charge_received", now_.received.size());
  if (!now_.energy) return;
  now_.energy->restore(reals(checkpoint, "energy_book", now_.energy->saved_size()));
  now_.recorded_positions = model_.bodies.position;
}

}  // namespace lichtenberg::mechanics
