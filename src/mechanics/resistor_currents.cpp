#include "src/mechanics/resistor_currents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"
#include "src/mechanics/contact_events.hpp"

namespace lichtenberg::mechanics {

namespace {

/// Returns the error of a charge that a step may have, relative to the largest charge; infinite without a requested
/// accuracy a. Steps are of second order: the error t of each step grows as the cube of its length. A decay then has a
/// total error of C t^(2/3), with C from 0.09 to 0.2 (tests/circuit_test.cpp, an electrode behind a resistor). The
/// value 5 a^(3/2) thus gives at most 0.6 a.
double charge_tolerance(const FieldOptions& field) {
  return field.chosen_for ? 5 * std::pow(field.chosen_for->requested, 1.5) : INFINITY;
}

}  // namespace

/// A jump of the field makes the currents unknown, so that the next step inherits none.
void ResistorCurrents::update(bool groups_changed) {
  std::vector<effects::Resistor> resistors = effects::resistors_of(scene_, now_.contacts);
  const auto same_connection = [](const effects::Resistor& one, const effects::Resistor& other) {
    return one.depends_on_state && other.depends_on_state
               ? one.a == other.a && one.b == other.b && one.supply == other.supply
               : one == other;
  };
  if (std::ranges::equal(resistors, now_.carried.resistors, same_connection) && !groups_changed) return;
  const std::vector<double> none(resistors.size());
  now_.carried = {.resistors = std::move(resistors), .current = none, .remaining = none, .total = none};
  if (now_.field.potential.empty()) return;
  linearize();
  estimate_currents();
}

bool ResistorCurrents::has_state_dependent_laws() const {
  return std::ranges::any_of(now_.carried.resistors, &effects::Resistor::depends_on_state);
}

effects::ContactState ResistorCurrents::state_of(const effects::Resistor& resistor,
                                                 std::span<const double> node_potential) const {
  return {difference_over(resistor, node_potential), discharge_->gap(model_.bodies, contact_of(resistor))};
}

void ResistorCurrents::linearize() {
  if (!has_state_dependent_laws()) return;
  const std::vector<double> potential = end_potentials(now_.field);
  for (effects::Resistor& resistor : now_.carried.resistors)
    if (resistor.depends_on_state)
      effects::linearize(scene_, contact_of(resistor), state_of(resistor, potential), resistor);
}

/// Returns the largest error (C) of the charge that a contact carries in the trial's step, beyond the error of the
/// solver. It is the linearized current minus the law's current at the end of the step, times the step's weight.
double ResistorCurrents::linearization_error(const Trial& trial) const {
  if (!has_state_dependent_laws()) return 0;
  const std::vector<double> potential = end_potentials(trial.field);
  const double noise = scene_.field().moving_tolerance * largest_potential(potential);
  double worst = 0;
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (!resistor.depends_on_state) continue;
    const effects::Contact contact = contact_of(resistor);
    const effects::ContactState state = state_of(resistor, potential);
    effects::Resistor at_end;
    effects::linearize(scene_, contact, state, at_end);
    const double off =
        std::abs(effects::contact_current(scene_, contact, state) - current_through(resistor, potential));
    worst = std::max(worst, off - noise * std::max(resistor.conductance, at_end.conductance));
  }
  return trial.step.weight * worst;
}

double ResistorCurrents::longest_step(std::span<const double> force) const {
  double longest = INFINITY;
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (!resistor.depends_on_state) continue;
    const effects::Contact contact = contact_of(resistor);
    const double scale = effects::sharing_law(scene_, contact).gap_scale;
    longest = std::min(longest, time_to_change_gap(model_.bodies, contact, force, 0.5 * scale));
  }
  return longest;
}

/// The currents have the error of the solver's potentials, which matters if a conductance is large.
void ResistorCurrents::estimate_currents() {
  if (now_.carried.resistors.empty()) return;
  const std::vector<double> potential = end_potentials(now_.field);
  auto& [resistors, current, remaining, total, noise, last_step] = now_.carried;
  for (std::size_t k = 0; k < resistors.size(); ++k) current[k] = current_through(resistors[k], potential);
}

effects::Contact ResistorCurrents::contact_of(const effects::Resistor& resistor) const {
  return {resistor.a, resistor.partner};
}

