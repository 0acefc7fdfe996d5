#pragma once

#include <span>

#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Splitting parameters of an Ewald sum (Ewald 1921). In the real-space sum each charge is screened by a Gaussian cloud
/// of opposite charge and acts within `cutoff` only. The reciprocal-space sum adds the compensating clouds as waves up
/// to `wave_cutoff`.
struct Splitting {
  double alpha = 0;        ///< Splitting parameter (1/length): the clouds are exp(-alpha^2 r^2)
  double cutoff = 0;       ///< Real-space cut-off (length); may exceed the box
  double wave_cutoff = 0;  ///< Reciprocal-space cut-off (1/length)
};

/// Chooses the cut-offs of an Ewald sum such that the estimated field error is at most `tolerance`. The unit of
/// `tolerance` is the largest charge over the squared mean spacing d = (V/N)^(1/3). The same estimate holds for the
/// force on a unit charge and on a dipole of moment d. `alpha` 0: the value that balances the cost of both sums.
/// The estimate adds up magnitudes of neglected terms for evenly spread sources. The largest error at 150 random
/// positions is 0.2 of it (`validation/periodic`). Throws InputError unless the tolerance is positive.
Splitting splitting_for(const Sources& sources, double tolerance, double alpha = 0);

/// Ewald sum of charges and dipoles, term by term, as the reference for other methods. Sources: Allen and Tildesley
/// 2017; Singh 2019, G 3.19 and 3.20 as corrected in docs/theory/grains.md. Its rounding errors are about 1e-15 of the
/// largest terms. With the parameters of splitting_for() the work grows with N^(3/2), apart from N^2 distance
/// comparisons.
class Ewald : public Sum {
 public:
  /// Makes a sum with the parameters that splitting_for() chooses for this tolerance in each evaluation.
  explicit Ewald(double tolerance = 1e-12) : tolerance_(tolerance) {}
  /// Makes a sum with the given parameters.
  explicit Ewald(const Splitting& splitting) : splitting_(splitting) {}

  double cutoff() const override { return 0; }
  /// Computes potentials, fields, forces and energy of all sources. `pairs` is not used. Throws the exceptions of
  /// require_consistent() and splitting_for().
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  /// Computes potentials, fields and forces at the sources in `sample` due to all sources, for samples of large
  /// systems. `response` has one entry for each source of the sample, and the sample's share of the energy. For m of N
  /// sources, (2 m / N)^(1/6) times the balanced alpha balances the cost of both sums.
  void evaluate_at(std::span<const int> sample, const Sources& sources, parallel::Team& team, Response& response) const;

 private:
  double tolerance_ = 0;
  Splitting splitting_;
};

}  // namespace lichtenberg::periodic
