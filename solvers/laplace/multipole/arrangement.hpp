#pragma once

#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// The bodies as circles that multipoles can be put on.
struct Arrangement {
  /// Throws InputError for a body that is no disk, for disks that overlap or touch, that stick out of the box or touch
  /// a side without being centred on it, and for a disk centred on an electrode side that doesn't have its potential.
  Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, double accuracy);

  std::vector<Source> disks;   ///< by body
  std::vector<double> decay;   ///< of each disk: its coefficients fall off like decay^k
  std::vector<int> copies;     ///< of each disk: mirror images that coincide with it, itself included
  std::vector<bool> anchored;  ///< of each disk: centred on an electrode, which takes its charge
  Cells cells;

 private:
  void find_orders(double accuracy);
};

}  // namespace lichtenberg::laplace
