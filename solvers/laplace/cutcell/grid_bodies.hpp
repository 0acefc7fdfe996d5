#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Bodies of a problem on one grid: their shapes in units of cells, and which of them the grid resolves. Of those that
/// it does not resolve, some belong to an absorbed group; the others are subgrid conductors.
struct GridBodies {
  /// Sets the outlines for cells of size h (m), all bodies resolved.
  void assign(const LaplaceProblem& problem, double h);

  bool resolves(int body) const { return is_resolved.empty() || is_resolved[body]; }
  std::span<const int> subgrid_of_group(int group) const {
    if (is_resolved.empty()) return {};
    return std::span(subgrid).subspan(subgrid_start[group], subgrid_start[group + 1] - subgrid_start[group]);
  }

  std::vector<Outline> outlines;
  /// By body; empty: all are resolved.
  std::vector<char> is_resolved;
  /// Subgrid conductors by group. [groups + 1]: a group's first in `subgrid`; both are unused if all are resolved.
  std::vector<int> subgrid, subgrid_start;
};

}  // namespace lichtenberg::laplace
