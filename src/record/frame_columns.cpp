#include "src/record/frame_columns.hpp"

#include <utility>

namespace lichtenberg {
namespace {

using Of = Column::Of;

/// [N][3], with z = 0 in two dimensions.
std::vector<double> in_space(const std::vector<Vec2>& vectors, const std::vector<double>& z = {}) {
  std::vector<double> result;
  result.reserve(3 * vectors.size());
  for (std::size_t i = 0; i < vectors.size(); ++i)
    result.insert(result.end(), {vectors[i].x, vectors[i].y, z.empty() ? 0.0 : z[i]});
  return result;
}

/// Collects columns.
struct Collected {
  std::vector<Column> columns;
  std::vector<std::string> terminals;  ///< their names

  void vectors(const char* name, const char* unit, std::vector<double> values) {
    columns.push_back({name, unit, Of::particles, 3, std::move(values)});
  }
  template <class Number>
  void each(const char* name, const char* unit, const std::vector<Number>& values) {
    if (!values.empty()) columns.push_back({name, unit, Of::particles, 0, values});
  }
  template <class Number>
  void number(const char* name, const char* unit, Number value) {
    columns.push_back({name, unit, Of::system, 0, std::vector<Number>{value}});
  }
  void by_terminal(const char* name, const char* unit, std::vector<double> values) {
    if (!terminals.empty()) columns.push_back({name, unit, Of::system, terminals.size(), std::move(values), terminals});
  }
};

std::vector<double> of_each(const std::vector<TerminalReading>& terminals, double TerminalReading::*number) {
  std::vector<double> row;
  for (const TerminalReading& terminal : terminals) row.push_back(terminal.*number);
  return row;
}

void add_circuit(Collected& found, const Frame& frame) {
  const EnergyBalance& energy = *frame.energy_balance;
  const EnergyFlows& flows = energy.flows;
  found.by_terminal("charge_delivered", "C", of_each(frame.terminals, &TerminalReading::delivered));
  found.by_terminal("terminal_potential", "V", of_each(frame.terminals, &TerminalReading::surface_potential));
  found.number("charge_leaked", "C", frame.charge_leaked);
  found.number("energy_kinetic", "J", energy.kinetic);
  found.number("energy_elastic", "J", energy.elastic);
  found.number("energy_by_supplies", "J", flows.by_supplies);
  found.number("energy_by_source", "J", flows.by_source);
  found.number("heat_series_resistors", "J", flows.series_resistors);
  found.number("heat_contacts", "J", flows.contacts);
  found.number("heat_leakage", "J", flows.leakage);
  found.number("heat_sparks", "J", flows.sparks);
  found.number("heat_drag", "J", flows.drag);
  CircuitRates rates = frame.rates.value_or(CircuitRates{});
  rates.current.resize(frame.terminals.size(), NAN);
  found.by_terminal("current", "A", std::move(rates.current));
  found.number("structure_resistance", "ohm", rates.structure_resistance);
  found.number("supplied_power", "W", rates.supplied_power);
  found.number("dissipated_power", "W", rates.dissipated_power);
  found.number("entropy_production", "W K-1", rates.entropy_production);
}

void add_network(Collected& found, const analysis::Network& network) {
  std::vector<std::int32_t> pairs;
  for (const auto& [i, j] : network.contacts) pairs.insert(pairs.end(), {i, j});
  found.columns.push_back({"contacts", "1", Of::list, 2, std::move(pairs)});
  found.each("successor", "1", network.successor);
  found.number<std::int64_t>("connected", "1", network.degrees.connected);
  found.number<std::int64_t>("endpoints", "1", network.degrees.endpoints());
  found.number<std::int64_t>("branch_points", "1", network.degrees.branch_points());
}

FrameColumns columns_of_relaxation(const Frame& frame) {
  Collected found;
  found.vectors("position", "m", in_space(frame.position, frame.z));
  found.number("energy", "J", frame.energy);
  found.number("largest_force", "N", *frame.largest_force);
  return {.time = frame.time, .time_unit = "1", .columns = std::move(found.columns)};
}

}  // namespace

FrameColumns columns_of(const Frame& frame, const std::optional<analysis::Network>& network) {
  if (frame.largest_force) return columns_of_relaxation(frame);
  Collected found;
  for (const TerminalReading& terminal : frame.terminals) found.terminals.push_back(terminal.name);
  found.vectors("position", "m", in_space(frame.position));
  found.vectors("velocity", "m s-1", in_space(frame.velocity));
  found.vectors("force", "N", in_space(frame.force));
  found.each("charge", "C", frame.charge);
  found.each("potential", "V", frame.potential);
  found.each("group", "1", frame.group);
  found.number("energy", "J", frame.energy);
  found.number("charge_held", "C", frame.charge_held);
  found.number("charge_fed", "C", frame.charge_fed);
  found.number("charge_drained", "C", frame.charge_drained);
  found.by_terminal("charge_drained_by_terminal", "C", of_each(frame.terminals, &TerminalReading::drained));
  if (frame.energy_balance) add_circuit(found, frame);
  found.number("field_solves", "1", frame.field_solves);
  found.number("iterations", "1", frame.iterations);
  if (network) add_network(found, *network);
  return {.time = frame.time, .columns = std::move(found.columns)};
}

ColumnGroup columns_of(std::span<const RelaxationState> states) {
  std::vector<std::int64_t> iteration;
  std::vector<double> energy, force;
  for (const RelaxationState& state : states) {
    iteration.push_back(state.iteration);
    energy.push_back(state.energy);
    force.push_back(state.largest_force);
  }
  return {"relaxation",
          {{"iteration", "1", Of::list, 0, std::move(iteration)},
           {"energy", "J", Of::list, 0, std::move(energy)},
           {"largest_force", "N", Of::list, 0, std::move(force)}}};
}

ColumnGroup columns_of(const analysis::Packing& packing) {
  std::vector<std::int32_t> contacts, rattler(packing.rattler.begin(), packing.rattler.end());
  std::vector<double> q, overlap, force;
  for (const analysis::PackingContact& contact : packing.contacts) {
    contacts.insert(contacts.end(), {contact.particle, contact.partner});
    q.push_back(contact.q);
    overlap.push_back(contact.overlap);
    force.push_back(contact.force);
  }
  return {"packing",
          {{"contacts", "1", Of::list, 2, std::move(contacts)},
           {"q", "1", Of::list, 0, std::move(q)},
           {"overlap", "m", Of::list, 0, std::move(overlap)},
           {"force", "N", Of::list, 0, std::move(force)},
           {"rattler", "1", Of::particles, 0, std::move(rattler)},
           {"wall_force", "N", Of::list, 0, packing.wall_force}}};
}

}  // namespace lichtenberg
