#pragma once

// Set-up on the host where direct links of groups outweigh their links to cells. It makes sets of groups that coarse
// grids treat as one, and inverts clusters of groups that are relaxed together.

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/device/clusters.hpp"
#include "solvers/laplace/cutcell/device/relax_clusters.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Lists the links between groups, each once: first direct links (gap conductances), then links that arise where the
/// V-cycle eliminates a near-surface cell. (Such a cell has a large conductance to a conductor.) Unused entries have a
/// = -1. Also copies the diagonals of the groups' equations in the V-cycle and, on the finest grid, their diagonals in
/// the system. A group is a set of bodies with one potential.
template <class Executor>
void list_group_links(const Executor& run, ProblemView problem, GridView grid, NetworkLink* link, double* diagonal) {
  const int direct = grid.capacity[Items::direct_links], all = direct + grid.capacity[Items::joined_links];
  run.for_each(all, [=] LICHTENBERG_HOST_DEVICE(int m) {
    link[m] = {-1, -1, 0};
    const bool is_joined = m >= direct;
    const int number = is_joined ? m - direct : m;
    if (number >= grid.number[is_joined ? Items::joined_links : Items::direct_links]) return;
    const DirectLink& listed = is_joined ? grid.bound.joined[number] : grid.direct.link[number];
    if (listed.is_to_electrode()) return;
    const int a = problem.group_of[listed.own], b = problem.group_of[listed.other];
    if (a < b) link[m] = {a, b, listed.conductance};
  });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    diagonal[g] = grid.groups.cycle_diagonal[g];
    if (grid.finest) diagonal[problem.groups + g] = grid.groups.diagonal[g];
  });
}

/// Row of a group (bodies with one potential) in the list of clusters (groups solved together). `group`: number of the
/// group, counted through all grids.
struct RowOfGroup {
  long group;
  int row;
};

/// Clusters of all grids in device memory. A cluster is a set of strongly linked groups (bodies with one potential)
/// whose potentials are relaxed together by an inverse matrix.
template <class Executor>
class DeviceClusters {
 public:
  /// Reserves memory for the views of `grids` grids, without clusters (groups solved together).
  DeviceClusters(const Executor& run, int grids) : run_(&run), data_(run), row_(run), view_(run) {
    view_.resize(grids);
  }
  /// Returns a device pointer to the clusters (groups solved together) of a grid.
  const ClusterView* view(int grid) const { return view_.data() + grid; }

  /// Uploads the clusters (groups solved together) of all grids. `groups`: number of groups (bodies with one potential)
  /// on each grid. The device computes the row of each group from the list of rows, which is short. No kernel that
  /// reads earlier clusters may be pending.
  void upload(const std::vector<Clusters>& grids, int groups) {
    host_.clear();
    std::vector<std::array<std::size_t, 5>> offset;
    std::vector<RowOfGroup> rows;
    for (const Clusters& clusters : grids) {
      for (std::size_t row = 0; row < clusters.group.size(); ++row)
        rows.push_back({static_cast<long>(offset.size()) * groups + clusters.group[row], static_cast<int>(row)});
      offset.push_back({append(clusters.group), append(clusters.first), append(clusters.size), append(clusters.start),
                        append(clusters.inverse)});
    }
    const std::size_t offset_of_rows = append(rows);
    data_.upload(host_);
    row_.resize(grids.size() * groups);
    int* row = row_.data();
    run_->fill(row, 0xff, row_.size() * sizeof(int));  // -1
    const RowOfGroup* of = at<RowOfGroup>(offset_of_rows);
    run_->for_each(static_cast<long>(rows.size()),
                   [=] LICHTENBERG_HOST_DEVICE(int k) { row[of[k].group] = of[k].row; });
    std::vector<ClusterView> views;
    for (const auto& [group, first, size, start, inverse] : offset)
      views.push_back({row + views.size() * groups, at<int>(group), at<int>(first), at<int>(size), at<long>(start),
                       at<double>(inverse)});
    run_->to_device(view_.data(), views.data(), views.size() * sizeof(ClusterView));
  }

