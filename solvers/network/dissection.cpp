#include "solvers/network/dissection.hpp"

#include <cholmod.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

constexpr int leaf_size = 8;  ///< Number of nodes below which parts are not cut further

/// Recursive cuts of a network by the positions of its nodes.
class Geometric {
 public:
  Geometric(const Network& network, const Incidence& incidence, const std::vector<char>& kept, parallel::Team& team)
      : network_(network), incidence_(incidence), team_(team), right_(network.nodes, 0) {
    Point low = network.position.front(), high = low;
    for (const Point& p : network.position)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    std::atomic<double> reach = 0;
    parallel::for_each_range(network.links.size(), team, [&](std::size_t begin, std::size_t end) {
      double longest = 0;
      for (std::size_t k = begin; k < end; ++k)
        if (const Link& link = network.links[k]; !kept[link.a] && !kept[link.b])
          longest = std::max(longest, distance(network.position[link.a], network.position[link.b]));
      for (double former = reach; longest > former && !reach.compare_exchange_weak(former, longest);) {
      }
    });
    // Coordinates are rounded to single precision relative to the extent.
    reach_ = static_cast<float>(reach * (1 + 1e-6) + 2.5e-7 * distance(low, high));
    for (int n = 0; n < network.nodes; ++n)
      if (const Point& p = network.position[n]; !kept[n])
        sites_.push_back(
            {{static_cast<float>(p[0] - low[0]), static_cast<float>(p[1] - low[1]), static_cast<float>(p[2] - low[2])},
             n});
  }

  Dissection run() {
    cut_above_parts();
    Dissection result;
    result.order.reserve(network_.nodes);
    result.pending = join(0, result);
    return result;
  }

 private:
  struct Site {
    std::array<float, 3> x;
    int node;
  };
  /// Sites [first, separator) on the left, [separator, middle) that separate, [middle, last) on the right.
  struct Cut {
    int separator = 0, middle = 0;
  };
  /// Range of sites. One above the parts has a cut and two children, a part has its dissection.
  struct Range {
    int first = 0, last = 0, child = -1;
    Cut cut{};
    Dissection part{};
  };

  /// Cuts ranges on threads until they are small, and dissects these parts.
  void cut_above_parts() {
    const int all = static_cast<int>(sites_.size()), largest = std::max(1 << 14, all / 128);
    ranges_.push_back({.last = all});
    for (std::size_t begin = 0; begin < ranges_.size();) {
      const std::size_t end = ranges_.size();
      team_.for_each(static_cast<int>(end - begin), [&](int k) {
        Range& range = ranges_[begin + k];
        if (range.last - range.first > largest)
          range.cut = cut(range.first, range.last);
        else
          range.part.pending = dissect_part(range.first, range.last, range.part);
      });
      for (std::size_t k = begin; k < end; ++k) {
        const int first = ranges_[k].first, last = ranges_[k].last;
        const Cut halves = ranges_[k].cut;
        if (last - first <= largest) continue;
        ranges_[k].child = static_cast<int>(ranges_.size());
        ranges_.push_back({.first = first, .last = halves.separator});
        ranges_.push_back({.first = halves.middle, .last = last});
      }
      begin = end;
    }
  }

  /// Appends the dissection of a range. Returns the number of its fronts that have no parent yet.
  int join(int r, Dissection& result) {
    if (ranges_[r].child < 0) {
      const Dissection part = std::move(ranges_[r].part);
      const int begin = static_cast<int>(result.order.size());
      result.order.insert(result.order.end(), part.order.begin(), part.order.end());
      for (const auto [first, last, children] : part.fronts)
        result.fronts.push_back({begin + first, begin + last, children});
      return part.pending;
    }
    const int left = join(ranges_[r].child, result), right = join(ranges_[r].child + 1, result);
    return add_front(ranges_[r].cut, left + right, result);
  }

