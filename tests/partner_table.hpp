#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/neighbours/table.hpp"
#include "solvers/parallel/array.hpp"

namespace lichtenberg {

/// Partners of every particle in ascending order, with each pair in the rows of both particles.
template <class Executor>
class PartnerTable {
 public:
  /// `pairs`: in ascending order, of n particles.
  PartnerTable(const Executor& run, std::span<const Pair> pairs, int n) : start_(run), partner_(run) {
    std::vector<int> start(n + 1, 0), partner(2 * pairs.size());
    for (const Pair pair : pairs) ++start[pair.i + 1], ++start[pair.j + 1];
    for (int i = 0; i < n; ++i) start[i + 1] += start[i];
    std::vector<int> next(start.begin(), start.end() - 1);
    for (const Pair pair : pairs) partner[next[pair.i]++] = pair.j, partner[next[pair.j]++] = pair.i;
    start_.upload(start);
    partner_.upload(partner);
  }
  TableView view() const { return {start_.data(), partner_.data()}; }

 private:
  parallel::Array<int, Executor> start_, partner_;
};

}  // namespace lichtenberg
