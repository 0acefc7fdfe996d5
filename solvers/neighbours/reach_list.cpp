#include "solvers/neighbours/reach_list.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lichtenberg {
namespace {

/// Returns true if the pair is within range plus reaches, in a box without periodic sides.
template <int d>
bool is_within(const Spheres<d>& spheres, double range, std::span<const double> reach, int i, int j) {
  const double within = spheres.radius[i] + spheres.radius[j] + range + reach[i] + reach[j];
  return within > 0 && norm2(spheres.centre(i) - spheres.centre(j)) < within * within;
}

}  // namespace

/// Updates the displacements and the list of far particles; returns false if a rebuild is needed.
template <int d>
bool ReachList::covers(const Spheres<d>& spheres, double range, std::span<const double> reach) {
  if (searches_ == 0 || searched_at_.size() != spheres.position.size() || range > range_) return false;
  const double half = 0.5 * (range_ - range);
  far_.clear();
  gap_reduction_.resize(spheres.size());
  farthest_ = 0;
  const int n = spheres.size();
  for (int i = 0; i < n; ++i) {
    Vec<d> displacement;
    for (int k = 0; k < d; ++k) displacement[k] = spheres.position[i * d + k] - searched_at_[i * d + k];
    moved_[i] = norm(displacement);
    const double reach_and_displacement = reach[i] + moved_[i];
    is_far_[i] = reach_and_displacement > half;
    gap_reduction_[i] = {reach[i] - moved_[i], reach_and_displacement};
    if (is_far_[i]) {
      far_.push_back(i);
      gap_reduction_[i] = {-INFINITY, -INFINITY};
    } else {
      farthest_ = std::max(farthest_, reach_and_displacement);
    }
  }
  // A rebuild costs as much as some hundred comparisons per particle.
  const std::size_t most = std::max(32, n / 128);
  return far_.size() <= most;
}

template <int d>
void ReachList::search(const Spheres<d>& spheres, double range) {
  skin_ = *std::ranges::min_element(spheres.radius);
  range_ = range + skin_;
  candidates_ = pairs_closer_than(spheres, range_);
  gap_.clear();
  for (const Pair pair : candidates_)
    gap_.push_back(norm(spheres.centre(pair.i) - spheres.centre(pair.j)) - spheres.radius[pair.i] -
                   spheres.radius[pair.j]);
  by_gap_.resize(candidates_.size());
  std::iota(by_gap_.begin(), by_gap_.end(), 0);
  std::ranges::sort(by_gap_, {}, [&](int k) { return gap_[k]; });
  largest_radius_ = *std::ranges::max_element(spheres.radius);
  by_coordinate_.resize(spheres.size());
  std::iota(by_coordinate_.begin(), by_coordinate_.end(), 0);
  std::ranges::sort(by_coordinate_, {}, [&](int i) { return spheres.position[i * d]; });
  sorted_coordinate_.clear();
  for (const int i : by_coordinate_) sorted_coordinate_.push_back(spheres.position[i * d]);
  note_search(spheres);
}

template <int d>
void ReachList::note_search(const Spheres<d>& spheres) {
  searched_at_.assign(spheres.position.begin(), spheres.position.end());
  moved_.assign(spheres.radius.size(), 0.0);
  is_far_.assign(spheres.radius.size(), false);
  ++searches_;
}

template <int d>
std::vector<Pair> ReachList::pairs(const Spheres<d>& spheres, double range, std::span<const double> reach) {
  if (spheres.box.any_periodic() || spheres.size() == 0) {
    note_search(spheres);
    return pairs_within_reach(spheres, range, reach);
  }
  if (!covers(spheres, range, reach)) {
    search(spheres, std::max(range, range_ - skin_));
    if (!covers(spheres, range, reach)) return pairs_within_reach(spheres, range, reach);
  }
  std::vector<Pair> found;
  const double rounding = 1e-9 * skin_, widest = range + 2 * farthest_ + rounding;
  const auto test_candidate = [&](std::size_t k) {
    const double excess = gap_[k] - range;
    const auto [i, j] = candidates_[k];
    if (excess - rounding >= gap_reduction_[i].most + gap_reduction_[j].most) return;
    if (excess + rounding < gap_reduction_[i].least + gap_reduction_[j].least || is_within(spheres, range, reach, i, j))
      found.push_back(candidates_[k]);
  };
  const auto close = std::ranges::lower_bound(by_gap_, widest, {}, [&](int k) { return gap_[k]; });
  // A small selection is sorted faster than all candidates are tested.
  if (8 * (close - by_gap_.begin()) < std::ssize(by_gap_)) {
    for (auto k = by_gap_.begin(); k != close; ++k) test_candidate(*k);
    std::ranges::sort(found);
  } else {
    found.reserve(candidates_.size());
    for (std::size_t k = 0; k < candidates_.size(); ++k)
      if (gap_[k] < widest) test_candidate(k);
  }
  const auto near = static_cast<std::ptrdiff_t>(found.size());
  add_far(spheres, range, reach, found);
  std::sort(found.begin() + near, found.end());
  std::inplace_merge(found.begin(), found.begin() + near, found.end());
  return found;
}

/// Adds pairs of far particles: with each other, and with others, whose displacement since the rebuild is at most
/// farthest_ less their reach.
template <int d>
void ReachList::add_far(const Spheres<d>& spheres, double range, std::span<const double> reach,
                        std::vector<Pair>& found) const {
  for (auto far = far_.begin(); far != far_.end(); ++far) {
    const int i = *far;
    for (auto other = far + 1; other != far_.end(); ++other)
      if (is_within(spheres, range, reach, i, *other)) found.push_back({i, *other});
    const double x = spheres.position[i * d];
    const double within = spheres.radius[i] + largest_radius_ + range + reach[i] + farthest_ + 1e-9 * skin_;
    const auto first = std::ranges::lower_bound(sorted_coordinate_, x - within) - sorted_coordinate_.begin();
    const auto last = std::ranges::upper_bound(sorted_coordinate_, x + within) - sorted_coordinate_.begin();
    for (auto k = first; k < last; ++k)
      if (const int j = by_coordinate_[k]; !is_far_[j] && is_within(spheres, range, reach, i, j))
        found.push_back({std::min(i, j), std::max(i, j)});
  }
}

template std::vector<Pair> ReachList::pairs(const Spheres<2>&, double, std::span<const double>);
template std::vector<Pair> ReachList::pairs(const Spheres<3>&, double, std::span<const double>);

}  // namespace lichtenberg
