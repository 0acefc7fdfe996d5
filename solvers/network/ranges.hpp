#pragma once

#include <algorithm>
#include <cstddef>

#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Calls task(first, last) for ranges that cover 0 ... count - 1, on the threads of a team. The ranges do not depend on
/// the number of threads. Tasks must not throw.
template <class Task>
void for_each_range(std::size_t count, parallel::Team& team, const Task& task) {
  constexpr std::size_t a_task = 1 << 15;
  team.for_each(static_cast<int>((count + a_task - 1) / a_task),
                [&](int k) { task(k * a_task, std::min(count, (k + 1) * a_task)); });
}

}  // namespace lichtenberg::network
