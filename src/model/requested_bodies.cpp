#include "src/model/requested_bodies.hpp"

#include <algorithm>

namespace lichtenberg {

std::span<const Pair> RequestedBodies::neighbours(NeighbourList& list, const Bodies& all, parallel::Team& team) {
  if (bodies_.empty() || search_ < 0 || !covers(list, all, bodies_)) update(list, all, team);
  if (bodies_.empty()) return list.pairs();
  if (search_ == list.searches()) return pairs_;
  search_ = list.searches();
  std::vector<char> requested(all.size());
  for (const int i : bodies_) requested[i] = true;
  pairs_.clear();
  std::ranges::copy_if(list.pairs(), std::back_inserter(pairs_),
                       [&](Pair p) { return requested[p.i] || requested[p.j]; });
  return pairs_;
}

}  // namespace lichtenberg
