#include "src/commands/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/analysis/circuit.hpp"
#include "src/commands/progress.hpp"
#include "src/effects/contact_resistance.hpp"

namespace lichtenberg {
namespace {

double connected_fraction(const Outcome& outcome) {
  const double n = static_cast<double>(outcome.frame.position.size());
  return n > 0 ? outcome.network->degrees.connected / n : 0;
}

void print_network(const Outcome& outcome) {
  const analysis::DegreeDistribution& degrees = outcome.network->degrees;
  fmt::print("connected      {} of {} ({:.3g} %)\n", degrees.connected, outcome.frame.position.size(),
             100 * connected_fraction(outcome));
  fmt::print("endpoints      {} ({:.3f} of the connected)\n", degrees.endpoints(), degrees.fraction(1));
  fmt::print("branch points  {} ({:.3f} of the connected)\n", degrees.branch_points(), degrees.branching());
  fmt::print("loops          {}\n", degrees.loops);
}

/// Where a circuit's energy went.
void print_circuit(const Outcome& outcome) {
  const Frame& frame = outcome.frame;
  const EnergyFlows& flows = frame.energy_balance->flows;
  fmt::print("supplied       {:.6g} J", flows.supplied());
  if (flows.by_source != 0) fmt::print(", {:.6g} J of it by the current source", flows.by_source);
  fmt::print("\nheat           {:.6g} J:", flows.dissipated());
  const char* separator = " ";
  for (const auto& [where, joule] : {std::pair{"series resistors", flows.series_resistors},
                                     {"contacts", flows.contacts},
                                     {"the fluid's leakage", flows.leakage},
                                     {"sparks", flows.sparks},
                                     {"drag", flows.drag}}) {
    if (joule == 0) continue;
    fmt::print("{}{:.4g} J in {}", separator, joule, where);
    separator = ", ";
  }
  fmt::print("\nbalance        {:.1e} J: stored - stored at the start + heat - supplied (relative {:.1e})\n",
             energy_imbalance(outcome), relative_energy_imbalance(outcome));
  if (frame.rates)
    fmt::print(
        "resistance     {:.4g} ohm between highest and lowest terminal, {:.4g} W into heat, {:.4g} W/K of entropy "
        "(means since the frame before)\n",
        frame.rates->structure_resistance, frame.rates->dissipated_power, frame.rates->entropy_production);
}

/// What passed through each terminal, if there is a potential difference to drive it.
void print_terminals(const Frame& frame) {
  const auto differs = [&](const TerminalReading& t) { return t.potential != frame.terminals.front().potential; };
  if (std::ranges::none_of(frame.terminals, differs)) return;
  for (const TerminalReading& terminal : frame.terminals)
    fmt::print("drained        {:.6g} C to {} at {:g} V, a mean current of {:.4g} A\n", terminal.drained, terminal.name,
               terminal.potential, frame.time > 0 ? terminal.drained / frame.time : 0);
}

void print_electrics(const Outcome& outcome, const Counters& counters) {
  const Frame& frame = outcome.frame;
  fmt::print("energy         {:.6g} J\n", frame.energy);
  fmt::print("charge         {:.6g} C held + {:.6g} C drained - {:.6g} C fed", frame.charge_held, frame.charge_drained,
             frame.charge_fed);
  if (frame.charge_leaked != 0) fmt::print(" + {:.6g} C leaked", frame.charge_leaked);
  if (outcome.initial_charge != 0) fmt::print(" - {:.6g} C at the start", outcome.initial_charge);
  fmt::print(" = {:.1e} C (relative {:.1e})\n", charge_imbalance(outcome), relative_charge_imbalance(outcome));
  print_terminals(frame);
  if (frame.energy_balance) print_circuit(outcome);
  fmt::print(
      "field solves   {}, {:.3g} iterations each\n", counters.field_solves,
      static_cast<double>(counters.iterations) / static_cast<double>(std::max<std::int64_t>(counters.field_solves, 1)));
  if (outcome.largest_error)
    fmt::print("field error    at most {:.1e} of the largest value, estimated at checkpoints\n",
               *outcome.largest_error);
  if (counters.predictions > 0) fmt::print("predictions    {} between them, on a coarser grid\n", counters.predictions);
  fmt::print("contacts       {} made, {} lost\n", counters.contacts_made, counters.contacts_lost);
}

}  // namespace

void print_seconds(const std::map<std::string, double>& seconds) {
  double total = 0;
  for (const auto& [activity, value] : seconds) total += value;
  fmt::print("time           {}:", duration(total));
  const char* separator = " ";
  for (const auto& [activity, value] : seconds) {
    fmt::print("{}{} {}", separator, activity, duration(value));
    separator = ", ";
  }
  fmt::print("\n");
}

double charge_imbalance(const Outcome& outcome) {
  const Frame& frame = outcome.frame;
  return frame.charge_held + frame.charge_drained + frame.charge_leaked - frame.charge_fed - outcome.initial_charge;
}

double relative_charge_imbalance(const Outcome& outcome) {
  const Frame& frame = outcome.frame;
  double largest = 0;
  for (const double charge :
       {frame.charge_held, frame.charge_drained, frame.charge_leaked, frame.charge_fed, outcome.initial_charge})
    largest = std::max(largest, std::abs(charge));
  return largest > 0 ? charge_imbalance(outcome) / largest : 0;
}

double energy_imbalance(const Outcome& outcome) {
  return analysis::energy_account(outcome.frame) - outcome.energy_check.initial;
}

double relative_energy_imbalance(const Outcome& outcome) {
  const EnergyFlows& flows = outcome.frame.energy_balance->flows;
  const double turned_over = std::max(std::abs(flows.by_supplies) + std::abs(flows.by_source), flows.dissipated());
  return turned_over > 0 ? energy_imbalance(outcome) / turned_over : 0;
}

std::string energy_warning(const Outcome& outcome, const Scene& scene) {
  if (!outcome.frame.energy_balance) return "";
  const double found = std::abs(relative_energy_imbalance(outcome)), allowed = outcome.energy_check.allowed;
  if (found <= allowed) return "";
  const std::string what = fmt::format(
      "the energy balance is off by {:.2g} % of what was supplied or became heat, where steps and grid account for "
      "{:.2g} %",
      100 * found, 100 * allowed);
  if (scene.effects.has<effects::ContactResistanceOptions>())
    return what +
           ": conductors are pressed together before they share their charge, unless a contact's resistance times its "
           "capacitance is less than the time to cross its gap: lower the resistance in [effects.contact_resistance] "
           "or widen effects.contact_discharge.gap";
  return fmt::format("{}: take more field.cells or a smaller mechanics.{}", what,
                     scene.mechanics.integrator == "euler" ? "euler_field_step" : "position_tolerance");
}

std::vector<Quantity> quantities(const Outcome& outcome) {
  std::vector<Quantity> result{{"time", outcome.frame.time, "s"},
                               {"stationary", outcome.stationary ? 1.0 : 0.0, "1"},
                               {"energy", outcome.frame.energy, "J"},
                               {"charge_imbalance", charge_imbalance(outcome), "C"},
                               {"relative_charge_imbalance", relative_charge_imbalance(outcome), "1"}};
  if (outcome.largest_error) result.push_back({"field_error_estimate", *outcome.largest_error, "1"});
  if (const std::optional<EnergyBalance>& balance = outcome.frame.energy_balance) {
    result.push_back({"energy_supplied", balance->flows.supplied(), "J"});
    result.push_back({"heat", balance->flows.dissipated(), "J"});
    result.push_back({"energy_imbalance", energy_imbalance(outcome), "J"});
    result.push_back({"relative_energy_imbalance", relative_energy_imbalance(outcome), "1"});
    result.push_back({"allowed_energy_imbalance", outcome.energy_check.allowed, "1"});
  }
  if (outcome.network) {
    const analysis::DegreeDistribution& degrees = outcome.network->degrees;
    result.push_back({"connected_fraction", connected_fraction(outcome), "1"});
    result.push_back({"endpoint_fraction", degrees.fraction(1), "1"});
    result.push_back({"branch_fraction", degrees.branching(), "1"});
    result.push_back({"loops", static_cast<double>(degrees.loops), "1"});
  }
  return result;
}

void print_summary(const std::string& file, const Outcome& outcome, const Counters& counters,
                   const std::map<std::string, double>& seconds) {
  fmt::print("{} holds the run up to t = {:.6g} s{}\n", file, outcome.frame.time,
             outcome.stationary ? ", its stationary state" : "");
  if (outcome.network) print_network(outcome);
  if (!outcome.frame.charge.empty()) print_electrics(outcome, counters);
  print_seconds(seconds);
}

}  // namespace lichtenberg
