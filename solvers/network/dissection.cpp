#include "solvers/network/dissection.hpp"

#include <cholmod.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "solvers/error.hpp"

namespace lichtenberg::network {
namespace {

constexpr int leaf_size = 8;  ///< Number of nodes below which parts are not cut further

/// Neighbours of every node among the eliminated nodes.
struct Neighbours {
  std::vector<int> start, node;

  Neighbours(const Network& network, const std::vector<char>& kept) : start(network.nodes + 1, 0) {
    const auto counts = [&](const Link& link) { return link.a != link.b && !kept[link.a] && !kept[link.b]; };
    for (const Link& link : network.links)
      if (counts(link)) ++start[link.a], ++start[link.b];
    std::partial_sum(start.begin(), start.end(), start.begin());
    node.resize(start.back());
    for (const Link& link : network.links)
      if (counts(link)) node[--start[link.a]] = link.b, node[--start[link.b]] = link.a;
  }
};

class Geometric {
 public:
  Geometric(const Network& network, const std::vector<char>& kept) : neighbours_(network, kept), right_(network.nodes) {
    for (const Link& link : network.links)
      if (!kept[link.a] && !kept[link.b])
        reach_ = std::max(reach_, distance(network.position[link.a], network.position[link.b]));
    reach_ *= 1 + 1e-12;  // Margin for rounding of distances relative to coordinate differences
    for (int n = 0; n < network.nodes; ++n)
      if (!kept[n]) sites_.push_back({network.position[n], n});
    result_.order.reserve(network.nodes);
  }

  Dissection run() {
    result_.pending = cut(0, static_cast<int>(sites_.size()));
    return std::move(result_);
  }

 private:
  struct Site {
    Point x;
    int node;
  };

  int longest_axis(int first, int last) const {
    Point low = sites_[first].x, high = low;
    for (int k = first; k < last; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], sites_[k].x[axis]);
        high[axis] = std::max(high[axis], sites_[k].x[axis]);
      }
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    return longest;
  }

  /// Moves the sites of [first, middle) with a neighbour in [middle, last) to the end of that range, and returns the
  /// index of the first of them. Only sites within reach of the cut are tested.
  int separate(int first, int middle, int last, int axis) {
    const double at = sites_[middle].x[axis];
    ++stamp_;
    for (int k = middle; k < last; ++k)
      if (sites_[k].x[axis] <= at + reach_) right_[sites_[k].node] = stamp_;
    return static_cast<int>(
        std::partition(sites_.begin() + first, sites_.begin() + middle,
                       [&](const Site& site) { return site.x[axis] < at - reach_ || !touches_right(site.node); }) -
        sites_.begin());
  }
  bool touches_right(int node) const {
    const auto begin = neighbours_.node.begin() + neighbours_.start[node];
    const auto end = neighbours_.node.begin() + neighbours_.start[node + 1];
    return std::any_of(begin, end, [&](int n) { return right_[n] == stamp_; });
  }

  /// Cuts a range of sites recursively. Returns the number of its fronts that have no parent yet.
  int cut(int first, int last) {
    if (last - first <= leaf_size) return add_front(first, last, 0);
    const int middle = first + (last - first) / 2;
    const int axis = longest_axis(first, last);
    std::nth_element(sites_.begin() + first, sites_.begin() + middle, sites_.begin() + last,
                     [axis](const Site& a, const Site& b) {
                       return a.x[axis] != b.x[axis] ? a.x[axis] < b.x[axis] : a.node < b.node;
                     });
    const int separator = separate(first, middle, last, axis);
    // The separator is eliminated last, but its sites stay in place: `order` grows with each front.
    const int children = cut(first, separator) + cut(middle, last);
    return add_front(separator, middle, children);
  }

  int add_front(int first, int last, int children) {
    if (first == last) return children;
    const int begin = static_cast<int>(result_.order.size());
    for (int k = first; k < last; ++k) result_.order.push_back(sites_[k].node);
    result_.fronts.push_back({begin, begin + last - first, children});
    return 1;
  }

  Neighbours neighbours_;
  std::vector<int> right_;
  int stamp_ = 0;
  double reach_ = 0;
  std::vector<Site> sites_;
  Dissection result_;
};

/// CHOLMOD's nested dissection of a graph: METIS, and CAMD within the parts.
class ByGraph {
 public:
  ByGraph(const Network& network, const std::vector<char>& kept) {
    for (int n = 0; n < network.nodes; ++n)
      if (!kept[n]) nodes_.push_back(n);
    number_.assign(network.nodes, -1);
    for (std::size_t k = 0; k < nodes_.size(); ++k) number_[nodes_[k]] = static_cast<int>(k);
    neighbours_.emplace(network, kept);
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
    cholmod_sparse* matrix = cholmod_allocate_sparse(n, n, neighbours_->node.size(), 0, 1, 1, CHOLMOD_PATTERN, &common);
    if (matrix == nullptr) throw std::bad_alloc();
    int *start = static_cast<int*>(matrix->p), *row = static_cast<int*>(matrix->i), entries = 0;
    for (int k = 0; k < n; ++k) {
      start[k] = entries;
      const int node = nodes_[k];
      for (int e = neighbours_->start[node]; e < neighbours_->start[node + 1]; ++e) {
        const int other = number_[neighbours_->node[e]];
        if (other < k) row[entries++] = other;  // Upper triangle
      }
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

  std::vector<int> nodes_, number_, parent_, part_;
  std::vector<std::vector<int>> members_, children_;
  std::optional<Neighbours> neighbours_;
};

}  // namespace

Dissection dissect(const Network& network, const std::vector<char>& kept) {
  Dissection result = network.position.empty() ? ByGraph(network, kept).run() : Geometric(network, kept).run();
  for (int n = 0; n < network.nodes; ++n)
    if (kept[n]) result.order.push_back(n);
  return result;
}

}  // namespace lichtenberg::network
