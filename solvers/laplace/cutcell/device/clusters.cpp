#include "solvers/laplace/cutcell/device/clusters.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "solvers/disjoint_sets.hpp"
#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/medium.hpp"

namespace lichtenberg::laplace::device {

namespace {

/// Merges links between the same two groups: adds their conductances.
void add_up(std::vector<NetworkLink>& links) {
  for (NetworkLink& link : links)
    if (link.a > link.b) std::swap(link.a, link.b);
  std::stable_sort(links.begin(), links.end(),
                   [](const NetworkLink& x, const NetworkLink& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < links.size(); ++k) {
    if (kept > 0 && links[kept - 1].a == links[k].a && links[kept - 1].b == links[k].b)
      links[kept - 1].conductance += links[k].conductance;
    else
      links[kept++] = links[k];
  }
  links.resize(kept);
}

/// Disjoint sets (union-find) of at most `most` groups, unless united without bound.
class SmallSets {
 public:
  SmallSets(int groups, int most) : sets_(groups), size_(groups, 1), most_(most) {}
  int find(int g) { return sets_.find(g); }
  void unite(int g, int h, bool bounded) {
    g = find(g), h = find(h);
    const int together = size_[g] + size_[h];
    if (g == h || (bounded && together > most_)) return;
    sets_.unite(g, h);
    size_[find(g)] = together;
  }
  int size(int g) { return size_[find(g)]; }

 private:
  DisjointSets sets_;
  std::vector<int> size_;
  int most_;
};

/// Numbers the groups of all clusters. Single groups are left out if they have no coupling to a given potential.
Clusters number(int groups, SmallSets& sets, const std::vector<double>& hold) {
  Clusters clusters;
  clusters.row.assign(groups, -1);
  std::vector<int> first(groups, -1), taken(groups, 0);
  int rows = 0;
  long entries = 0;
  std::vector<long> start(groups);
  for (int g = 0; g < groups; ++g) {
    const int set = sets.find(g), size = sets.size(g);
    if (size == 1 && (hold.empty() || hold[g] == 0)) continue;
    if (first[set] < 0) {
      first[set] = rows;
      start[set] = entries;
      rows += size;
      entries += static_cast<long>(size) * size;
      for (auto* list : {&clusters.group, &clusters.first, &clusters.size}) list->resize(rows);
      clusters.start.resize(rows);
    }
    const int row = clusters.row[g] = first[set] + taken[set];
    clusters.group[row] = g;
    clusters.first[row] = first[set];
    clusters.size[row] = size;
    clusters.start[row] = start[set] + static_cast<long>(size) * taken[set]++;
  }
  clusters.inverse.resize(entries);
  return clusters;
}

/// Computes the inverse matrix of each cluster (groups solved together). Links that leave the cluster count as ground.
void invert(Clusters& clusters, const GroupNetwork& network) {
  std::vector<double> ground = network.diagonal;
  const int rows = static_cast<int>(clusters.group.size());
  std::vector<std::vector<NetworkLink>> within(rows);  // by first row
  const auto join = [&](const NetworkLink& link) {
    const int row_a = clusters.row[link.a], row_b = clusters.row[link.b];
    if (row_a < 0 || row_b < 0 || clusters.first[row_a] != clusters.first[row_b]) return false;
    const int first = clusters.first[row_a];
    within[first].push_back({row_a - first, row_b - first, link.conductance});
    return true;
  };
  for (const NetworkLink& link : network.links) {
    if (!join(link)) continue;
    ground[link.a] = std::max(0.0, ground[link.a] - link.conductance);
    ground[link.b] = std::max(0.0, ground[link.b] - link.conductance);
  }
  for (const NetworkLink& coupling : network.couplings) join(coupling);
  for (std::size_t g = 0; g < network.hold.size(); ++g) ground[g] += network.hold[g];
  for (int first = 0; first < rows; first += clusters.size[first]) {
    std::vector<double> cluster_ground;
    for (int k = 0; k < clusters.size[first]; ++k) cluster_ground.push_back(ground[clusters.group[first + k]]);
    const std::vector<double> inverse = NetworkFactors(std::move(cluster_ground), within[first]).inverse();
    std::copy(inverse.begin(), inverse.end(), clusters.inverse.begin() + clusters.start[first]);
  }
}

/// Returns the number of groups in agglomerates of several groups that are unknowns of a grid. These agglomerates are
/// too wide or have a given potential. `h`: cell size (m).
int unknowns(const LaplaceProblem& problem, const Agglomerates& sets, double h) {
  struct SetExtent {
    int set, members;
    Vec2 low{1e300, 1e300}, high{-1e300, -1e300};
  };
  std::vector<SetExtent> extents;
  std::vector<int> number(problem.groups.size(), -1);  // by set: in `extents`
  for (std::size_t g = 0; g < number.size(); ++g) {
    const int set = sets.first_group[g];
    if (set == static_cast<int>(g)) continue;  // the set is named after this group
    if (number[set] < 0) {
      number[set] = static_cast<int>(extents.size());
      extents.push_back({set, 1});
    }
    ++extents[number[set]].members;
  }
  for (const Body& body : problem.bodies) {
    const int k = number[sets.first_group[body.group]];
    if (k < 0) continue;
    const Outline outline = outline_in_cells(body.shape, h);
    const Vec2 c = outline.centre, r{outline.size, outline.size};
    Vec2 &from = extents[k].low, &to = extents[k].high;
    from = {std::min(from.x, c.x - r.x), std::min(from.y, c.y - r.y)};
    to = {std::max(to.x, c.x + r.x), std::max(to.y, c.y + r.y)};
  }
  int count = 0;
  for (const SetExtent& of : extents) {
    const Vec2 extent = of.high - of.low;
    if (sets.is_grounded[of.set] || std::max(extent.x, extent.y) > least_extent) count += of.members;
  }
  return count;
}

}  // namespace

AgglomerateLists list_agglomerates(const LaplaceProblem& problem, std::vector<NetworkLink> links, double h,
                                   int groups) {
  constexpr int most_unknowns = 300;
  Agglomerates sets = find_agglomerates(problem, links);
  // Discards links too weak to join groups.
  std::erase_if(links, [](const NetworkLink& link) { return link.conductance <= least_joining; });
  for (double least = 4 * least_joining; !links.empty() && unknowns(problem, sets, h) > most_unknowns; least *= 4) {
    std::erase_if(links, [&](const NetworkLink& link) { return link.conductance < least; });
    sets = find_agglomerates(problem, links);
  }
  std::vector<int> bodies(groups, 0);
  for (const Body& body : problem.bodies) ++bodies[sets.first_group[body.group]];
  AgglomerateLists lists;
  for (auto* list : {&lists.first_group, &lists.group, &lists.is_alone, &lists.held}) list->resize(groups);
  lists.start.assign(groups + 1, 0);
  for (int g = 0; g < groups; ++g) {
    const bool is_own = g < static_cast<int>(problem.groups.size());
    const int set = is_own ? sets.first_group[g] : g;
    const bool held = !is_own || sets.is_grounded[set];
    lists.first_group[g] = set;
    lists.held[g] = held;
    lists.is_alone[g] = !held && bodies[set] == 1;
    ++lists.start[set + 1];
  }
  std::partial_sum(lists.start.begin(), lists.start.end(), lists.start.begin());
  std::vector<int> next(lists.start.begin(), lists.start.end() - 1);
  for (int g = 0; g < groups; ++g) lists.group[next[lists.first_group[g]]++] = g;
  return lists;
}

void couple(const LaplaceProblem& problem, double largest, double least, GroupNetwork& network) {
  network.hold.assign(network.diagonal.size(), 0.0);
  const auto lacks = [&](int g) { return problem.groups[g].floating && network.diagonal[g] == 0; };
  for (const Coupling& coupling : problem.couplings) {
    const double conductance = std::min(coupling.capacitance / problem.permittivity, largest);
    const bool a = problem.groups[coupling.a].floating, b = problem.groups[coupling.b].floating;
    if (conductance == 0 || lacks(coupling.a) || lacks(coupling.b)) continue;
    if (a && b) network.couplings.push_back({coupling.a, coupling.b, conductance});
    if (a != b) network.hold[a ? coupling.a : coupling.b] += std::max(conductance, least);
  }
}

LinkedGroups LinkedGroups::of(std::span<const double> diagonal, std::vector<NetworkLink> links,
                              std::vector<int>& index) {
  std::erase_if(links, [&](const NetworkLink& link) { return diagonal[link.a] == 0 || diagonal[link.b] == 0; });
  LinkedGroups linked;
  index.resize(diagonal.size(), -1);
  for (const NetworkLink& link : links)
    for (const int g : {link.a, link.b})
      if (std::exchange(index[g], 0) < 0) linked.group.push_back(g);
  std::ranges::sort(linked.group);
  for (const int g : linked.group) {
    index[g] = static_cast<int>(linked.network.diagonal.size());
    linked.network.diagonal.push_back(diagonal[g]);
  }
  for (NetworkLink& link : links) link = {index[link.a], index[link.b], link.conductance};
  for (const int g : linked.group) index[g] = -1;
  linked.network.links = std::move(links);
  return linked;
}

Clusters clusters_of(GroupNetwork network, int most, bool all) {
  const int groups = static_cast<int>(network.diagonal.size());
  std::erase_if(network.links, [&](const NetworkLink& link) {
    return network.diagonal[link.a] == 0 || network.diagonal[link.b] == 0;
  });
  add_up(network.links);
  std::vector<double> to_cells = network.diagonal;
  for (const auto& [a, b, conductance] : network.links) {
    to_cells[a] -= conductance;
    to_cells[b] -= conductance;
  }
  std::vector<NetworkLink> strong;
  for (const NetworkLink& link : network.links)
    if (all || 4 * link.conductance >= std::min(to_cells[link.a], to_cells[link.b])) strong.push_back(link);
  std::stable_sort(strong.begin(), strong.end(),
                   [](const NetworkLink& x, const NetworkLink& y) { return x.conductance > y.conductance; });
  SmallSets sets(groups, most);
  for (const NetworkLink& coupling : network.couplings) sets.unite(coupling.a, coupling.b, false);
  for (const NetworkLink& link : strong) sets.unite(link.a, link.b, !all);
  Clusters clusters = number(groups, sets, network.hold);
  invert(clusters, network);
  return clusters;
}

}  // namespace lichtenberg::laplace::device