bool ResistorCurrents::has_fixed_potentials(const effects::Resistor& resistor) const {
  const std::vector<std::optional<double>>& fixed = now_.groups.potential;
  return fixed[resistor.a] && (resistor.b < 0 || fixed[resistor.b]);
}

std::string ResistorCurrents::contact_message(const effects::Resistor& resistor, double difference) const {
  const auto [conductor, partner] = contact_of(resistor);
  const int n = model_.bodies.size();
  const std::string subject = partner < n ? fmt::format("conductors {} and {}", conductor, partner)
                                          : fmt::format("conductor {} and {}", conductor, terminals_[partner - n].name);
  const std::string remedy =
      has_fixed_potentials(resistor) ? "both have fixed potentials, which no contact can equalize: keep them apart"
      : now_.carried.last_step == 0 && now_.time == 0
          ? "they touch at the start: begin with a gap between them, or let their contact be ideal"
          : fmt::format(
                "lower the resistance in [effects.{}] or widen effects.contact_discharge.contact_distance, so that "
                "they "
                "share their charge before they touch",
                effects::sharing_effect(scene_)->name);
  return fmt::format("{} touch while their potentials are {:.3g} V apart, and the force between such has no limit: {}",
                     subject, difference, remedy);
}

/// Returns true if the two bodies of a contact touch to within position_tolerance and at least one of them can move.
bool ResistorCurrents::touch(effects::Contact contact) const {
  const auto is_free = [&](int i) { return i < model_.bodies.size() && !scene_.conductors[i].fixed; };
  return (is_free(contact.conductor) || is_free(contact.partner)) &&
         discharge_->gap(model_.bodies, contact) <= scene_.mechanics.position_tolerance;
}

std::string ResistorCurrents::unequal_contact_message() const {
  if (!discharge_ || now_.field.potential.empty() || now_.carried.resistors.empty()) return "";
  const std::vector<double> potential = end_potentials(now_.field);
  const double noise = scene_.field().moving_tolerance * largest_potential(potential);
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (resistor.series || !touch(contact_of(resistor))) continue;
    const double difference = std::abs(difference_over(resistor, potential));
    if (difference > noise) return contact_message(resistor, difference);
  }
  return "";
}

/// Returns the largest potential (V, absolute) of nodes and sources.
double ResistorCurrents::largest_potential(std::span<const double> node_potential) const {
  double largest = 0;
  for (const double potential : node_potential) largest = std::max(largest, std::abs(potential));
  for (const effects::PotentialSource& supply : supplies_) largest = std::max(largest, supply.potential.largest());
  return largest;
}

void ResistorCurrents::check_fixed_contacts() const {
  for (const effects::Resistor& resistor : now_.carried.resistors) {
    if (resistor.series || !has_fixed_potentials(resistor)) continue;
    const auto potential_of = [&](int supply, double constant) {
      return supplies_[supply].potential.varies() && !now_.field.supply_potential.empty()
                 ? now_.field.supply_potential[supply]
                 : constant;
    };
    const auto node_potential = [&](int node) {
      return potential_of(now_.groups.supply[node], *now_.groups.potential[node]);
    };
    const double other =
        resistor.b < 0 ? potential_of(resistor.supply, resistor.potential) : node_potential(resistor.b);
    const double difference = std::abs(node_potential(resistor.a) - other);
    if (difference > 0 && discharge_->gap(model_.bodies, contact_of(resistor)) <= 0)
      throw Failure(contact_message(resistor, difference));
  }
}

std::vector<double> ResistorCurrents::by_node(std::vector<double> by_conductor,
                                              const std::vector<double>& by_circuit) const {
  by_conductor.insert(by_conductor.end(), by_circuit.begin(), by_circuit.end());
  return by_conductor;
}

std::vector<double> ResistorCurrents::node_potentials(const effects::Electrostatics& field) const {
  return by_node(field.potential, field.circuit_potential);
}

/// Returns the potentials (V) of a solved field by node, then those of the sources if they vary.
std::vector<double> ResistorCurrents::end_potentials(const effects::Electrostatics& field) const {
  return by_node(node_potentials(field), field.supply_potential);
}

/// Returns the potential difference (V) of a resistor: end a minus the other end. `potential`: end_potentials().
double ResistorCurrents::difference_over(const effects::Resistor& resistor, std::span<const double> potential) const {
  if (resistor.b >= 0) return potential[resistor.a] - potential[resistor.b];
  const auto nodes = static_cast<std::size_t>(now_.charges.size());
  const double supply = potential.size() > nodes ? potential[nodes + resistor.supply] : resistor.potential;
  return potential[resistor.a] - supply;
}

