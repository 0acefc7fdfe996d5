#pragma once

#include "solvers/periodic/sum.hpp"

// Sums over pairs only. They approximate the sum over all images at lower cost, without an error bound.
namespace lichtenberg::periodic {

/// Minimum-image Coulomb sum: adds the interaction with the nearest image of each other source, all of them or only
/// those within a reach. It includes no further images and no background. The energy jumps where another image becomes
/// the nearest, or where a pair comes within the reach.
class MinimumImage : public Sum {
 public:
  /// Pairs that are included.
  enum class Reach {
    half_box,  ///< Pairs closer than half of the shortest side (G 3.22)
    box        ///< Every pair
  };
  explicit MinimumImage(Reach reach = Reach::half_box) : reach_(reach) {}

  double cutoff() const override { return 0; }
  /// Computes potentials, fields, forces and energy; `pairs` is not used. Throws the exceptions of
  /// require_consistent().
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;

 private:
  Reach reach_;
};

/// Damped shifted-force Coulomb sum of q_i q_j v(r) within a cut-off c: potential and force are shifted so that both
/// vanish at c (Fennell and Gezelter 2006). v = w(r) - w(c) - (r - c) w'(c) with w = erfc(alpha r)/r. Each charge also
/// has a self energy, q^2/2 times the limit of v - 1/r at r = 0. With it, the energy of two opposite charges tends to
/// that of Coulomb's law, -q^2/r, as r tends to 0.
class ShiftedForce : public Sum {
 public:
  /// Makes a shifted-force sum. `cutoff` (length); `alpha` (1/length): damping parameter, 0 for the shifted Coulomb
  /// law.
  explicit ShiftedForce(double cutoff, double alpha = 0) : cutoff_(cutoff), alpha_(alpha) {}

  double cutoff() const override { return cutoff_; }
  /// Computes potentials, fields, forces and energy from `pairs`, which must contain all pairs within the cut-off.
  /// Throws the exceptions of require_consistent(). Throws InputError for dipoles, and for a cut-off that is not
  /// positive or exceeds half of the shortest side.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;

 private:
  double cutoff_, alpha_;
};

}  // namespace lichtenberg::periodic
