#include "src/effects/charges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "solvers/error.hpp"
#include "src/model/body_ranges.hpp"

namespace lichtenberg::effects {

namespace {

double total(std::span<const CompensatedSum> terms) {
  CompensatedSum sum;
  for (const CompensatedSum& term : terms) sum += term;
  return sum.total();
}

/// Divides the total charge of an equipotential group among its members (at least two) according to the field's charges
/// `by_field` (C). The last member takes the remainder, so that the total is exact.
void redistribute(std::vector<CompensatedSum>& charge, std::span<const int> members, std::span<const double> by_field) {
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

/// Floating groups with at least two members, stored contiguously, each in ascending order.
struct SharedGroups {
  std::vector<int> members;
  std::vector<int> begin;  ///< start of each group in `members`, and the end of the last
};

SharedGroups shared_groups(const ElectricalGroups& groups, int nodes) {
  std::vector<int> joined(nodes + 1), members_of(nodes);  // joined: all nodes except the first of each group
  int others = 0;
  for (int i = 0; i < nodes; ++i) {  // no branch, because branch prediction would fail
    joined[others] = i;
    others += (groups.supply[i] < 0) & (groups.id[i] != i);
  }
  joined.resize(others);
  for (const int i : joined) ++members_of[groups.id[i]];
  SharedGroups shared;
  std::vector<int>& slot = members_of;
  int all = 0;
  for (const int i : joined) {
    int& next = slot[groups.id[i]];
    if (next > 0) {  // first occurrence of the group
      shared.begin.push_back(all);
      shared.members.resize(all + next + 1);
      shared.members[all] = groups.id[i];
      all += std::exchange(next, -(all + 1)) + 1;
    }
    shared.members[-next] = i;
    --next;
  }
  shared.begin.push_back(all);
  return shared;
}

}  // namespace

Charges::Charges(std::span<const double> initial, std::size_t supplies)
    : collected_(supplies), before_(initial.size()), leaked_in_step_(initial.size()) {
  for (const double charge : initial) charge_.emplace_back(charge);
}

void Charges::leak(int node, double charge) {
  leaked_ += charge;
  leaked_in_step_[node] += charge;
}

void Charges::inject(std::span<const double> current, double dt, double relaxation_time) {
  const ChargeStep step = charge_step(dt, 0, relaxation_time);
  step_ = dt / relaxation_time;
  std::ranges::fill(leaked_in_step_, 0.0);
  if (dt == 0) return;
  if (step_ > 0)
    for (std::size_t i = 0; i < charge_.size(); ++i) before_[i] = charge_[i].total();
  // Products are stored in an array. Contracted into one of the sums, they could differ from the summands of the other.
  std::vector<double> injected(current.begin(), current.begin() + std::min(current.size(), charge_.size()));
  for (double& charge : injected) charge *= dt;
  for (std::size_t i = 0; i < injected.size(); ++i) charge_[i] += injected[i];
  for (const double charge : injected) injected_ += charge;
  if (step_ == 0) return;
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    const double still_there = i < injected.size() && injected[i] != 0 ? current[i] * step.injection_time : 0;
    const double leaked = charge_[i].total() - step.decay * before_[i] - still_there;
    charge_[i] += -leaked;
    leak(static_cast<int>(i), leaked);
  }
}

void Charges::transfer(const Resistor& resistor, double remaining, double total) {
  charge_[resistor.a] += -remaining;
  if (resistor.b >= 0) {
    charge_[resistor.b] += remaining;
    leaked_in_step_[resistor.a] -= total - remaining;
    leaked_in_step_[resistor.b] += total - remaining;
  } else {
    // Both the loss of a and its leaked part are exact to the last digit.
    CompensatedSum missing(total);
    missing += -remaining;
    collected_[resistor.supply] += total;
    leaked_ -= missing;
    leaked_in_step_[resistor.a] -= missing.total();
  }
}

void Charges::distribute(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team) {
  for (int i = 0; i < size(); ++i)
    if (const int supply = groups.supply[i]; supply >= 0) {
      // Trapezoidal leakage from the old charge and the field's charge.
      if (step_ > 0) {
        const double more = 0.5 * step_ * (before_[i] + by_field[i]) - leaked_in_step_[i];
        charge_[i] += -more;
        leak(i, more);
      }
      collected_[supply] += charge_[i];
      charge_[i] = CompensatedSum(by_field[i]);
      collected_[supply] -= charge_[i];
    }
  step_ = 0;
  redistribute(groups, by_field, team);
}

/// Redistributes the charges of floating groups. Single-member groups keep their charge, renormalized by one
/// compensated addition. For efficiency this addition is applied to all nodes. Among members of groups it changes only
/// the last, which holds the remainder, so that charge is restored.
void Charges::redistribute(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team) {
  const SharedGroups shared = shared_groups(groups, size());
  const std::size_t count = shared.begin.size() - 1;
  std::vector<CompensatedSum> rests(count);
  for_ranges(team, static_cast<int>(shared.members.size()), [&](int first, int end) {
    auto begin = std::ranges::lower_bound(shared.begin.begin(), shared.begin.end() - 1, first);
    for (; begin + 1 != shared.begin.end() && *begin < end; ++begin) {
      const auto members = std::span(shared.members).subspan(*begin, begin[1] - *begin);
      effects::redistribute(charge_, members, by_field);
      rests[begin - shared.begin.begin()] = charge_[members.back()];
    }
  });
  for_ranges(team, size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      CompensatedSum own(charge_[i].value());
      own += charge_[i].lost();
      charge_[i] = own;
    }
  });
  for (std::size_t g = 0; g < count; ++g) charge_[shared.members[shared.begin[g + 1] - 1]] = rests[g];
}

std::vector<double> Charges::after(const ChargeStep& step, std::span<const double> current,
                                   parallel::Team& team) const {
  std::vector<double> charge(current.begin(), current.begin() + std::min(current.size(), charge_.size()));
  for (double& injected : charge) injected *= step.injection_time;
  charge.resize(charge_.size());
  for_ranges(team, size(), [&](int first, int end) {
    for (int i = first; i < end; ++i) charge[i] += step.decay * charge_[i].total();
  });
  return charge;
}

double Charges::stored() const { return total(charge_); }
double Charges::collected() const { return total(collected_); }

std::vector<double> Charges::collected_by_source() const {
  std::vector<double> collected;
  for (const CompensatedSum& sum : collected_) collected.push_back(sum.total());
  return collected;
}

std::vector<double> Charges::save() const {
  std::vector<double> saved;
  for (const std::vector<CompensatedSum>& sums : {charge_, collected_, {injected_, leaked_}})
    for (const CompensatedSum& sum : sums) saved.insert(saved.end(), {sum.value(), sum.lost()});
  return saved;
}

void Charges::restore(std::span<const double> saved) {
  if (saved.size() != saved_size())
    throw Failure(fmt::format("the checkpoint holds {} charge sums, but this scene has {}: it is of another scene",
                              saved.size() / 2, saved_size() / 2));
  const auto sum = [&](std::size_t k) { return CompensatedSum(saved[2 * k], saved[2 * k + 1]); };
  const std::size_t n = charge_.size();
  for (std::size_t i = 0; i < n; ++i) charge_[i] = sum(i);
  for (std::size_t k = 0; k < collected_.size(); ++k) collected_[k] = sum(n + k);
  injected_ = sum(n + collected_.size());
  leaked_ = sum(n + collected_.size() + 1);
}

}  // namespace lichtenberg::effects
