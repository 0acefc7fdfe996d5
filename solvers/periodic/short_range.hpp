#pragma once

#include "solvers/periodic/sum.hpp"

// Sums over pairs alone. Neither is the sum over all images: they cost less and promise no accuracy.
namespace lichtenberg::periodic {

/// Each source feels the nearest image of every other, and nothing else: no other image, no background. The energy
/// jumps where another image becomes the nearest, or a pair comes within reach.
class MinimumImage : public Sum {
 public:
  enum class Reach {
    half_box,  ///< pairs nearer than half the shortest length (G 3.22)
    box        ///< every pair
  };
  explicit MinimumImage(Reach reach = Reach::half_box) : reach_(reach) {}

  double cutoff() const override { return 0; }
  /// Throws what require_consistent throws.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;

 private:
  Reach reach_;
};

/// Charges q_i q_j v(r) within the cut-off c, shifted so that force and energy end there continuously (Fennell and
/// Gezelter 2006): v = w(r) - w(c) - (r - c) w'(c), w = erfc(alpha r)/r. Each charge also has the self energy that
/// makes two opposite ones vanish where they meet: q^2/2 times the limit of v - 1/r.
class ShiftedForce : public Sum {
 public:
  /// `alpha` (1/length) damps: 0 is Coulomb's law, shifted.
  explicit ShiftedForce(double cutoff, double alpha = 0) : cutoff_(cutoff), alpha_(alpha) {}

  double cutoff() const override { return cutoff_; }
  /// Throws what require_consistent throws, and InputError if there are dipoles or the cut-off is not positive or
  /// beyond half a length of the box.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;

 private:
  double cutoff_, alpha_;
};

}  // namespace lichtenberg::periodic
