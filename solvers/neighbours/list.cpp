#include "solvers/neighbours/list.hpp"

#include <algorithm>
#include <atomic>

namespace lichtenberg {
namespace {

template <int d>
Vec<d> moved(const Spheres<d>& spheres, const std::vector<double>& from, int i) {
  Vec<d> displacement;
  for (int k = 0; k < d; ++k) displacement[k] = spheres.position[i * d + k] - from[i * d + k];
  return spheres.box.any_periodic() ? spheres.box.difference(displacement, {}) : displacement;
}

}  // namespace

template <int d>
void NeighbourList::update(const Spheres<d>& spheres, parallel::Team& team) {
  constexpr int particles_a_task = 16384;
  std::atomic<bool> covered = true;
  team.for_each((spheres.size() + particles_a_task - 1) / particles_a_task, [&](int task) {
    const int first = task * particles_a_task, end = std::min(spheres.size(), first + particles_a_task);
    if (covered && !covers(spheres, first, end)) covered = false;
  });
  if (!covered) search(spheres, team);
}

template <int d>
void NeighbourList::search(const Spheres<d>& spheres, parallel::Team& team) {
  pairs_ = pairs_closer_than(spheres, range_ + skin_, team);
  searched_at_.assign(spheres.position.begin(), spheres.position.end());
  ++searches_;
}

template <int d>
bool NeighbourList::covers(const Spheres<d>& spheres, int first, int end) const {
  if (searches_ == 0 || searched_at_.size() != spheres.position.size()) return false;
  for (int i = first; i < end; ++i)
    if (has_moved_too_far(spheres, i)) return false;
  return true;
}

template <int d>
bool NeighbourList::covers(const Spheres<d>& spheres, std::span<const int> some) const {
  if (searches_ == 0 || searched_at_.size() != spheres.position.size()) return false;
  return std::ranges::none_of(some, [&](int i) { return has_moved_too_far(spheres, i); });
}

/// Returns true if the particle has moved by more than half of the skin since the last rebuild.
template <int d>
bool NeighbourList::has_moved_too_far(const Spheres<d>& spheres, int i) const {
  return norm2(moved(spheres, searched_at_, i)) > 0.25 * skin_ * skin_;
}

template void NeighbourList::update(const Spheres<2>&, parallel::Team&);
template void NeighbourList::update(const Spheres<3>&, parallel::Team&);
template void NeighbourList::search(const Spheres<2>&, parallel::Team&);
template void NeighbourList::search(const Spheres<3>&, parallel::Team&);
template bool NeighbourList::covers(const Spheres<2>&, int, int) const;
template bool NeighbourList::covers(const Spheres<3>&, int, int) const;
template bool NeighbourList::covers(const Spheres<2>&, std::span<const int>) const;
template bool NeighbourList::covers(const Spheres<3>&, std::span<const int>) const;

}  // namespace lichtenberg
