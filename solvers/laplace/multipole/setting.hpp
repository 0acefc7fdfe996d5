#pragma once

#include "solvers/laplace/multipole/arrangement.hpp"
#include "solvers/laplace/multipole/wall_field.hpp"

namespace lichtenberg::laplace::multipole {

/// Where the coefficients of each source lie in one array: the logarithm's (real) first, then a_1 ... a_order.
struct Layout {
  explicit Layout(const std::vector<Source>& sources) : start{0} {
    for (const Source& s : sources) start.push_back(start.back() + s.order + 1);
  }
  std::vector<int> start;  ///< of each source, and the end
  int size() const { return start.back(); }
  int sources() const { return static_cast<int>(start.size()) - 1; }
  /// Highest multipole of a source, -1 if there is no such source.
  int order(int source) const { return source < sources() ? start[source + 1] - start[source] - 1 : -1; }
};

/// A problem in this method's terms; stays where it is, its parts point at each other.
struct Setting {
  /// Throws InputError as Arrangement does.
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
