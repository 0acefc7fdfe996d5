#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/smoluchowski.hpp"

namespace lichtenberg {
namespace {

using KineticStates = std::vector<theory::KineticState>;

void add_haff(TheoryTable& table, const GasParameters& gas, const std::vector<double>& times) {
  using State = theory::CoolingState;
  const std::string label = "Haff, true restitution";
  const auto states = theory::cool(gas.density, gas.impacts(true), gas.temperature, times);
  add(table, 0, {"haff_temperature", "m0 v0^2", label, values_of(states, &State::temperature)});
  add(table, 1, {"haff_square_charge", "q0^2", label, values_of(states, &State::charge_square)});
}

void add_kinetic(TheoryTable& table, const GasParameters& gas, const KineticStates& states) {
  using State = theory::KineticState;
  const std::string label = "kinetic theory";
  const auto number = [&](const State& state) { return state.density / gas.density; };
  const auto size = [&](const State& state) { return gas.density / state.density; };
  add(table, 0, {"temperature", "m0 v0^2", label, values_of(states, &State::temperature)});
  add(table, 1, {"square_charge", "q0^2", label, values_of(states, &State::charge_square)});
  add(table, 2, {"number", "1", label, values_of(states, number)});
  add(table, 3, {"size", "1", label, values_of(states, size)});
  add(table, 4, {"bjerrum", "1", label, values_of(states, &State::bjerrum)});
}

void add_coagulation(TheoryTable& table, const GasParameters& gas, const KineticStates& states) {
  const PacedGrowth growth = paced_growth(2, gas, states);
  add(table, 2, {"number_smoluchowski", "1", "Smoluchowski", growth.number});
  add(table, 3, {"size_smoluchowski", "1", "Smoluchowski", growth.size});
}

/// Converts times to the gas's own time in units of the instantaneous t_0: dtau = dt sqrt(2T)/l_0.
std::vector<double> scaled_times(const GasParameters& gas, const KineticStates& states,
                                 const std::vector<double>& times) {
  const double length = theory::hydrodynamic_length(gas.density);
  std::vector<double> scaled_time;
  double time = 0, speed = std::sqrt(2 * gas.temperature), sum = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double now = std::sqrt(2 * states[k].temperature);
    sum += (times[k] - time) * (speed + now) / 2 / length;
    scaled_time.push_back(sum);
    time = times[k], speed = now;
  }
  return scaled_time;
}

/// Adds S(k) of the longest waves. The initial noise of density is that of hard spheres in equilibrium (Percus-Yevick
/// compressibility, (1 - phi)^4/(1 + 2 phi)^2); that of temperature and velocity is of independent grains.
void add_stability(TheoryTable& table, const GasParameters& gas, const std::vector<double>& scaled_time) {
  const double filled = std::numbers::pi / 6 * gas.density;
  const double k =
      2 * std::numbers::pi * theory::hydrodynamic_length(gas.density) / std::cbrt(gas.grains / gas.density);
  const theory::TransportCoefficients c = theory::transport_coefficients(mean_restitution(gas));
  const std::pair<theory::Disturbance, double> starts[] = {
      {{1, 0, 0}, std::pow(1 - filled, 4) / std::pow(1 + 2 * filled, 2)}, {{0, 1, 0}, 2.0 / 3}, {{0, 0, 1}, 0.5}};
  TheoryColumn structure{"structure", "1", "linear stability", std::vector(scaled_time.size(), 0.0)};
  for (const auto& [start, variance] : starts) {
    const auto states = theory::disturbance_evolution(c, 0, false, k, start, scaled_time);
    for (std::size_t n = 0; n < scaled_time.size(); ++n) structure.values[n] += variance * std::norm(states[n].density);
  }
  add(table, 5, std::move(structure));
}

/// Compares the coalescence rate of the run's bound clusters with that of kinetic theory for the run's own state at
/// each frame. Errors of the theory in earlier states then do not matter.
std::optional<TheoryTable> merger_table(const GasParameters& gas, const GasTimeSeries& run) {
  const auto *number = run.find("analysis/bound_clusters"),
             *temperature = run.find("analysis/bound_cluster_local_temperature"),
             *charge = run.find("analysis/bound_cluster_square_charge");
  if (!number || !temperature || !charge || number->time.size() < 3) return {};
  TheoryTable table{.name = "mergers", .title = "coalescence rate of the run's bound clusters per volume"};
  std::vector<double> time, bjerrum, found, expected, ratio;
  const theory::Impacts impacts = gas.impacts(true);
  const double close = theory::contact_value(gas.density), volume = gas.grains / gas.density;
  for (std::size_t k = 1; k + 1 < number->time.size(); ++k) {
    if (!(number->value[k] > 0 && charge->value[k] >= 0))
      throw InputError(gas.source +
                       " is damaged: it has frames without bound clusters, or with charges that have no mean square; "
                       "`lichtenberg analyse` finds them again");
    const double mass = gas.grains / number->value[k];
    const theory::Aggregates now{gas.density / mass, temperature->value[k], charge->value[k], mass, std::cbrt(mass)};
    if (!(now.temperature > 0)) continue;
    const double heat = now.temperature / mass;
    const double frequency = 4 * now.density * now.diameter * now.diameter * close * std::sqrt(std::numbers::pi * heat);
    time.push_back(number->time[k]);
    bjerrum.push_back(now.bjerrum(gas.coupling));
    found.push_back((number->value[k - 1] - number->value[k + 1]) / (number->time[k + 1] - number->time[k - 1]) /
                    volume);
    expected.push_back(theory::encounter_rate(now) / std::numbers::pi *
                       theory::merging_integrals(2 * bjerrum.back()).number * close /
                       (1 + frequency * impacts.duration(heat)));
    ratio.push_back(found.back() / expected.back());
  }
  if (time.empty()) return {};
  table.columns = {{"time", "t0", "time", time},
                   {"bjerrum", "1", "B", bjerrum},
                   {"mergers", "1/(d0^3 t0)", "run", found},
                   {"expected_mergers", "1/(d0^3 t0)", "kinetic theory", expected},
                   {"ratio", "1", "run over theory", ratio}};
  return table;
}

void show_run(TheoryTable& table, const GasParameters& gas, const GasTimeSeries& run) {
  const std::string grains = "run: grains", clusters = "run: bound clusters";
  run.show(table, "temperature", "local_temperature", grains);
  run.show(table, "temperature", "analysis/bound_cluster_local_temperature", clusters);
  run.show(table, "square_charge", "mean_square_charge", grains);
  run.show(table, "square_charge", "analysis/bound_cluster_square_charge", clusters);
  run.show(table, "number", "analysis/bound_clusters", clusters, 1 / gas.grains);
  run.show(table, "size", "analysis/mean_bound_cluster", clusters);
  run.show(table, "bjerrum", "analysis/bound_bjerrum", clusters);
  run.show(table, "structure", "analysis/density_structure/1", grains);
}

/// Returns Haff's law, kinetic theory, coagulation and stability of one gas together with a run, without fits.
TheoryAnswer all_theories(const GasParameters& gas, const GasTimeSeries* run) {
  const std::vector<double> times = times_until(gas.end);
  const KineticStates states = merging_states(gas, times);
  TheoryTable table{.name = "course",
                    .title = "the gas over time",
                    .columns = {{"time", "t0", "time", times}},
                    .panels = {{"temperature", true, {}},
                               {R"($\langle q^2 \rangle$)", true, {}},
                               {"aggregates by initial grain", true, {}},
                               {"mean size", true, {}},
                               {"B", true, {}},
                               {"S(k) of the longest waves", true, {}}}};
  add_haff(table, gas, times);
  add_kinetic(table, gas, states);
  add_coagulation(table, gas, states);
  add_stability(table, gas, scaled_times(gas, states, times));
  if (run) show_run(table, gas, *run);
  TheoryAnswer answer{"all", "Theories of one gas, nothing fitted", common_figures(gas), {table}};
  if (run)
    if (const auto mergers = merger_table(gas, *run)) answer.tables.push_back(*mergers);
  answer.figures.push_back({"restitution", "1", mean_restitution(gas), "the constant one of linear stability"});
  answer.figures.push_back({"coupling", "1", gas.coupling * gas.exchange->strength * gas.exchange->strength, "K Q^2"});
  return answer;
}

}  // namespace

TheoryKind all_kind() {
  return {.name = "all",
          .answer = [](const TheoryRequest& request) { return all_theories(*request.gas, request.run); },
          .usual_gas = source_gas};
}

}  // namespace lichtenberg
