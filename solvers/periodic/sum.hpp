#pragma once

#include <span>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Accumulated wall times (s) of the near and mesh parts of evaluations; 0 for sums that do not measure them.
struct SumSeconds {
  double near = 0, mesh = 0;
};

/// Interface of methods for periodic Coulomb sums of charges and dipoles (Sources).
class Sum {
 public:
  virtual ~Sum() = default;
  /// Returns the distance up to which evaluate() needs all pairs (nearest images) as an argument; 0 if it needs none.
  virtual double cutoff() const = 0;
  /// Computes potentials, fields, forces and energy of the sources; overwrites `response`. `pairs`: all pairs within
  /// cutoff(), in ascending order, each once; pairs beyond it do not change the result. Results have identical bits for
  /// any number of threads. Throws InputError for inconsistent sources, and for sources or boxes that the method does
  /// not support.
  virtual void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                        Response& response) = 0;
  /// Computes the forces [3 N] of evaluate(), with identical bits, at lower cost if the method allows.
  virtual void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                      std::vector<double>& force);
  /// Computes the field [3 N] of the dipoles alone at each other's positions; charges are taken as 0. The field is a
  /// linear, symmetric function of the dipoles, up to rounding.
  virtual void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            std::span<double> field);
  /// Returns the accumulated wall times (s) of the sum over near pairs and of the mesh; 0 if they are not measured.
  virtual SumSeconds seconds() const { return {}; }
};

}  // namespace lichtenberg::periodic
