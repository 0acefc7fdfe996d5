#include "src/effects/charge_ledger.hpp"

#include <fmt/format.h>

#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::effects {

void CompensatedSum::add(double term) {
  const double sum = value_ + term;
  lost_ += std::abs(value_) >= std::abs(term) ? (value_ - sum) + term : (term - sum) + value_;
  value_ = sum;
}

namespace {

double total(std::span<const CompensatedSum> terms) {
  CompensatedSum sum;
  for (const CompensatedSum& term : terms) sum.add(term);
  return sum.total();
}

}  // namespace

ChargeLedger::ChargeLedger(std::span<const double> initial, std::size_t supplies) : drained_(supplies) {
  for (const double charge : initial) charge_.emplace_back(charge);
}

void ChargeLedger::feed(std::span<const double> current, double dt) {
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    charge_[i].add(current[i] * dt);
    fed_.add(current[i] * dt);
  }
}

void ChargeLedger::settle(const ElectricalGroups& groups, std::span<const double> by_field) {
  std::vector<std::vector<int>> members(charge_.size());  // of floating groups
  for (int i = 0; i < size(); ++i) {
    if (const int supply = groups.supply[i]; supply >= 0) {
      drained_[supply].add(charge_[i]);
      charge_[i] = CompensatedSum(by_field[i]);
      drained_[supply].subtract(charge_[i]);
    } else {
      members[groups.id[i]].push_back(i);
    }
  }
  for (const std::vector<int>& group : members) {
    if (group.empty()) continue;
    CompensatedSum rest;  // what is left to give out of what the group holds
    for (const int i : group) rest.add(charge_[i]);
    CompensatedSum missing = rest;
    for (const int i : group) missing.add(-by_field[i]);
    const double share = missing.total() / static_cast<double>(group.size());
    for (std::size_t m = 0; m + 1 < group.size(); ++m) {
      charge_[group[m]] = CompensatedSum(by_field[group[m]] + share);
      rest.subtract(charge_[group[m]]);
    }
    charge_[group.back()] = rest;
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
  for (const std::vector<CompensatedSum>& sums : {charge_, drained_, {fed_}})
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
}

}  // namespace lichtenberg::effects
