#pragma once

#include "solvers/neighbours/list.hpp"
#include "solvers/neighbours/reach_list.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg {

/// Calls f with views of the positions, radii and charges of the bodies, as Spheres<d> for their dimension d. Returns
/// the result of f.
template <class F>
decltype(auto) visit_spheres(const Bodies& bodies, F&& f) {
  return bodies.dimension == 3 ? f(spheres<3>(bodies)) : f(spheres<2>(bodies));
}

inline std::vector<Pair> pairs_closer_than(const Bodies& bodies, double range,
                                           parallel::Team& team = parallel::Team::single()) {
  return visit_spheres(bodies, [&](const auto& s) { return pairs_closer_than(s, range, team); });
}
inline std::vector<Pair> pairs_within_reach(const Bodies& bodies, double range, std::span<const double> reach,
                                            parallel::Team& team = parallel::Team::single()) {
  return visit_spheres(bodies, [&](const auto& s) { return pairs_within_reach(s, range, reach, team); });
}
inline std::vector<Pair> pairs_within_reach(ReachList& list, const Bodies& bodies, double range,
                                            std::span<const double> reach) {
  return visit_spheres(bodies, [&](const auto& s) { return list.pairs(s, range, reach); });
}
inline void update(NeighbourList& list, const Bodies& bodies, parallel::Team& team = parallel::Team::single()) {
  visit_spheres(bodies, [&](const auto& s) { list.update(s, team); });
}
inline bool covers(const NeighbourList& list, const Bodies& bodies, std::span<const int> some) {
  return visit_spheres(bodies, [&](const auto& s) { return list.covers(s, some); });
}

}  // namespace lichtenberg
