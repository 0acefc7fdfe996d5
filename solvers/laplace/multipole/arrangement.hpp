#pragma once

#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Largest multipole order: beyond it, products of powers and binomials leave the range of double precision.
constexpr int largest_order = 1000;

/// Target of the choice of orders: relative error, of the field or only of charges, potentials and forces.
struct Truncation {
  double accuracy = 0;
  bool results_only = false;
};

/// Two disks of different potential, or a disk and an electrode side, so close that multipoles alone would need very
/// many terms. The field in the gap is represented by two opposite point charges, one inside each circle at its limit
/// point (bipolar coordinates). Its potential is constant on both circles. The remaining field has no potential
/// difference across the gap and is smooth.
struct ClosePair {
  int first = 0, second = -1;                ///< Indices of the disks; second = -1: the electrode `side`
  int first_charge = 0, second_charge = -1;  ///< Indices of the point charges among the sources
  SideIndex side = left;
  double difference = 0;  ///< Potential difference for lambda = 1: sum of the circles' bipolar coordinates
};

/// Bodies as circles that carry multipoles.
struct Arrangement {
  /// Arranges the bodies and chooses their orders. Throws InputError for a body that is not a disk. Throws InputError
  /// for disks of different groups, or a disk and an electrode side of another potential, that touch or overlap. Throws
  /// InputError for an overlap above 1 % of the radius at equal potential or with an insulating side, unless the disk
  /// is centred on the side. Throws InputError for a disk centred on an electrode side of another potential or in a
  /// corner of two electrodes.
  Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, Truncation truncation);

  int disks = 0;                ///< Number of bodies
  std::vector<Source> sources;  ///< Disks in the order of the bodies, then point charges of close pairs
  std::vector<double> decay;    ///< Per source: its coefficients decrease like decay^k
  std::vector<int> copies;      ///< Per disk: number of coinciding mirror images, itself included
  std::vector<bool> anchored;   ///< Per disk: true if centred on an electrode, which determines its charge
  std::vector<ClosePair> close_pairs;
  double narrowness = 1;  ///< Factor for narrow gaps on all error shares except the far field's; 1 if the field is the
                          ///< target
  Cells cells;

 private:
  void find_orders(const LaplaceProblem& problem, Truncation truncation);
  void add_close_pair(const LaplaceProblem& problem, int i, int j, const Image& image, Complex shift);
  void check_overlap(const LaplaceProblem& problem, int i, int j, double depth) const;
  void check_against_sides(const LaplaceProblem& problem);
};

}  // namespace lichtenberg::laplace::multipole
