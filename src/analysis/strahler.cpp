#include "src/analysis/strahler.hpp"

#include <algorithm>

#include "src/analysis/network.hpp"

namespace lichtenberg::analysis {
namespace {

/// Returns the conductors of A in an order in which each precedes its successor.
std::vector<int> predecessors_first(std::span<const int> successor) {
  const int n = static_cast<int>(successor.size());
  std::vector<int> awaited(n), order;
  for (const int next : successor)
    if (next >= 0) ++awaited[next];
  for (int i = 0; i < n; ++i)
    if (successor[i] != unconnected && awaited[i] == 0) order.push_back(i);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int next = successor[order[k]];
    if (next >= 0 && --awaited[next] == 0) order.push_back(next);
  }
  return order;
}

}  // namespace

std::vector<int> strahler_numbers(std::span<const int> successor) {
  std::vector<int> number(successor.size());
  std::vector<bool> twice(successor.size());  // true: several predecessors have the largest number so far
  for (const int i : predecessors_first(successor)) {
    number[i] = number[i] == 0 ? 1 : number[i] + twice[i];
    const int next = successor[i];
    if (next < 0) continue;
    twice[next] = number[i] == number[next] || (twice[next] && number[i] < number[next]);
    number[next] = std::max(number[next], number[i]);
  }
  return number;
}

StrahlerDistribution strahler_distribution(std::span<const int> successor, std::span<const int> strahler) {
  StrahlerDistribution result;
  const int highest = strahler.empty() ? 0 : *std::ranges::max_element(strahler);
  result.conductors.resize(highest + 1);
  result.streams.resize(highest + 1);
  for (std::size_t i = 0; i < strahler.size(); ++i) {
    if (strahler[i] == 0) continue;
    ++result.conductors[strahler[i]];
    // At most one predecessor of a conductor of order j has order j, so each stream has one end.
    const bool ends = successor[i] < 0 || strahler[successor[i]] != strahler[i];
    result.streams[strahler[i]] += ends;
  }
  return result;
}

}  // namespace lichtenberg::analysis
