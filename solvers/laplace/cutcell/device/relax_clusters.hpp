#pragma once

// Groups whose direct links outweigh their links to cells, on the device: what the host needs of the links to find
// their clusters and invert them, and how they are relaxed.

#include <array>
#include <cstring>
#include <vector>

#include "solvers/laplace/cutcell/device/clusters.hpp"
#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

/// Threads that share the sum over a group's direct links.
constexpr int group_lanes = 8;

/// A grid's clusters as the device has them (Clusters).
struct ClusterView {
  const int *row, *group, *first, *size;
  const long* start;
  const double* inverse;

  LICHTENBERG_HOST_DEVICE int size_of(int g) const { return row[g] < 0 ? 0 : size[row[g]]; }
  /// What the t-th of the cluster of g makes of its part of `rhs`.
  template <class Real>
  LICHTENBERG_HOST_DEVICE double value(int g, int t, const Real* rhs) const {
    const int own = row[g];
    return inverse[start[own] + t] * rhs[group[first[own] + t]];
  }
  LICHTENBERG_HOST_DEVICE bool join(int g, int h) const {
    return row[g] >= 0 && row[h] >= 0 && first[row[g]] == first[row[h]];
  }
};

/// Direct links of groups that have potentials of their own, each once (else a = -1), and the groups' diagonals.
template <class Executor>
void list_group_links(const Executor& run, ProblemView problem, GridView grid, NetworkLink* link, double* diagonal) {
  run.for_each(grid.room[Of::direct_links], [=] LICHTENBERG_HOST_DEVICE(int m) {
    link[m] = {-1, -1, 0};
    if (m >= grid.number[Of::direct_links]) return;
    const DirectLink& direct = grid.direct_link[m];
    if (direct.is_to_electrode()) return;
    const int a = problem.group_of[direct.own], b = problem.group_of[direct.other];
    if (a < b && grid.group_diagonal[a] > 0 && grid.group_diagonal[b] > 0) link[m] = {a, b, direct.conductance};
  });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { diagonal[g] = grid.group_diagonal[g]; });
}

/// What a group's direct links to others that are not of its cluster bring, for sums over its links.
template <class Real>
struct FluxesFromOutside {
  ProblemView problem;
  GridView grid;
  const Real* phi;
  const Real* more;  ///< is added to phi; null: nothing
  LICHTENBERG_HOST_DEVICE int count(int g) const { return grid.direct_links_of(problem, g); }
  LICHTENBERG_HOST_DEVICE Real value(int g, int t) const {
    const DirectLink& link = grid.direct_link[grid.first_direct_link(problem, g) + t];
    if (link.is_to_electrode()) return 0;
    const int other = problem.group_of[link.other];
    if (grid.clusters->join(g, other)) return 0;
    return static_cast<Real>(link.conductance) * (more ? phi[other] + more[other] : phi[other]);
  }
};

/// The same of the difference of two sweeps for groups in a cluster, whose links among each other were in balance at
/// the second; of the second alone, all links, for others.
struct FluxesSinceSweep {
  ProblemView problem;
  GridView grid;
  const float *before, *phi;
  LICHTENBERG_HOST_DEVICE int count(int g) const { return grid.direct_links_of(problem, g); }
  LICHTENBERG_HOST_DEVICE float value(int g, int t) const {
    const DirectLink& link = grid.direct_link[grid.first_direct_link(problem, g) + t];
    if (link.is_to_electrode()) return 0;
    const int other = problem.group_of[link.other];
    if (grid.clusters->join(g, other)) return 0;
    const float change = grid.clusters->row[g] < 0 ? phi[other] : phi[other] - before[other];
    return static_cast<float>(link.conductance) * change;
  }
};

/// phi = what `rhs` makes of the groups' potentials: of a cluster's together, of any other by its diagonal. `z`:
/// becomes the potentials too, without rounding to phi's precision; null: nothing.
template <class Executor>
void solve_clusters(const Executor& run, ProblemView problem, GridView grid, const float* rhs, float* phi,
                    double* z = nullptr) {
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.clusters->size_of(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return grid.clusters->value(g, t, rhs); },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        if (grid.clusters->row[g] < 0) sum = rhs[g] * grid.group_inverse_diagonal[g];
        phi[g] = static_cast<float>(sum);
        if (z) z[g] = sum;
      });
}

/// A sweep over all groups: from `flux`, what cells bring, and what `phi` and `more` bring from other clusters.
template <class Executor>
void relax_clusters(const Executor& run, ProblemView problem, GridView grid, const float* flux, const float* phi,
                    const float* more, float* phi_next, double* z = nullptr) {
  const FluxesFromOutside<float> outside{problem, grid, phi, more};
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return outside.count(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return outside.value(g, t); },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) { grid.group_rhs[g] = flux[g] + sum; });
  solve_clusters(run, problem, grid, grid.group_rhs, phi_next, z);
}

/// All grids' clusters in the memory of a device.
template <class Executor>
class DeviceClusters {
 public:
  DeviceClusters(const Executor& run, int grids) : run_(&run), data_(run), view_(run) { view_.resize(grids); }
  const ClusterView* view(int grid) const { return view_.data() + grid; }

  /// By grid. Nothing that has been started may read them still.
  void upload(const std::vector<Clusters>& grids) {
    host_.clear();
    std::vector<std::array<std::size_t, 6>> offset;
    for (const Clusters& clusters : grids)
      offset.push_back({append(clusters.row), append(clusters.group), append(clusters.first), append(clusters.size),
                        append(clusters.start), append(clusters.inverse)});
    data_.upload(host_);
    std::vector<ClusterView> views;
    for (const auto& [row, group, first, size, start, inverse] : offset)
      views.push_back(
          {at<int>(row), at<int>(group), at<int>(first), at<int>(size), at<long>(start), at<double>(inverse)});
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
  parallel::Array<ClusterView, Executor> view_;
};

}  // namespace lichtenberg::laplace::device
