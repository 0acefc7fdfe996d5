#pragma once

#include <vector>

#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace::device {

/// What the coarsest grid's system is made of (GridView), on the host.
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

/// The upper triangle by columns. `pin`: nothing is grounded, and the potential of the last unknown is held.
SparseSystem assemble(const CoarsestArrays& arrays, bool pin);

}  // namespace lichtenberg::laplace::device
