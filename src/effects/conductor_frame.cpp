#include "src/effects/conductor_frame.hpp"

#include <fmt/format.h>

#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

/// Returns pairs of column name and pointer to the energy (J) for all energies of a circuit.
template <class Balance>
auto energies_of(Balance& balance) {
  auto& flows = balance.flows;
  return std::vector{std::pair{"energy_kinetic", &balance.kinetic},
                     std::pair{"energy_elastic", &balance.elastic},
                     std::pair{"energy_by_supplies", &flows.by_supplies},
                     std::pair{"energy_by_source", &flows.by_source},
                     std::pair{"heat_series_resistors", &flows.series_resistors},
                     std::pair{"heat_contacts", &flows.contacts},
                     std::pair{"heat_leakage", &flows.leakage},
                     std::pair{"heat_sparks", &flows.sparks},
                     std::pair{"heat_drag", &flows.drag}};
}

std::vector<double> by_terminal(const std::vector<TerminalReading>& terminals, double TerminalReading::*number) {
  std::vector<double> row;
  for (const TerminalReading& terminal : terminals) row.push_back(terminal.*number);
  return row;
}

std::vector<std::string> names_of(const std::vector<TerminalReading>& terminals) {
  std::vector<std::string> names;
  for (const TerminalReading& terminal : terminals) names.push_back(terminal.name);
  return names;
}

/// Adds the columns of charges, currents and energies of a circuit to a frame.
void add_circuit(Frame& columns, const ConductorFrame& frame) {
  const auto add_by_terminal = [&](const char* name, const char* unit, std::vector<double> row) {
    if (!row.empty()) columns.add_labelled(name, unit, std::move(row), names_of(frame.terminals));
  };
  add_by_terminal("charge_delivered", "C", by_terminal(frame.terminals, &TerminalReading::delivered));
  add_by_terminal("terminal_potential", "V", by_terminal(frame.terminals, &TerminalReading::surface_potential));
  columns.add_system("charge_leaked", "C", frame.charge_leaked);
  for (const auto& [name, joule] : energies_of(*frame.energy_balance)) columns.add_system(name, "J", *joule);
  CircuitRates rates = frame.rates.value_or(CircuitRates{});
  rates.current.resize(frame.terminals.size(), NAN);
  add_by_terminal("current", "A", rates.current);
  columns.add_system("structure_resistance", "ohm", rates.structure_resistance);
  columns.add_system("supplied_power", "W", rates.supplied_power);
  columns.add_system("dissipated_power", "W", rates.dissipated_power);
  columns.add_system("entropy_production", "W K-1", rates.entropy_production);
}

void read_terminals(const Frame& columns, ConductorFrame& frame) {
  const Column* drained = columns.find("charge_drained_by_terminal");
  if (drained == nullptr) return;
  for (const std::string& name : drained->labels) frame.terminals.push_back({.name = name});
  for (const auto& [name, number] : {std::pair{"charge_drained_by_terminal", &TerminalReading::drained},
                                     std::pair{"charge_delivered", &TerminalReading::delivered},
                                     std::pair{"terminal_potential", &TerminalReading::surface_potential}}) {
    const std::vector<double> row = columns.reals(name);
    for (std::size_t k = 0; k < std::min(row.size(), frame.terminals.size()); ++k) frame.terminals[k].*number = row[k];
  }
}

}  // namespace

Frame columns_of(const ConductorFrame& frame) {
  Frame columns{.time = frame.time};
  columns.add_vectors("position", "m", frame.position);
  columns.add_vectors("velocity", "m s-1", frame.velocity);
  if (frame.potential.empty()) return columns;
  columns.add_vectors("force", "N", frame.force);
  columns.add_particles("charge", "C", frame.charge);
  columns.add_particles("potential", "V", frame.potential);
  columns.add_particles("group", "1", std::vector<std::int32_t>(frame.group.begin(), frame.group.end()));
  columns.add_system("energy", "J", frame.energy);
  columns.add_system("charge_held", "C", frame.charge_held);
  columns.add_system("charge_fed", "C", frame.charge_fed);
  columns.add_system("charge_drained", "C", frame.charge_drained);
  if (!frame.terminals.empty())
    columns.add_labelled("charge_drained_by_terminal", "C", by_terminal(frame.terminals, &TerminalReading::drained),
                         names_of(frame.terminals));
  if (frame.energy_balance) add_circuit(columns, frame);
  columns.add_system("field_solves", "1", frame.field_solves);
  columns.add_system("iterations", "1", frame.iterations);
  return columns;
}

ConductorFrame conductor_frame(const Frame& columns) {
  const bool charged = columns.find("potential") != nullptr;
  for (const char* name : {"velocity", "force", "charge", "group", "energy", "charge_held", "charge_fed",
                           "charge_drained", "field_solves", "iterations"})
    if (charged && columns.find(name) == nullptr)
      throw InputError(fmt::format("a frame of conductors has the column potential, but no column {}", name));
  const auto number = [&](const char* name) { return columns.number(name).value_or(0); };
  ConductorFrame frame{.time = columns.time,
                       .position = columns.vectors("position"),
                       .velocity = columns.vectors("velocity"),
                       .force = columns.vectors("force"),
                       .charge = columns.reals("charge"),
                       .potential = columns.reals("potential"),
                       .group = columns.integers("group"),
                       .energy = number("energy"),
                       .charge_held = number("charge_held"),
                       .charge_fed = number("charge_fed"),
                       .charge_drained = number("charge_drained"),
                       .charge_leaked = number("charge_leaked"),
                       .field_solves = static_cast<std::int64_t>(number("field_solves")),
                       .iterations = static_cast<std::int64_t>(number("iterations"))};
  for (const std::size_t size :
       {frame.velocity.size(), frame.force.size(), frame.charge.size(), frame.potential.size(), frame.group.size()})
    if (size != frame.position.size() && (charged || size > 0))
      throw InputError("the columns of a frame have different numbers of conductors");
  read_terminals(columns, frame);
  if (!columns.find("energy_by_supplies")) return frame;
  frame.energy_balance.emplace();
  for (const auto& [name, joule] : energies_of(*frame.energy_balance)) *joule = number(name);
  return frame;
}

}  // namespace lichtenberg
