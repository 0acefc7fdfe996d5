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

ChargeLedger::ChargeLedger(std::span<const double> initial) {
  for (const double charge : initial) charge_.emplace_back(charge);
}

void ChargeLedger::feed(std::span<const double> current, double dt) {
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    charge_[i].add(current[i] * dt);
    fed_.add(current[i] * dt);
  }
}

void ChargeLedger::settle(const ElectricalGroups& groups, std::span<const double> by_field) {
  std::vector<std::vector<int>> members(charge_.size());
  for (int i = 0; i < size(); ++i) members[groups.id[i]].push_back(i);
  for (const std::vector<int>& group : members) {
    if (group.empty()) continue;
    CompensatedSum rest;  // what is left to give out of what the group holds
    for (const int i : group) rest.add(charge_[i]);
    if (groups.potential[group.front()]) {
      for (const int i : group) {
        charge_[i] = CompensatedSum(by_field[i]);
        rest.subtract(charge_[i]);
      }
      drained_.add(rest);
      continue;
    }
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

double ChargeLedger::held() const {
  CompensatedSum sum;
  for (const CompensatedSum& charge : charge_) sum.add(charge);
  return sum.total();
}

std::vector<double> ChargeLedger::save() const {
  std::vector<double> saved;
  for (const CompensatedSum& charge : charge_) saved.insert(saved.end(), {charge.value(), charge.lost()});
  saved.insert(saved.end(), {fed_.value(), fed_.lost(), drained_.value(), drained_.lost()});
  return saved;
}

void ChargeLedger::restore(std::span<const double> saved) {
  const std::size_t n = charge_.size();
  if (saved.size() != 2 * n + 4)
    throw Failure(fmt::format("the checkpoint holds {} charge sums, but this scene has {}: it is of another scene",
                              saved.size() / 2, n + 2));
  for (std::size_t i = 0; i < n; ++i) charge_[i] = CompensatedSum(saved[2 * i], saved[2 * i + 1]);
  fed_ = CompensatedSum(saved[2 * n], saved[2 * n + 1]);
  drained_ = CompensatedSum(saved[2 * n + 2], saved[2 * n + 3]);
}

}  // namespace lichtenberg::effects
