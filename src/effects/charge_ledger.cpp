#include "src/effects/charge_ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
  if (step_ > 0)
    for (std::size_t i = 0; i < charge_.size(); ++i) before_[i] = charge_[i].total();
  // Products that are kept: contracted into one of the sums, they would not be what the other adds.
  std::vector<double> fed(current.begin(), current.begin() + std::min(current.size(), charge_.size()));
  for (double& charge : fed) charge *= dt;
  for (std::size_t i = 0; i < fed.size(); ++i) charge_[i] += fed[i];
  for (const double charge : fed) fed_ += charge;
  if (step_ == 0) return;
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    const double still_there = i < fed.size() && fed[i] != 0 ? current[i] * step.fed : 0;
    const double leaked = charge_[i].total() - step.decay * before_[i] - still_there;
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

/// A group's charge among its members (two at least) as the field says; what is left goes to the last.
void share_out(std::vector<CompensatedSum>& charge, std::span<const int> members, std::span<const double> by_field) {
  CompensatedSum rest;
  for (const int i : members) rest += charge[i];
  CompensatedSum missing = rest;
  for (const int i : members) missing += -by_field[i];
  const double share = missing.total() / static_cast<double>(members.size());
  for (const int i : members.first(members.size() - 1)) {
    charge[i] = CompensatedSum(by_field[i] + share);
    rest -= charge[i];
  }
  charge[members.back()] = rest;
}

/// By id: how many members its floating group has beside the first.
std::vector<int> count_others(const ElectricalGroups& groups, int nodes) {
  std::vector<int> others(nodes);
  for (int i = 0; i < nodes; ++i) others[groups.id[i]] += groups.supply[i] < 0 && groups.id[i] != i;
  return others;
}

}  // namespace

/// Whoever is alone has what it had, and needs no list; that most are nobody foresees, so there is no branch for it.
void ChargeLedger::share_out(const ElectricalGroups& groups, std::span<const double> by_field) {
  const std::vector<int> others = count_others(groups, size());
  std::vector<int> members, end(others.size());  // of floating groups of two and more, one group after the other
  int all = 0;
  for (int i = 0; i < size(); ++i) {
    const bool is_alone = groups.supply[i] < 0 && groups.id[i] == i && others[i] == 0;
    CompensatedSum own;
    own += charge_[i];
    charge_[i] = is_alone ? own : charge_[i];
    end[i] = all;
    all += others[i] > 0 ? others[i] + 1 : 0;
  }
  members.resize(all);
  for (int i = 0; i < size(); ++i)
    if (groups.supply[i] < 0 && others[groups.id[i]] > 0) members[end[groups.id[i]]++] = i;
  for (auto first = members.begin(); first != members.end();) {
    const auto next = first + others[*first] + 1;
    effects::share_out(charge_, {first, next}, by_field);
    first = next;
  }
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