double ResistorCurrents::current_through(const effects::Resistor& resistor,
                                         std::span<const double> node_potential) const {
  return resistor.conductance * difference_over(resistor, node_potential) + resistor.source;
}

double ResistorCurrents::charge_error(const Trial& trial) const {
  const double dt = trial.time - now_.time;
  const CarriedCharges& carried = now_.carried;
  if (carried.resistors.empty() || dt == 0) return 0;
  double largest_charge = 0, largest_supply = 0;
  for (const std::vector<double>* charges :
       {&trial.field.charge, &trial.field.terminal_charge, &trial.field.circuit_charge})
    for (const double charge : *charges) largest_charge = std::max(largest_charge, std::abs(charge));
  for (const effects::PotentialSource& supply : supplies_)
    largest_supply = std::max(largest_supply, supply.potential.largest());
  double worst = linearization_error(trial);
  for (std::size_t k = 0; k < carried.resistors.size(); ++k) {
    const double current = trial.field.carried[k] / trial.step.weight + carried.resistors[k].source;
    const double noise =
        carried.noise * scene_.field().moving_tolerance * carried.resistors[k].conductance * largest_supply;
    worst =
        std::max(worst, effects::charge_error(trial.step.weight * current + trial.step.inherited * carried.remaining[k],
                                              dt, carried.current[k], current, noise));
  }
  const double from_positions = scene_.mechanics.position_tolerance / *std::ranges::min_element(model_.bodies.radius);
  const double tolerance = std::min(from_positions, charge_tolerance(scene_.field()));
  // Charges within the noise of potentials, in a scene where no source drives any, must not shorten steps.
  const double no_charge =
      scene_.field().moving_tolerance * scene_.medium.permittivity * scene_.medium.depth * largest_supply;
  largest_charge = std::max(largest_charge, no_charge);
  return worst == 0 ? 0 : worst / (tolerance * largest_charge);
}

void ResistorCurrents::commit_charges(const Trial& trial) {
  const effects::ChargeStep& step = trial.step;
  auto& [resistors, current, remaining, total, noise, last_step] = now_.carried;
  for (std::size_t k = 0; k < resistors.size(); ++k) {
    current[k] = now_.field.carried[k] / step.weight + resistors[k].source;
    remaining[k] = step.weight * current[k] + step.inherited * remaining[k];
    total[k] = step.total_weight * current[k] + step.total_inherited * total[k];
    now_.charges.transfer(resistors[k], remaining[k], total[k]);
    if (const int terminal = resistors[k].partner - model_.bodies.size(); terminal >= 0 && !now_.received.empty())
      now_.received[terminal] += total[k];
  }
  last_step = trial.time - now_.time;
  noise = 0;
}

void ResistorCurrents::add_charges(const effects::ChargeStep& step, std::vector<double>& charge) const {
  const CarriedCharges& carried = now_.carried;
  for (std::size_t k = 0; k < carried.resistors.size(); ++k) {
    const effects::Resistor& resistor = carried.resistors[k];
    const double known = step.inherited * carried.remaining[k] + step.weight * resistor.source;
    charge[resistor.a] -= known;
    if (resistor.b >= 0) charge[resistor.b] += known;
  }
}

void ResistorCurrents::save(Checkpoint& checkpoint) const {
  if (!any()) return;
  checkpoint.reals["link_currents"] = now_.carried.current;
  checkpoint.reals["link_charges_left"] = now_.carried.remaining;
  checkpoint.reals["link_charges"] = now_.carried.total;
  checkpoint.reals["last_charge_step"] = {now_.carried.last_step, now_.carried.noise};
}

void ResistorCurrents::restore(const Checkpoint& checkpoint) {
  update(true);
  if (!any()) return;
  CarriedCharges& carried = now_.carried;
  carried.current = reals(checkpoint, "link_currents", carried.resistors.size());
  carried.remaining = reals(checkpoint, "link_charges_left", carried.resistors.size());
  carried.total = reals(checkpoint, "link_charges", carried.resistors.size());
  const std::vector<double>& last = reals(checkpoint, "last_charge_step", 2);
  carried.last_step = last[0];
  carried.noise = last[1];
}

}  // namespace lichtenberg::mechanics
