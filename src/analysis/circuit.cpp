#include "src/analysis/circuit.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/accuracy/gaps.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::analysis {
namespace {

/// All terminals whose potential sources have one potential, combined.
struct Pole {
  double current = 0;    ///< A, delivered
  double potential = 0;  ///< V, mean of the terminals' surface potentials
};

Pole pole(const std::vector<TerminalReading>& terminals, const std::vector<double>& current, double potential) {
  Pole pole;
  int number = 0;
  for (std::size_t k = 0; k < terminals.size(); ++k) {
    if (!terminals[k].is_source || terminals[k].potential != potential) continue;
    ++number;
    pole.current += current[k];
    // Ohm's law for the means is exact for any variation of the current.
    pole.potential += potential - terminals[k].series_resistance * current[k];
  }
  pole.potential /= number;
  return pole;
}

double structure_resistance(const std::vector<TerminalReading>& terminals, const std::vector<double>& current) {
  std::vector<TerminalReading> sources = terminals;
  std::erase_if(sources, [](const TerminalReading& terminal) { return !terminal.is_source; });
  if (sources.empty()) return NAN;
  const auto [low, high] = std::ranges::minmax(sources, {}, &TerminalReading::potential);
  if (low.potential == high.potential) return NAN;
  const Pole from = pole(terminals, current, high.potential), to = pole(terminals, current, low.potential);
  return (from.potential - to.potential) / (0.5 * (from.current - to.current));
}

}  // namespace

CircuitRates circuit_rates(const ConductorFrame& before, const ConductorFrame& now, double temperature) {
  const double dt = now.time - before.time;
  CircuitRates rates;
  for (std::size_t k = 0; k < now.terminals.size(); ++k)
    rates.current.push_back((now.terminals[k].delivered - before.terminals[k].delivered) / dt);
  rates.structure_resistance = structure_resistance(now.terminals, rates.current);
  const EnergyFlows &then = before.energy_balance->flows, &flows = now.energy_balance->flows;
  rates.supplied_power = (flows.supplied() - then.supplied()) / dt;
  rates.dissipated_power = (flows.dissipated() - then.dissipated()) / dt;
  rates.entropy_production = rates.dissipated_power / temperature;
  return rates;
}

double energy_account(const ConductorFrame& frame) {
  const EnergyBalance& energy = *frame.energy_balance;
  return frame.energy + energy.kinetic + energy.elastic + energy.flows.dissipated() - energy.flows.supplied();
}

double allowed_energy_imbalance(const Scene& scene) {
  const double radius = scene.smallest_radius();
  const double steps = std::pow(2 * scene.mechanics.position_tolerance / radius, 2.0 / 3);
  if (scene.dimension() == 3) return steps + scene.field().moving_tolerance;
  if (!scene.field().method->on_grid) return steps;
  const double cell = std::max(scene.domain.size.x, scene.domain.size.y) / scene.field().cells;
  const double gap = number_in(scene, &EffectKind::contact_gap).value_or(0);
  return steps + laplace::likely_error * laplace::difficulty({.gap = gap, .radius = radius}, cell);
}

}  // namespace lichtenberg::analysis
