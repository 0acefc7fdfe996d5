#pragma once

#include <vector>

#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace::device {

/// Arrays of the coarsest grid (GridView), on the host.
struct CoarsestArrays {
  Layout layout;
  std::vector<float> inverse_diagonal, east, north;  ///< by slot; faces empty: 1 everywhere
  std::vector<int> link_slot, link_group;
  std::vector<double> conductance;
  struct GroupPair {
    int own, other;
    double conductance;
  };
  std::vector<GroupPair> direct_links;  ///< each twice
  std::vector<double> group_diagonal;
};

/// Returns the upper triangle by columns. `pin`: nothing is grounded; fixes the potential of the last unknown.
SparseSystem assemble(const CoarsestArrays& arrays, bool pin);

}  // namespace lichtenberg::laplace::device
