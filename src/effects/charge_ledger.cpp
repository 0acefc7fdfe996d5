#include "src/effects/charge_ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::effects {

namespace {

double total(std::span<const CompensatedSum> terms) {
  CompensatedSum sum;
  for (const CompensatedSum& term : terms) sum += term;
  return sum.total();
}

}  // namespace

ChargeLedger::ChargeLedger(std::span<const double> initial, std::size_t supplies)
    : drained_(supplies), before_(initial.size()), leaked_in_step_(initial.size()) {
  for (const double charge : initial) charge_.emplace_back(charge);
}

void ChargeLedger::leak(int node, double charge) {
  leaked_ += charge;
  leaked_in_step_[node] += charge;
}

void ChargeLedger::feed(std::span<const double> current, double dt, double relaxation_time) {
  const ChargeStep step = charge_step(dt, 0, relaxation_time);
  step_ = dt / relaxation_time;
  std::ranges::fill(leaked_in_step_, 0.0);
  if (dt == 0) return;
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    const double fed = i < current.size() ? current[i] * dt : 0;
    before_[i] = charge_[i].total();
    charge_[i] += fed;
    fed_ += fed;
    if (step_ == 0) continue;
    const double leaked = charge_[i].total() - step.decay * before_[i] - (fed == 0 ? 0 : current[i] * step.fed);
    charge_[i] += -leaked;
    leak(static_cast<int>(i), leaked);
  }
}

void ChargeLedger::carry(const Resistor& resistor, double remaining, double plain) {
  charge_[resistor.a] += -remaining;
  if (resistor.b >= 0) {
    charge_[resistor.b] += remaining;
    leaked_in_step_[resistor.a] -= plain - remaining;
    leaked_in_step_[resistor.b] += plain - remaining;
  } else {
    // To the last digit: what a loses, and what leaks of it.
    CompensatedSum missing(plain);
    missing += -remaining;
    drained_[resistor.supply] += plain;
    leaked_ -= missing;
    leaked_in_step_[resistor.a] -= missing.total();
  }
}

void ChargeLedger::settle(const ElectricalGroups& groups, std::span<const double> by_field) {
  for (int i = 0; i < size(); ++i)
    if (const int supply = groups.supply[i]; supply >= 0) {
      // Its charge went smoothly to the field's, and leaked as the mean of both.
      if (step_ > 0) {
        const double more = 0.5 * step_ * (before_[i] + by_field[i]) - leaked_in_step_[i];
        charge_[i] += -more;
        leak(i, more);
      }
      drained_[supply] += charge_[i];
      charge_[i] = CompensatedSum(by_field[i]);
      drained_[supply] -= charge_[i];
    }
  step_ = 0;
  share_out(groups, by_field);
}

namespace {

/// The charge of the group of `first`, and who is next in it, among its members, as the field says; what is left goes
/// to the last.
void share_out(std::vector<CompensatedSum>& charge, int first, std::span<const int> next,
               std::span<const double> by_field) {
  CompensatedSum rest;
  if (next[first] < 0) {
    rest += charge[first];
    charge[first] = rest;
    return;
  }
  int members = 0;
  for (int i = first; i >= 0; i = next[i], ++members) rest += charge[i];
  CompensatedSum missing = rest;
  for (int i = first; i >= 0; i = next[i]) missing += -by_field[i];
  const double share = missing.total() / members;
  for (int i = first; i >= 0; i = next[i]) {
    if (next[i] >= 0) {
      charge[i] = CompensatedSum(by_field[i] + share);
      rest -= charge[i];
    } else {
      charge[i] = rest;
    }
  }
}

}  // namespace

/// Along the chain of each floating group's members: faster, measured, than all groups' sums side by side.
void ChargeLedger::share_out(const ElectricalGroups& groups, std::span<const double> by_field) {
  // In ascending order: the first of each, and who is next.
  std::vector<int> first(charge_.size(), -1), next(charge_.size(), -1);
  for (int i = size() - 1; i >= 0; --i)
    if (groups.supply[i] < 0) next[i] = std::exchange(first[groups.id[i]], i);
  for (const int member : first)
    if (member >= 0) effects::share_out(charge_, member, next, by_field);
}

double ChargeLedger::held() const { return total(charge_); }
double ChargeLedger::drained() const { return total(drained_); }

std::vector<double> ChargeLedger::drained_by_supply() const {
  std::vector<double> drained;
  for (const CompensatedSum& sum : drained_) drained.push_back(sum.total());
  return drained;
}

std::vector<double> ChargeLedger::save() const {
  std::vector<double> saved;
  for (const std::vector<CompensatedSum>& sums : {charge_, drained_, {fed_, leaked_}})
    for (const CompensatedSum& sum : sums) saved.insert(saved.end(), {sum.value(), sum.lost()});
  return saved;
}

void ChargeLedger::restore(std::span<const double> saved) {
  if (saved.size() != saved_size())
    throw Failure(fmt::format("the checkpoint holds {} charge sums, but this scene has {}: it is of another scene",
                              saved.size() / 2, saved_size() / 2));
  const auto sum = [&](std::size_t k) { return CompensatedSum(saved[2 * k], saved[2 * k + 1]); };
  const std::size_t n = charge_.size();
  for (std::size_t i = 0; i < n; ++i) charge_[i] = sum(i);
  for (std::size_t k = 0; k < drained_.size(); ++k) drained_[k] = sum(n + k);
  fed_ = sum(n + drained_.size());
  leaked_ = sum(n + drained_.size() + 1);
}

}  // namespace lichtenberg::effects
