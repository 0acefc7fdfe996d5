#pragma once

#include <vector>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/sparse_factors.hpp"

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

/// The coarsest grid's system, factorized.
class CoarsestSystem {
 public:
  CoarsestSystem() = default;
  /// `pin`: nothing is grounded, and the potential of one unknown is to be held. Throws Failure if the system is not
  /// positive definite to working precision.
  CoarsestSystem(const CoarsestArrays& arrays, bool pin);

  std::size_t groups() const { return groups_; }
  /// v (by slot) and phi (by group) of the unknowns.
  void solve(const std::vector<float>& f, const std::vector<float>& charge, std::vector<float>& v,
             std::vector<float>& phi) const;

 private:
  SparseFactors factors_;
  std::vector<int> unknown_;  // a cell's slot, or -1 - group
  std::size_t groups_ = 0;
};

}  // namespace lichtenberg::laplace::device
