#include "src/mechanics/energy_budget.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::mechanics {

namespace {

std::vector<double> mean_of(std::span<const double> a, std::span<const double> b) {
  std::vector<double> mean;
  for (std::size_t i = 0; i < a.size(); ++i) mean.push_back(0.5 * (a[i] + b[i]));
  return mean;
}

}  // namespace

EnergyBudget::EnergyBudget(const Scene& scene, double relaxation_time)
    : relaxation_time_(relaxation_time),
      supplies_(effects::potential_sources_of(scene)),
      terminals_(effects::terminals_of(scene)),
      delivered_(supplies_.size()),
      potential_rate_(effects::node_count(scene)),
      terminal_rate_(terminals_.size()),
      injected_(potential_rate_.size()),
      leaked_(injected_.size()) {}

void EnergyBudget::add_step_charges(std::span<const double> current, double dt, std::span<const double> leaked) {
  for (std::size_t i = 0; i < current.size(); ++i) injected_[i] += current[i] * dt;
  for (std::size_t i = 0; i < leaked.size(); ++i) leaked_[i] += leaked[i];
}

/// Returns the mean potential (V) of a source since the last record.
double EnergyBudget::mean_potential_of(int supply, const Instant& now) const {
  if (now.supply_potential.empty()) return supplies_[supply].potential.value;
  return 0.5 * (last_.supply_potential[supply] + now.supply_potential[supply]);
}

/// Records the energies of charges that passed through no resistor: injected, leaked, and delivered by sources.
void EnergyBudget::record_charges(const Instant& now, std::span<const double> mean_potential,
                                  std::span<const double> terminal_charge) {
  for (std::size_t i = 0; i < injected_.size(); ++i) {
    flows_.by_source += injected_[i] * mean_potential[i];
    flows_.leakage += leaked_[i] * mean_potential[i];
  }
  const double relaxed = (now.time - last_.time) / relaxation_time_;
  for (std::size_t k = 0; k < supplies_.size(); ++k) {
    double delivered = last_.drained[k] - now.drained[k];
    const double potential = mean_potential_of(static_cast<int>(k), now);
    if (k < terminals_.size() && terminals_[k].node < 0) {  // the charge on the terminal and its leakage
      const double before = last_.terminal_charge[k], after = now.terminal_charge[k];
      const double leaked = 0.5 * relaxed * (before + terminal_charge[k]);
      delivered += after - before + leaked;
      flows_.leakage += leaked * potential;
    }
    delivered_[k] += delivered;
    flows_.by_supplies += delivered * potential;
    if (!now.supply_potential.empty()) flows_.turnover += std::abs(delivered * potential);
  }
  std::ranges::fill(injected_, 0.0);
  std::ranges::fill(leaked_, 0.0);
}

/// Extrapolates potentials and charges from the last two records to just before a group merge, in which they jump.
EnergyBudget::Instant EnergyBudget::before_merger(const Instant& merged) const {
  Instant before = merged;
  const double dt = merged.time - last_.time;
  for (std::size_t i = 0; i < before.potential.size(); ++i)
    before.potential[i] = last_.potential[i] + dt * potential_rate_[i];
  for (std::size_t k = 0; k < before.terminal_charge.size(); ++k)
    before.terminal_charge[k] = last_.terminal_charge[k] + dt * terminal_rate_[k];
  return before;
}

void EnergyBudget::update_rates(const Instant& now) {
  const double dt = now.time - last_.time;
  if (dt <= 0) return;
  for (std::size_t i = 0; i < potential_rate_.size(); ++i)
    potential_rate_[i] = (now.potential[i] - last_.potential[i]) / dt;
  for (std::size_t k = 0; k < terminal_rate_.size(); ++k)
    terminal_rate_[k] = (now.terminal_charge[k] - last_.terminal_charge[k]) / dt;
}

void EnergyBudget::reset_rates() {
  std::ranges::fill(potential_rate_, 0.0);
  std::ranges::fill(terminal_rate_, 0.0);
}

void EnergyBudget::record(Instant now, std::span<const effects::Resistor> resistors, std::span<const double> carried) {
  if (!last_.potential.empty()) {
    const std::vector<double> mean = mean_of(last_.potential, now.potential);
    record_charges(now, mean, now.terminal_charge);
    update_rates(now);
    for (std::size_t k = 0; k < carried.size(); ++k) {
      const effects::Resistor& resistor = resistors[k];
      const double other = resistor.b >= 0 ? mean[resistor.b] : mean_potential_of(resistor.supply, now);
      (resistor.series ? flows_.series_resistors : flows_.contacts) += carried[k] * (mean[resistor.a] - other);
    }
  }
  last_ = std::move(now);
}

void EnergyBudget::record_merger(Instant now, double work) {
  const double supplied_before = flows_.supplied(), leaked_before = flows_.leakage;
  const Instant before = before_merger(now);
  record_charges(now, mean_of(last_.potential, before.potential), before.terminal_charge);
  const double came = flows_.supplied() - supplied_before - (flows_.leakage - leaked_before);
  flows_.sparks += last_.energy + came - work - now.energy;
  reset_rates();
  last_ = std::move(now);
}

std::size_t EnergyBudget::saved_size() const {
  const bool varies = !effects::potentials_at(supplies_, 0, true).empty();
  return 9 + 2 * (injected_.size() + terminals_.size() + supplies_.size()) + (varies ? 1 : 0);
}

std::vector<double> EnergyBudget::save() const {
  std::vector<double> saved = {flows_.by_supplies, flows_.by_source, flows_.series_resistors,
                               flows_.contacts,    flows_.leakage,   flows_.sparks,
                               flows_.drag,        last_.time,       last_.energy};
  for (const std::vector<double>* part :
       {&last_.potential, &last_.terminal_charge, &last_.drained, &delivered_, &potential_rate_, &terminal_rate_})
    saved.insert(saved.end(), part->begin(), part->end());
  if (saved.size() < saved_size()) saved.push_back(flows_.turnover);
  return saved;
}

void EnergyBudget::restore(std::span<const double> saved) {
  const auto take = [&](std::size_t n) {
    const std::span<const double> part = saved.first(n);
    saved = saved.subspan(n);
    return std::vector<double>(part.begin(), part.end());
  };
  const std::vector<double> f = take(9);
  flows_ = {f[0], f[1], f[2], f[3], f[4], f[5], f[6]};
  last_ = {f[7], f[8], take(injected_.size()), take(terminals_.size()), take(supplies_.size())};
  last_.supply_potential = effects::potentials_at(supplies_, last_.time, true);
  delivered_ = take(supplies_.size());
  potential_rate_ = take(injected_.size());
  terminal_rate_ = take(terminals_.size());
  if (!saved.empty()) flows_.turnover = saved.front();
}

}  // namespace lichtenberg::mechanics
