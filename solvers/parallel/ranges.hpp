#pragma once

#include <algorithm>

#include "solvers/parallel/team.hpp"

namespace lichtenberg::parallel {

/// Calls task(first, last) for ranges of `size` indices that cover 0 ... count - 1, first <= k < last, on the threads
/// of a team. The ranges do not depend on the number of threads. Tasks must not throw.
template <int size = 1 << 15, class Index, class Task>
void for_each_range(Index count, Team& team, const Task& task) {
  team.for_each(static_cast<int>((count + size - 1) / size), [&](int k) {
    const Index first = static_cast<Index>(k) * size;
    task(first, std::min<Index>(count, first + size));
  });
}

}  // namespace lichtenberg::parallel
