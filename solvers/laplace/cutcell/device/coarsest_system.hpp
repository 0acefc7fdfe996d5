#pragma once

#include <vector>

#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace::device {

/// Copy on the host of the coarsest grid's arrays (GridView): diagonals, faces and links, from which the matrix is
/// assembled.
struct CoarsestArrays {
  Layout layout;
  /// By slot (memory index): 1 / diagonal, and conductances of the faces to the right and above. Empty faces: 1
  /// everywhere.
  std::vector<float> inverse_diagonal, east, north;
  /// By link: slot of the fluid cell, and group of the conductor.
  std::vector<int> link_slot, link_group;
  /// By link: its conductance.
  std::vector<double> conductance;
  struct GroupPair {
    int own, other;
    double conductance;
  };
  /// Conductances between two groups; assemble() uses the entries with own < other.
  std::vector<GroupPair> direct_links;
  /// By group: sum of its conductances; 0 without an unknown potential.
  std::vector<double> group_diagonal;
};

/// Assembles the coarsest grid's matrix as upper triangle by columns. `pin`: nothing is grounded; the last diagonal
/// entry is then doubled, which fixes the potential of the last unknown.
SparseSystem assemble(const CoarsestArrays& arrays, bool pin);

}  // namespace lichtenberg::laplace::device
