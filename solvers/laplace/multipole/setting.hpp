#pragma once

#include "solvers/laplace/multipole/arrangement.hpp"
#include "solvers/laplace/multipole/wall_field.hpp"

namespace lichtenberg::laplace::multipole {

/// Layout of the coefficients of all sources of the multipole method in one array. The coefficients of a source are
/// consecutive: lambda = charge / (2 pi eps), then the multipoles a_1 ... a_order (all in V).
struct Layout {
  explicit Layout(const std::vector<Source>& sources) : start{0} {
    for (const Source& s : sources) start.push_back(start.back() + s.order + 1);
  }
  std::vector<int> start;                    ///< Start index of each source, then the total size
  int size() const { return start.back(); }  ///< Total number of coefficients
  int sources() const { return static_cast<int>(start.size()) - 1; }  ///< Number of sources
  /// Returns the highest multipole order of a source, -1 if there is no such source.
  int order(int source) const { return source < sources() ? start[source + 1] - start[source] - 1 : -1; }
};

/// Problem in the data structures of the multipole method: mirrors, lattice sum, field of the walls, sources and layout
/// of their coefficients. It cannot be copied, because its members point at each other.
struct Setting {
  /// Sets up a problem. `unbounded`: true for the unbounded plane without the box. Throws the exceptions of
  /// Arrangement.
  Setting(const LaplaceProblem& p, bool unbounded, Truncation truncation)
      : problem(p),
        mirrors(unbounded ? Mirrors() : Mirrors(problem)),
        lattice(mirrors),
        wall(mirrors, lattice, problem.sides),
        arrangement(problem, mirrors, truncation),
        layout(arrangement.sources) {}
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

  LaplaceProblem problem;
  Mirrors mirrors;
  LatticeSum lattice;
  WallField wall;
  Arrangement arrangement;
  Layout layout;
};

}  // namespace lichtenberg::laplace::multipole
