#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Bodies (conductors) of a problem on one grid: their shapes in units of cells, and whether the grid resolves them. A
/// coarse grid may not resolve a small disk or bar. The body is then part of an effective medium, or a subgrid
/// conductor that exchanges flux with the four cells around it (medium.hpp). The medium absorbs whole groups (bodies
/// with one potential).
struct GridBodies {
  /// Computes the outlines of all bodies for cells of size h (m) and marks all bodies as resolved.
  void assign(const LaplaceProblem& problem, double h);

  /// Returns true if the grid resolves the body with index `body`.
  bool resolves(int body) const { return is_resolved.empty() || is_resolved[body]; }
  /// Returns the indices of a group's subgrid conductors: bodies too small for the grid that still have an unknown or
  /// given potential on it. A group is a set of bodies with one potential.
  std::span<const int> subgrid_of_group(int group) const {
    if (is_resolved.empty()) return {};
    return std::span(subgrid).subspan(subgrid_start[group], subgrid_start[group + 1] - subgrid_start[group]);
  }

  /// Shapes by body, lengths in cells.
  std::vector<Outline> outlines;
  /// Whether the grid resolves each body; empty if it resolves all.
  std::vector<char> is_resolved;
  /// Indices of the subgrid conductors, sorted by group, and [groups + 1] the start of each group's part of `subgrid`.
  /// Both are unused if the grid resolves all bodies.
  std::vector<int> subgrid, subgrid_start;
};

}  // namespace lichtenberg::laplace
