#pragma once

#include <span>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Accumulated wall time (s) of evaluations by part; 0 for sums that do not measure it.
struct SumSeconds {
  double near = 0, mesh = 0;
};

/// Interface of methods that compute the periodic Coulomb sums of Sources.
class Sum {
 public:
  virtual ~Sum() = default;
  /// Distance up to which `evaluate` needs all pairs of nearest images; 0: it needs none.
  virtual double cutoff() const = 0;
  /// Overwrites `response`. `pairs`: in ascending order, each once; pairs beyond the cut-off do not change the result.
  /// Results are bitwise identical for any number of threads. Throws InputError for inconsistent sources and for
  /// sources or boxes that the method does not support.
  virtual void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                        Response& response) = 0;
  /// Overwrites `force` ([3 N]) with the forces of `evaluate`, bitwise identical, at lower cost if the method allows.
  virtual void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                      std::vector<double>& force);
  /// Overwrites `field` ([3 N]) with the field of the dipoles alone at each other's positions; charges are taken as 0.
  /// It is linear in the dipoles and, up to rounding, symmetric.
  virtual void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            std::span<double> field);
  virtual SumSeconds seconds() const { return {}; }
};

}  // namespace lichtenberg::periodic