  /// Returns the axis of the largest extent of some sites of a range.
  int longest_axis(int first, int last) const {
    std::array<float, 3> low = sites_[first].x, high = low;
    for (int k = first; k < last; k += 1 + (last - first) / 512)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], sites_[k].x[axis]);
        high[axis] = std::max(high[axis], sites_[k].x[axis]);
      }
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    return longest;
  }

  /// Sorts a range into two halves along an axis. The cut is the median of a sample for long ranges, and of all sites
  /// for short ones or unequal halves. Returns the first site of the right half, and the coordinate of the cut.
  std::pair<int, float> halve(int first, int last, int axis) {
    constexpr int some = 511;
    if (last - first > 4 * some) {
      std::array<float, some> x;
      for (int k = 0; k < some; ++k) x[k] = sites_[first + std::int64_t(k) * (last - first) / some].x[axis];
      std::nth_element(x.begin(), x.begin() + some / 2, x.end());
      const float at = x[some / 2];
      const int middle = static_cast<int>(std::partition(sites_.begin() + first, sites_.begin() + last,
                                                         [&](const Site& site) { return site.x[axis] < at; }) -
                                          sites_.begin());
      if (std::min(middle - first, last - middle) > (last - first) / 3) return {middle, at};
    }
    const int middle = first + (last - first) / 2;
    std::nth_element(sites_.begin() + first, sites_.begin() + middle, sites_.begin() + last,
                     [axis](const Site& a, const Site& b) {
                       return a.x[axis] != b.x[axis] ? a.x[axis] < b.x[axis] : a.node < b.node;
                     });
    return {middle, sites_[middle].x[axis]};
  }

  /// Cuts a range. Sites of the left half with a neighbour in the right half separate the rest; only sites within reach
  /// of the cut are tested. `middle` differs for all cuts and therefore marks the right half of this one.
  Cut cut(int first, int last) {
    const int axis = longest_axis(first, last);
    const auto [middle, at] = halve(first, last, axis);
    for (int k = middle; k < last; ++k)
      if (sites_[k].x[axis] <= at + reach_)
        std::atomic_ref(right_[sites_[k].node]).store(middle, std::memory_order_relaxed);
    const auto stays_left = [&](const Site& site) {
      return site.x[axis] < at - reach_ || !touches_right(site.node, middle);
    };
    const auto separator = std::partition(sites_.begin() + first, sites_.begin() + middle, stays_left);
    return {static_cast<int>(separator - sites_.begin()), middle};
  }
  bool touches_right(int node, int mark) {
    return std::ranges::any_of(incidence_.of(node), [&](int link) {
      return std::atomic_ref(right_[other_end(network_.links[link], node)]).load(std::memory_order_relaxed) == mark;
    });
  }

  /// Cuts a range recursively. Returns the number of its fronts that have no parent yet.
  int dissect_part(int first, int last, Dissection& result) {
    if (last - first <= leaf_size) return add_front({.separator = first, .middle = last}, 0, result);
    const Cut halves = cut(first, last);
    // The separator is eliminated last, but its sites stay in place: `order` grows with each front.
    const int left = dissect_part(first, halves.separator, result), right = dissect_part(halves.middle, last, result);
    return add_front(halves, left + right, result);
  }

  int add_front(Cut cut, int children, Dissection& result) const {
    if (cut.separator == cut.middle) return children;
    const int begin = static_cast<int>(result.order.size());
    for (int k = cut.separator; k < cut.middle; ++k) result.order.push_back(sites_[k].node);
    result.fronts.push_back({begin, static_cast<int>(result.order.size()), children});
    return 1;
  }

  const Network& network_;
  const Incidence& incidence_;
  parallel::Team& team_;
  std::vector<int> right_;  ///< [nodes] mark of the last cut with the node in its right half
  float reach_ = 0;
  std::vector<Site> sites_;
  std::vector<Range> ranges_;
};

/// CHOLMOD's nested dissection of a graph: METIS, and CAMD within the parts.
class ByGraph {
 public:
  ByGraph(const Network& network, const Incidence& incidence, const std::vector<char>& kept)
      : network_(network), incidence_(incidence) {
    for (int n = 0; n < network.nodes; ++n)
      if (!kept[n]) nodes_.push_back(n);
    number_.assign(network.nodes, -1);
    for (std::size_t k = 0; k < nodes_.size(); ++k) number_[nodes_[k]] = static_cast<int>(k);
  }

  Dissection run() {
    Dissection result;
    if (nodes_.empty()) return result;
    find_parts();
    const int parts = static_cast<int>(parent_.size());
    members_.resize(parts);
    children_.resize(parts);
    for (std::size_t k = 0; k < nodes_.size(); ++k) members_[part_[k]].push_back(nodes_[k]);
    for (int p = 0; p < parts; ++p)
      if (parent_[p] >= 0) children_[parent_[p]].push_back(p);
    for (int p = 0; p < parts; ++p)
      if (parent_[p] < 0) result.pending += add(p, result);
    return result;
  }

 private:
  void find_parts() {
    const int n = static_cast<int>(nodes_.size());
    cholmod_common common;
    cholmod_start(&common);
    common.nmethods = 1;
    common.current = 0;
    common.method[0].nd_small = 4 * leaf_size;
    common.method[0].nd_camd = 0;
    common.print = 0;
    cholmod_sparse* matrix = cholmod_allocate_sparse(n, n, network_.links.size(), 0, 1, 1, CHOLMOD_PATTERN, &common);
    if (matrix == nullptr) throw std::bad_alloc();
    int *start = static_cast<int*>(matrix->p), *row = static_cast<int*>(matrix->i), entries = 0;
    for (int k = 0; k < n; ++k) {
      start[k] = entries;
      for (const int link : incidence_.of(nodes_[k]))
        if (const int other = number_[other_end(network_.links[link], nodes_[k])]; other >= 0 && other < k)
          row[entries++] = other;  // Upper triangle
      std::sort(row + start[k], row + entries);
      entries = static_cast<int>(std::unique(row + start[k], row + entries) - row);
    }
    start[n] = entries;
    std::vector<int> permutation(n);
    parent_.resize(n);
    part_.resize(n);
    const auto parts =
        cholmod_nested_dissection(matrix, nullptr, 0, permutation.data(), parent_.data(), part_.data(), &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
    if (parts < 0) throw Failure("the network could not be dissected: METIS failed");
    parent_.resize(parts);
  }

  /// Adds a part after all parts that it separates. Returns the number of its fronts that have no parent yet.
  int add(int part, Dissection& result) const {
    int waiting = 0;
    for (const int child : children_[part]) waiting += add(child, result);
    if (members_[part].empty()) return waiting;
    const int begin = static_cast<int>(result.order.size());
    result.order.insert(result.order.end(), members_[part].begin(), members_[part].end());
    result.fronts.push_back({begin, static_cast<int>(result.order.size()), waiting});
    return 1;
  }

  const Network& network_;
  const Incidence& incidence_;
  std::vector<int> nodes_, number_, parent_, part_;
  std::vector<std::vector<int>> members_, children_;
};

}  // namespace

Dissection dissect(const Network& network, const Incidence& incidence, const std::vector<char>& kept,
                   parallel::Team& team) {
  Dissection result = network.position.empty() ? ByGraph(network, incidence, kept).run()
                                               : Geometric(network, incidence, kept, team).run();
  for (int n = 0; n < network.nodes; ++n)
    if (kept[n]) result.order.push_back(n);
  return result;
}

}  // namespace lichtenberg::network
