#pragma once

#include <span>

#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Where a sum is split in two (Ewald 1921): every charge amid a Gaussian cloud of the opposite one, which is felt
/// within `cutoff` only, and clouds that undo these, which are summed as waves up to `wave_cutoff`.
struct Splitting {
  double alpha = 0;        ///< 1/length: the clouds are exp(-alpha^2 r^2)
  double cutoff = 0;       ///< length; may be many boxes
  double wave_cutoff = 0;  ///< 1/length
};

/// Cut-offs that leave no field (and no force on a unit charge, or on a dipole of moment d) wrong by more than
/// `tolerance`, in units of the largest charge over the squared mean spacing d = (V/N)^(1/3). The bound adds up
/// magnitudes, for sources spread evenly; the largest error at 150 random places is .2 of it (`validation/periodic`).
/// `alpha` 0: the one that makes both sums take equally long. Throws InputError if the tolerance is not positive.
Splitting splitting_for(const Sources& sources, double tolerance, double alpha = 0);

/// Ewald's sum term by term with all images (Allen and Tildesley 2017; G 3.19, 3.20 as the README corrects them): the
/// reference for every other way, to some 1e-15 of the largest terms. The work grows with N^(3/2), but for N^2
/// comparisons of distances.
class Ewald : public Sum {
 public:
  /// Split by splitting_for.
  explicit Ewald(double tolerance = 1e-12) : tolerance_(tolerance) {}
  explicit Ewald(const Splitting& splitting) : splitting_(splitting) {}

  double cutoff() const override { return 0; }
  /// Throws what require_consistent throws.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  /// What the sources of `sample` feel of all sources, where asking for every one would take too long: `response` has
  /// one entry for each of them, and their share of the energy. For m of N, (2 m / N)^(1/6) of the balanced alpha makes
  /// both sums equally long.
  void evaluate_at(std::span<const int> sample, const Sources& sources, parallel::Team& team, Response& response) const;

 private:
  double tolerance_ = 0;
  Splitting splitting_;
};

}  // namespace lichtenberg::periodic
