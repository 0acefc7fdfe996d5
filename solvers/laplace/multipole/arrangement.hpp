#pragma once

#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::multipole {

/// Largest multipole order of a disk. Beyond it, products of powers and binomials leave the range of double precision.
constexpr int largest_order = 1000;

/// Target for the truncation of multipole series: a relative error.
struct Truncation {
  double accuracy = 0;        ///< Largest relative error
  bool results_only = false;  ///< True: error of charges, potentials and forces only; false: error of the field too
};

/// Close pair: two disks that can have different potentials, or a disk and an electrode side, whose narrow gap would
/// require very many multipoles. Two opposite point charges represent the field in the gap, one inside each circle at
/// its limit point (bipolar coordinates). Their potential is constant on both circles. The remaining field has no
/// potential difference across the gap and is smooth.
struct ClosePair {
  int first = 0, second = -1;                ///< Indices of the disks; second = -1: the electrode `side`
  int first_charge = 0, second_charge = -1;  ///< Indices of the point charges among the sources
  SideIndex side = left;
  /// Potential difference (V) for charges with lambda = Q / (2 pi eps) = 1 V: sum of the circles' bipolar coordinates
  double difference = 0;
};

/// Sources of the multipole method: the disks with the orders of their multipole expansions, and the point charges of
/// close pairs, sorted into cells.
struct Arrangement {
  /// Makes the sources of a problem, and chooses the multipole order of each disk for the accuracy of `truncation`.
  /// Throws InputError in these cases. A body is not a disk. Disks that are neither in one group nor fixed at one
  /// potential touch or overlap. Other disks overlap by more than 1 % of the smaller radius. A disk that is not centred
  /// on a side touches an electrode side and is not fixed at its potential. A disk crosses another side by more than
  /// 0.5 % of its radius. A disk is centred on an electrode side and not fixed at its potential, or is centred in a
  /// corner of two electrodes.
  Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, Truncation truncation);

  int disks = 0;                ///< Number of bodies
  std::vector<Source> sources;  ///< Disks in the order of the bodies, then point charges of close pairs
  std::vector<double> decay;    ///< Per source: its multipole coefficients a_k decrease like decay^k
  std::vector<int> copies;      ///< Per disk: number of coinciding mirror images, itself included
  std::vector<bool> anchored;   ///< Per disk: true if centred on an electrode, which determines its charge
  std::vector<ClosePair> close_pairs;
  /// Factor up to 1 by which narrow gaps reduce the permitted errors of parts of the method, except the far field's. It
  /// is 1 if the truncation has the field as its target.
  double narrowness = 1;
  Cells cells;

 private:
  void find_orders(const LaplaceProblem& problem, Truncation truncation);
  void add_close_pair(const LaplaceProblem& problem, int i, int j, const Image& image, Complex shift);
  void check_overlap(const LaplaceProblem& problem, int i, int j, double depth) const;
  void check_against_sides(const LaplaceProblem& problem);
};

}  // namespace lichtenberg::laplace::multipole
