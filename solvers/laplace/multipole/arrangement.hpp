#pragma once

#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Beyond this order products of powers and binomials leave the range of double precision.
constexpr int largest_order = 1000;

/// What orders are chosen for: an error, of the field or of charges, potentials and forces alone.
struct Truncation {
  double accuracy = 0;
  bool results_only = false;
};

/// Two disks of different potential, or a disk and an electrode side, so close that multipoles alone would take very
/// many terms: the field in the gap is that of two opposite point charges, one inside each circle at its limit point
/// (bipolar coordinates), which is constant on both circles. What is left has no potential difference across the gap
/// and is smooth.
struct ClosePair {
  int first = 0, second = -1;                ///< disks; second = -1: the side
  int first_charge = 0, second_charge = -1;  ///< the point charges, as sources
  SideIndex side = left;
  double difference = 0;  ///< of potential across the gap, for lambda = 1: the sum of the circles' bipolar coordinates
};

/// The bodies as circles that multipoles can be put on.
struct Arrangement {
  /// Throws InputError for a body that is no disk; for disks of different groups, or a disk and an electrode side, that
  /// touch or overlap; for an overlap deeper than 1 % of the radius where both have one potential; and for a disk
  /// centred on an electrode side that doesn't have its potential.
  Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, Truncation truncation);

  int disks = 0;                ///< bodies
  std::vector<Source> sources;  ///< the disks by body, then the point charges of close pairs
  std::vector<double> decay;    ///< of each source: its coefficients fall off like decay^k
  std::vector<int> copies;      ///< of each disk: mirror images that coincide with it, itself included
  std::vector<bool> anchored;   ///< of each disk: centred on an electrode, which takes its charge
  std::vector<ClosePair> close_pairs;
  double narrowness = 1;  ///< what narrow gaps make of all shares but the far field's; 1 where the field is asked for
  Cells cells;

 private:
  void find_orders(const LaplaceProblem& problem, Truncation truncation);
  void add_close_pair(const LaplaceProblem& problem, int i, int j, const Image& image, Complex shift);
  void check_overlap(const LaplaceProblem& problem, int i, int j, double depth) const;
  void check_against_sides(const LaplaceProblem& problem);
};

}  // namespace lichtenberg::laplace::multipole
