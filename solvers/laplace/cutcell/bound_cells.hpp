#pragma once

#include <cstddef>
#include <vector>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

struct GridBodies;
struct Level;

/// Fluid cells so close to conductors that they have hardly a potential of their own: the lone cell squeezed into a gap
/// below a cell, one whose centre all but lies on a surface. Relaxed after the conductors, and these after it, such a
/// cell holds them where they are: of conductances c to a conductor and d to all, a sweep leaves c / d of the error
/// that both share. So the cycle eliminates them (Grid): a conductor has c - c^2 / d to the rest in place of c, and two
/// have c_a c_b / d between them.
struct BoundCells {
  /// A link of this conductance binds its cell; a face between two cells has 1. Table in README.md.
  static constexpr double least_conductance = 8;
  /// What a conductor keeps of its conductance to such a cell, and what two have between them; `all`: the sum of the
  /// cell's conductances.
  LICHTENBERG_HOST_DEVICE static constexpr double kept(double c, double all) { return c * (all - c) / all; }
  LICHTENBERG_HOST_DEVICE static constexpr double joined(double a, double b, double all) { return a * b / all; }

  struct Cell {
    std::ptrdiff_t slot;
    int row;
    double diagonal;  ///< sum of the cell's conductances
  };
  struct Link {
    int body, group;
    double conductance;
  };
  std::vector<Cell> cells;         ///< by row
  std::vector<int> start;          ///< [cells + 1] a cell's first in `links`
  std::vector<Link> links;         ///< to floating groups, each group once a cell
  std::vector<int> link_of_level;  ///< indices of the level's links that these are

  void clear();
  /// Puts the cells of another list behind its own.
  void append(const BoundCells& more);
  /// Calls effect(link, link, conductance) for any two conductors that such a cell joins.
  template <class Effect>
  void for_each_joined(const Effect& effect) const {
    for (std::size_t k = 0; k < cells.size(); ++k)
      for (int m = start[k]; m < start[k + 1]; ++m)
        for (int n = m + 1; n < start[k + 1]; ++n)
          effect(links[m], links[n], joined(links[m].conductance, links[n].conductance, cells[k].diagonal));
  }
};

/// Sets `level.bound` from its links to resolved bodies and its diagonal.
void find_bound_cells(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
