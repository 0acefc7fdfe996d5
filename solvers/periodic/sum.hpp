#pragma once

#include <span>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Wall time (s) that evaluations have taken, if they tell their parts apart.
struct SumSeconds {
  double near = 0, mesh = 0;
};

/// A way to compute the periodic Coulomb sums of Sources.
class Sum {
 public:
  virtual ~Sum() = default;
  /// Pairs whose nearest images are at most this far apart must be among those that `evaluate` is given; 0: it needs
  /// none.
  virtual double cutoff() const = 0;
  /// Overwrites `response`. `pairs`: in ascending order, each once; pairs beyond the cutoff cost time and change
  /// nothing. The result is the same bits for any number of threads.
  virtual void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                        Response& response) = 0;
  /// Overwrites `force` ([3 N]) with the forces of that response, the same bits, in less time if there is a way.
  virtual void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                      std::vector<double>& force);
  /// Overwrites `field` ([3 N]) with the field that the dipoles make at each other's places, and nothing else: charges
  /// are taken for 0. It is linear in the dipoles and, but for rounding, symmetric.
  virtual void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            std::span<double> field);
  virtual SumSeconds seconds() const { return {}; }
};

}  // namespace lichtenberg::periodic