 private:
  template <class T>
  std::size_t append(const std::vector<T>& values) {
    const std::size_t from = host_.size(), bytes = values.size() * sizeof(T);
    host_.resize(from + (bytes + 7) / 8 * 8);
    if (bytes > 0) std::memcpy(host_.data() + from, values.data(), bytes);
    return from;
  }
  template <class T>
  const T* at(std::size_t offset) const {
    return reinterpret_cast<const T*>(data_.data() + offset);
  }

  const Executor* run_;
  std::vector<char> host_;
  parallel::Array<char, Executor> data_;
  parallel::Array<int, Executor> row_;
  parallel::Array<ClusterView, Executor> view_;
};

/// Set-up on the host of clusters, strongly linked groups that are relaxed together, and of agglomerates. Agglomerates
/// are sets of groups that coarse grids treat as one. A group is a set of bodies with one potential. The class fetches
/// the conductances between groups of all grids from the device and uploads the results.
template <class Executor>
class Clustering {
 public:
  /// Prepares the set-up for a number of grids.
  Clustering(const Executor& run, int grids) : run_(run), grids_(grids), sets_(run), clusters_(run, grids + 1) {
    for (int k = 0; k < 2; ++k) reports_.push_back(std::make_unique<parallel::PackedTransfer<Executor>>(run));
  }

  /// Returns a device pointer to the clusters (groups solved together) of a grid, for the V-cycle.
  const ClusterView* clusters(int grid) const { return clusters_.view(grid); }
  /// Returns a device pointer to the clusters (groups solved together) of the finest grid's system, which contain all
  /// couplings and direct links (gap conductances).
  const ClusterView* exact_clusters() const { return clusters_.view(grids_); }
  /// Reserves memory for the agglomerates of `groups` groups (bodies with one potential), and returns device pointers
  /// to it. Agglomerates are sets of groups that coarse grids treat as one.
  SetsView reserve_sets(int groups) {
    const auto n = static_cast<std::size_t>(groups);
    std::tie(first_group_, start_, group_, is_alone_, held_) =
        sets_.template divide<int, int, int, int, int>({n, n + 1, n, n, n});
    return {first_group_.device, start_.device, group_.device, is_alone_.device, held_.device};
  }
  /// Reserves memory for the conductances between groups (bodies with one potential). The conductances of all grids
  /// except the finest are fetched together. `grids`: the views of all grids.
  void reserve_links(int groups, const std::vector<GridView>& grids) {
    grid_links_.clear();
    for (int part = 0; part < 2; ++part) {
      const std::size_t from = part, to = part == 0 ? 1 : grids.size();
      if (from == to) continue;
      std::size_t links = 0;
      for (std::size_t l = from; l < to; ++l) links += all_links(grids[l]);
      const std::size_t diagonals = part == 0 ? 2 : to - from;
      auto [link, diagonal] =
          reports_[part]->template divide<NetworkLink, double>({links, diagonals * static_cast<std::size_t>(groups)});
      for (std::size_t l = from; l < to; ++l) {
        const int capacity = all_links(grids[l]);
        grid_links_.push_back({link, diagonal, grids[l].capacity[Items::direct_links], capacity});
        link = {link.host + capacity, link.device + capacity};
        diagonal = {diagonal.host + groups, diagonal.device + groups};
      }
    }
    groups_ = groups;
  }

  /// Lists the conductances between groups (bodies with one potential) of grid number `l` on the device.
  void list_links(const ProblemView& problem, const GridView& grid, int l) const {
    list_group_links(run_, problem, grid, grid_links_[l].link.device, grid_links_[l].diagonal.device);
  }

