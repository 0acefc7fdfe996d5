#include "src/mechanics/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/analysis/circuit.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/surface.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::mechanics {
namespace {

using Lines = std::vector<Summary::Line>;

constexpr double max_overlap = 0.1;  ///< in diameters; larger overlaps give a warning

double connected_fraction(const Outcome& outcome) {
  const double n = static_cast<double>(outcome.frame.position.size());
  return n > 0 ? outcome.network->degrees.connected / n : 0;
}

/// Returns the charge imbalance relative to the largest charge of the balance; NaN without charges.
double relative_charge_imbalance(const Outcome& outcome) {
  const ConductorFrame& frame = outcome.frame;
  double largest = 0;
  for (const double charge :
       {frame.charge_held, frame.charge_drained, frame.charge_leaked, frame.charge_fed, outcome.initial_charge})
    largest = std::max(largest, std::abs(charge));
  return charge_imbalance(outcome) / largest;
}

/// Returns the converted energy (J): the largest of supplied energy, heat, and energy that went back and forth.
double energy_throughput(const Outcome& outcome) {
  const EnergyFlows& flows = outcome.frame.energy_balance->flows;
  return std::max({std::abs(flows.by_supplies) + std::abs(flows.by_source), flows.dissipated(), flows.turnover});
}

/// Returns the noise (J) of the energy balance: the difference between two field solves of the same state.
double noise_of_solves(const Scene& scene, const Outcome& outcome) {
  const double stored = std::max(std::abs(outcome.frame.energy), std::abs(outcome.initial_energy));
  return scene.field().method->energy_noise * scene.field().moving_tolerance * stored;
}

/// Returns the converted energy (J) or, if that is 0, the stored energy.
double energy_scale(const Outcome& outcome) {
  const double all = energy_throughput(outcome);
  return all > 0 ? all : std::max(std::abs(outcome.frame.energy), std::abs(outcome.initial_energy));
}

/// Returns the energy imbalance relative to energy_scale(); NaN without energy.
double relative_energy_imbalance(const Outcome& outcome) { return energy_imbalance(outcome) / energy_scale(outcome); }

/// Returns the error that steps and grid, or the noise of solves, explain, relative to energy_scale().
double allowed_energy_imbalance(const Scene& scene, const Outcome& outcome) {
  const double scale = energy_scale(outcome), noise = noise_of_solves(scene, outcome);
  return std::max(analysis::allowed_energy_imbalance(scene), scale > 0 ? noise / scale : 0);
}

/// Returns a fraction in brackets, or a note that there is no reference value.
std::string in_brackets(double fraction) {
  return std::isnan(fraction) ? "(no reference value)" : fmt::format("(relative {:.1e})", fraction);
}

/// Returns the relative energy imbalance, or a note that it is within the noise of field solves.
std::string imbalance_in_words(const Scene& scene, const Outcome& outcome) {
  const double noise = noise_of_solves(scene, outcome);
  const bool is_off = std::abs(relative_energy_imbalance(outcome)) > analysis::allowed_energy_imbalance(scene);
  if (is_off && std::abs(energy_imbalance(outcome)) <= noise)
    return fmt::format("(within {:.1e} J, the noise of field solves; {:.1e} J was converted)", noise,
                       energy_throughput(outcome));
  return in_brackets(relative_energy_imbalance(outcome));
}

void add_network(const Outcome& outcome, Lines& lines) {
  const analysis::DegreeDistribution& degrees = outcome.network->degrees;
  lines.push_back({"connected", fmt::format("{} of {} ({:.3g} %)", degrees.connected, outcome.frame.position.size(),
                                            100 * connected_fraction(outcome))});
  lines.push_back({"endpoints", fmt::format("{} ({:.3f} of the connected)", degrees.endpoints(), degrees.fraction(1))});
  lines.push_back(
      {"branch points", fmt::format("{} ({:.3f} of the connected)", degrees.branch_points(), degrees.branching())});
  lines.push_back({"loops", fmt::format("{}", degrees.loops)});
}

std::string charges(const Outcome& outcome) {
  const ConductorFrame& frame = outcome.frame;
  std::string text = fmt::format("{:.6g} C stored + {:.6g} C collected - {:.6g} C injected", frame.charge_held,
                                 frame.charge_drained, frame.charge_fed);
  if (frame.charge_leaked != 0) text += fmt::format(" + {:.6g} C leaked", frame.charge_leaked);
  if (outcome.initial_charge != 0) text += fmt::format(" - {:.6g} C at the start", outcome.initial_charge);
  return text +
         fmt::format(" = {:.1e} C {}", charge_imbalance(outcome), in_brackets(relative_charge_imbalance(outcome)));
}

/// Adds the charge through each terminal, if there is a potential difference.
void add_terminals(const ConductorFrame& frame, Lines& lines) {
  const auto differs = [&](const TerminalReading& t) {
    return t.is_source && t.potential != frame.terminals.front().potential;
  };
  if (std::ranges::none_of(frame.terminals, differs)) return;
  for (const TerminalReading& terminal : frame.terminals)
    if (terminal.is_source)
      lines.push_back({"collected", fmt::format("{:.6g} C to {} at {:g} V, a mean current of {:.4g} A",
                                                terminal.drained, terminal.name, terminal.potential,
                                                frame.time > 0 ? terminal.drained / frame.time : 0)});
}

std::string heat(const EnergyFlows& flows) {
  std::string text = fmt::format("{:.6g} J:", flows.dissipated());
  const char* separator = " ";
  for (const auto& [where, joule] : {std::pair{"series resistors", flows.series_resistors},
                                     {"contacts", flows.contacts},
                                     {"the fluid's leakage", flows.leakage},
                                     {"sparks", flows.sparks},
                                     {"drag", flows.drag}}) {
    if (joule == 0) continue;
    text += fmt::format("{}{:.4g} J in {}", separator, joule, where);
    separator = ", ";
  }
  return text;
}

/// Adds the energy balance of a circuit.
void add_circuit(const Scene& scene, const Outcome& outcome, Lines& lines) {
  const ConductorFrame& frame = outcome.frame;
  const EnergyFlows& flows = frame.energy_balance->flows;
  std::string supplied = fmt::format("{:.6g} J", flows.supplied());
  if (flows.by_source != 0) supplied += fmt::format(", {:.6g} J of it by the current source", flows.by_source);
  lines.push_back({"supplied", supplied});
  lines.push_back({"heat", heat(flows)});
  lines.push_back({"balance", fmt::format("{:.1e} J: stored - stored at the start + heat - supplied {}",
                                          energy_imbalance(outcome), imbalance_in_words(scene, outcome))});
  if (!frame.rates) return;
  lines.push_back({"power", fmt::format("{:.4g} W of heat, {:.4g} W/K of entropy (means since the previous frame)",
                                        frame.rates->dissipated_power, frame.rates->entropy_production)});
  // The mean needs two potentials, and relaxing charges can drive a current against the potential.
  if (std::isfinite(frame.rates->structure_resistance) && frame.rates->structure_resistance > 0)
    lines.push_back(
        {"resistance", fmt::format("{:.4g} ohm between highest and lowest terminal (since the previous frame)",
                                   frame.rates->structure_resistance)});
}

void add_electrics(const Scene& scene, const Outcome& outcome, Lines& lines) {
  const Counters& counters = outcome.counters;
  lines.push_back({"energy", fmt::format("{:.6g} J", outcome.frame.energy)});
  lines.push_back({"charge", charges(outcome)});
  add_terminals(outcome.frame, lines);
  if (outcome.frame.energy_balance) add_circuit(scene, outcome, lines);
  lines.push_back(
      {"field solves", fmt::format("{}, {:.3g} iterations each", counters.field_solves,
                                   static_cast<double>(counters.iterations) /
                                       static_cast<double>(std::max<std::int64_t>(counters.field_solves, 1)))});
  if (outcome.largest_error)
    lines.push_back({"field error", fmt::format("at most {:.1e} of the largest value, estimated at checkpoints",
                                                *outcome.largest_error)});
  if (counters.predictions > 0)
    lines.push_back({"predictions", fmt::format("{} between field solves, on a coarser grid", counters.predictions)});
  lines.push_back({"contacts", fmt::format("{} made, {} lost", counters.contacts_made, counters.contacts_lost)});
}

std::vector<Quantity> quantities(const Scene& scene, const Outcome& outcome) {
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
    result.push_back({"allowed_energy_imbalance", allowed_energy_imbalance(scene, outcome), "1"});
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

/// Names the keys to change if the energy balance has a large error: first steps, which cost less than the grid.
std::string energy_advice(const Scene& scene) {
  for (const Effects::Entry& effect : scene.effects)
    if (!effect.kind->energy_advice.empty()) return effect.kind->energy_advice;
  const IntegratorKind& integrator = scene.mechanics.kind();
  const std::string steps = integrator.accuracy ? fmt::format("set mechanics.{} = {:.2g}", integrator.accuracy_key,
                                                              0.1 * scene.mechanics.*integrator.accuracy)
                                                : fmt::format("use shorter steps of {}", integrator.name);
  const FieldOptions& field = scene.field();
  if (field.chosen_for) return steps + "; if that changes little, set a smaller field.accuracy";
  if (field.method->on_grid) return steps + "; if that changes little, use more field.cells";
  return steps + "; if that changes little, set a smaller field.moving_tolerance";
}

std::string overlap_warning(const Scene& scene, double overlap) {
  if (!(overlap > max_overlap)) return "";
  const bool contacts = scene.effects.has<effects::HertzContactOptions>();
  return fmt::format("bodies overlap by {:.2g} % of a diameter: contact laws are valid up to a few per cent; {}",
                     100 * overlap,
                     contacts ? "a larger effects.hertz_contact.young keeps bodies apart"
                              : "[effects.hertz_contact] and [effects.wall_contact] keep bodies apart");
}

std::string accuracy_warning(const Scene& scene, const Outcome& outcome) {
  const FieldAccuracy* accuracy = scene.field_accuracy();
  if (!accuracy || !(outcome.largest_error.value_or(0) > accuracy->requested)) return "";
  return fmt::format(
      "accuracy not reached: the field's error is estimated at up to {:.1e}, where field.accuracy = {:g}",
      *outcome.largest_error, accuracy->requested);
}

}  // namespace

double largest_overlap(const Scene& scene, const Bodies& bodies) {
  const auto is_fixed = [&](int i) { return scene.conductors[i].fixed; };
  double largest = 0;
  for (const auto [i, j] : pairs_closer_than(bodies, 0)) {
    if (is_fixed(i) && is_fixed(j)) continue;
    const double sum = bodies.radius[i] + bodies.radius[j];
    const Vec3 separation = bodies.box.difference(position_in_space(bodies, i), position_in_space(bodies, j));
    largest = std::max(largest, 1 - norm(separation) / sum);
  }
  std::vector<effects::Surface> surfaces;
  for (const Electrode& electrode : scene.electrodes) surfaces.push_back(effects::surface_of(electrode, scene.domain));
  const std::vector<effects::Surface> sides = effects::sides_of(scene.domain);
  for (std::size_t s = 0; s < sides.size() && !scene.domain.open; ++s)
    if (!scene.domain.sides[s].periodic) surfaces.push_back(sides[s]);
  for (int i = 0; i < bodies.size(); ++i)
    for (const effects::Surface& surface : surfaces)
      if (!is_fixed(i))
        largest = std::max(
            largest, 0.5 - 0.5 * effects::view(surface, position_in_space(bodies, i)).distance / bodies.radius[i]);
  return largest;
}

double charge_imbalance(const Outcome& outcome) {
  const ConductorFrame& frame = outcome.frame;
  return frame.charge_held + frame.charge_drained + frame.charge_leaked - frame.charge_fed - outcome.initial_charge;
}

double energy_imbalance(const Outcome& outcome) {
  return analysis::energy_account(outcome.frame) - outcome.initial_energy;
}

Summary summarize(const Scene& scene, const Outcome& outcome) {
  Summary summary{.title = fmt::format("holds the run up to t = {:.6g} s{}", outcome.frame.time,
                                       outcome.stationary ? ", its stationary state" : ""),
                  .lines = {},
                  .quantities = quantities(scene, outcome),
                  .goal = "stationary"};
  if (outcome.network) add_network(outcome, summary.lines);
  if (!outcome.frame.charge.empty()) add_electrics(scene, outcome, summary.lines);
  for (std::string warning : {energy_warning(scene, outcome), accuracy_warning(scene, outcome),
                              overlap_warning(scene, outcome.largest_overlap), effects::unresolved_bodies(scene)})
    if (!warning.empty()) summary.warnings.push_back(std::move(warning));
  return summary;
}

std::string energy_warning(const Scene& scene, const Outcome& outcome) {
  if (!outcome.frame.energy_balance) return "";
  const double found = std::abs(relative_energy_imbalance(outcome)), allowed = allowed_energy_imbalance(scene, outcome);
  const bool nothing = energy_scale(outcome) == 0 && energy_imbalance(outcome) == 0;
  if (nothing || found <= allowed) return "";
  return fmt::format(
      "energy balance off by {:.2g} % of the energy that {}, where steps, grid and solves explain {:.2g} %; {}",
      100 * found, energy_throughput(outcome) > 0 ? "was supplied or became heat" : "is stored", 100 * allowed,
      energy_advice(scene));
}

}  // namespace lichtenberg::mechanics
