#include "src/model/neighbours.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lichtenberg {
namespace {

/// A body as a search sees it: in its cell, beside those that it is compared with.
struct Spot {
  std::array<double, 3> place{};  ///< m, z = 0 in two dimensions
  double radius = 0;              ///< m
  int body = 0;
};

double distance_squared(const Spot& a, const Spot& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (a.place[k] - b.place[k]) * (a.place[k] - b.place[k]);
  return sum;
}

/// Bodies sorted into square or cubic cells at least `width` wide.
class Cells {
 public:
  Cells(const Bodies& bodies, double width) : bodies_(bodies) {
    const int n = bodies.size();
    // No more cells than bodies, or a body that flew far away would cost memory for nothing.
    const int most = std::max(1, static_cast<int>(std::pow(n, 1.0 / bodies.dimension)));
    for (int k = 0; k < bodies.dimension; ++k) {
      double high = low_[k] = bodies.position[k];
      for (int i = 0; i < n; ++i) {
        low_[k] = std::min(low_[k], coordinate(i, k));
        high = std::max(high, coordinate(i, k));
      }
      side_[k] = std::max(width, (high - low_[k]) / most * (1 + 1e-12));
      count_[k] = static_cast<int>((high - low_[k]) / side_[k]) + 1;
    }
    sort();
  }

  Spot spot(int i) const {
    Spot spot{.radius = bodies_.radius[i], .body = i};
    for (int k = 0; k < bodies_.dimension; ++k) spot.place[k] = coordinate(i, k);
    return spot;
  }

  /// Calls visit(spot) for every body in the cells within `distance` (m) of a centre, in each direction.
  template <class Visit>
  void for_each_near(const Spot& centre, double distance, Visit visit) const {
    std::array<int, 3> first{}, last{};
    for (int k = 0; k < bodies_.dimension; ++k) {
      first[k] = column(centre.place[k] - distance, k);
      last[k] = column(centre.place[k] + distance, k);
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const int c = index(x, y, z);
          for (int s = start_[c]; s < start_[c + 1]; ++s) visit(spots_[s]);
        }
  }

 private:
  double coordinate(int i, int k) const { return bodies_.position[i * bodies_.dimension + k]; }
  int column(double x, int k) const {
    return static_cast<int>(std::clamp((x - low_[k]) / side_[k], 0.0, count_[k] - 1.0));
  }
  int index(int x, int y, int z) const { return (z * count_[1] + y) * count_[0] + x; }
  int cell_of(int i) const {
    const auto along = [&](int k) { return k < bodies_.dimension ? column(coordinate(i, k), k) : 0; };
    return index(along(0), along(1), along(2));
  }

  /// Counting sort: cell c holds spots_[start_[c]] ... spots_[start_[c + 1] - 1], in ascending order of bodies.
  void sort() {
    const int n = bodies_.size();
    start_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
    for (int i = 0; i < n; ++i) ++start_[cell_of(i) + 1];
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    std::vector<int> next(start_.begin(), start_.end() - 1);
    spots_.resize(n);
    for (int i = 0; i < n; ++i) spots_[next[cell_of(i)]++] = spot(i);
  }

  const Bodies& bodies_;
  std::array<double, 3> low_{}, side_{};
  std::array<int, 3> count_{1, 1, 1};
  std::vector<int> start_;
  std::vector<Spot> spots_;
};

}  // namespace

void in_turn(int tasks, const std::function<void(int)>& task) {
  for (int k = 0; k < tasks; ++k) task(k);
}

std::vector<Pair> pairs_closer_than(const Bodies& bodies, double range, const Share& share) {
  return pairs_within_reach(bodies, range, std::vector<double>(bodies.size()), share);
}

std::vector<Pair> pairs_within_reach(const Bodies& bodies, double range, std::span<const double> reach,
                                     const Share& share) {
  if (bodies.size() == 0) return {};
  const double largest = *std::ranges::max_element(bodies.radius);
  const double shortest = *std::ranges::min_element(reach), width = 2 * (largest + shortest) + range;
  if (!(width > 0)) return {};
  const Cells cells(bodies, width);
  // The one that reaches farther looks for the other: what one fast body costs, it alone costs.
  const auto looks_for = [&](int i, int j) { return reach[j] < reach[i] || (reach[j] == reach[i] && i < j); };
  const auto look = [&](int i, std::vector<Pair>& pairs) {
    const Spot here = cells.spot(i);
    const std::size_t found = pairs.size();
    cells.for_each_near(here, here.radius + largest + range + 2 * reach[i], [&](const Spot& there) {
      if (!looks_for(i, there.body)) return;
      const double within = here.radius + there.radius + range + reach[i] + reach[there.body];
      if (within > 0 && distance_squared(here, there) < within * within)
        pairs.push_back({std::min(i, there.body), std::max(i, there.body)});
    });
    std::sort(pairs.begin() + static_cast<std::ptrdiff_t>(found), pairs.end());
  };
  constexpr int bodies_a_task = 2048;
  const int tasks = (bodies.size() + bodies_a_task - 1) / bodies_a_task;
  std::vector<std::vector<Pair>> found(tasks);
  share(tasks, [&](int task) {
    const int first = bodies_a_task * task, end = std::min(first + bodies_a_task, bodies.size());
    for (int i = first; i < end; ++i) look(i, found[task]);
  });
  std::vector<Pair> pairs = std::move(found[0]);
  for (int task = 1; task < tasks; ++task) pairs.insert(pairs.end(), found[task].begin(), found[task].end());
  if (!std::ranges::is_sorted(pairs)) std::ranges::sort(pairs);  // where reaches differ
  return pairs;
}

void NeighbourList::update(const Bodies& bodies) {
  if (!covers(bodies, 0, bodies.size())) search(bodies);
}

void NeighbourList::search(const Bodies& bodies, const Share& share) {
  pairs_ = pairs_closer_than(bodies, range_ + skin_, share);
  searched_at_ = bodies.position;
  ++searches_;
}

bool NeighbourList::covers(const Bodies& bodies, int first, int end) const {
  if (searches_ == 0) return false;
  const int d = bodies.dimension;
  for (int i = first; i < end; ++i) {
    double moved = 0;
    for (int k = 0; k < d; ++k) {
      const double by = bodies.position[i * d + k] - searched_at_[i * d + k];
      moved += by * by;
    }
    if (moved > 0.25 * skin_ * skin_) return false;
  }
  return true;
}

}  // namespace lichtenberg