  /// Computes the agglomerates (sets of groups that coarse grids treat as one) and uploads them. They follow from the
  /// finest grid's conductances between groups (bodies with one potential). `h`: cell size of the coarsest grid (m).
  void find_sets(const LaplaceProblem& problem, double h) {
    reports_[0]->fetch();
    const AgglomerateLists lists = list_agglomerates(problem, links(0, grid_links_[0].capacity), h, groups_);
    const auto copy = [](const std::vector<int>& from, int* to) { std::copy(from.begin(), from.end(), to); };
    copy(lists.first_group, first_group_.host);
    copy(lists.start, start_.host);
    copy(lists.group, group_.host);
    copy(lists.is_alone, is_alone_.host);
    copy(lists.held, held_.host);
    sets_.send();
  }
  /// Computes and uploads the clusters (groups solved together) that the V-cycle relaxes, for all grids. With couplings
  /// (lumped capacitances), also computes those of exact_clusters(). They contain all couplings and gap conductances,
  /// and are solved exactly.
  void find_clusters(const LaplaceProblem& problem) {
    constexpr int most = 64;                    // groups in a cluster; longer chains are cut
    reports_[grid_links_.size() > 1]->fetch();  // the finest grid's is there, unless it is the only one
    std::vector<Clusters> clusters;
    const bool is_coupled = !problem.couplings.empty();
    const double least = least_in_cycle(problem);
    for (std::size_t l = 0; l < grid_links_.size(); ++l) {
      if (!is_coupled) {
        clusters.push_back(clusters_of_linked(l, most));
        continue;
      }
      GroupNetwork network{{diagonal(l).begin(), diagonal(l).end()}, links(l, grid_links_[l].capacity)};
      couple(problem, l == 0 ? infinite : largest_coarse_coupling, least, network);
      clusters.push_back(clusters_of(std::move(network), most, l == 0));
    }
    if (is_coupled) {
      GroupNetwork exact{{grid_links_[0].diagonal.host + groups_, grid_links_[0].diagonal.host + 2 * groups_},
                         links(0, grid_links_[0].direct)};
      couple(problem, infinite, 0, exact);
      clusters.push_back(clusters_of(std::move(exact), most, true));
    }
    clusters_.upload(clusters, groups_);
  }

 private:
  template <class T>
  using Transferred = typename parallel::PackedTransfer<Executor>::template MirroredArray<T>;
  struct GridLinks {
    Transferred<NetworkLink> link;
    Transferred<double> diagonal;
    int direct, capacity;  // capacity for direct links; for these and joined ones
  };
  static int all_links(const GridView& grid) {
    return grid.capacity[Items::direct_links] + grid.capacity[Items::joined_links];
  }
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  std::span<const double> diagonal(std::size_t l) const {
    return {grid_links_[l].diagonal.host, static_cast<std::size_t>(groups_)};
  }
  Clusters clusters_of_linked(std::size_t l, int most) {
    LinkedGroups linked = LinkedGroups::of(diagonal(l), links(l, grid_links_[l].capacity), index_);
    Clusters clusters = clusters_of(std::move(linked.network), most);
    for (int& g : clusters.group) g = linked.group[g];
    return clusters;
  }
  std::vector<NetworkLink> links(std::size_t l, int end) const {
    std::vector<NetworkLink> links;
    for (int m = 0; m < end; ++m)
      if (grid_links_[l].link.host[m].a >= 0) links.push_back(grid_links_[l].link.host[m]);
    return links;
  }

  const Executor& run_;
  int groups_ = 0;
  std::vector<int> index_;  // of LinkedGroups::of
  int grids_;
  std::vector<std::unique_ptr<parallel::PackedTransfer<Executor>>> reports_;  // of the finest grid, of the others
  std::vector<GridLinks> grid_links_;
  parallel::PackedTransfer<Executor> sets_;
  Transferred<int> first_group_, start_, group_, is_alone_, held_;
  DeviceClusters<Executor> clusters_;
};

}  // namespace lichtenberg::laplace::device
