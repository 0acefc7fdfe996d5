#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// What random numbers are for. The values are part of results: they are never changed or used again.
enum class RandomPurpose : std::uint64_t {
  population = 1,  ///< places, velocities and charges at the start
  exchange = 2,    ///< charge that a contact moves
  gas = 3,         ///< the gas's velocity at a grain
  flow = 4,        ///< a disturbance of a flow, by its wave vector
};

/// Which random numbers: those of a purpose for a particle i or a pair (i, j), i < j, the `count`-th time that it needs
/// some (its collisions so far, a number of a step).
struct RandomKey {
  std::uint64_t seed = 0;
  RandomPurpose purpose = {};
  std::uint64_t i = 0, j = 0, count = 0;
};

/// The random numbers of a key, one after the other: a function of key and place in the sequence alone. So they are the
/// same whatever else was drawn before, in whatever order, on however many threads, and a run that is resumed needs no
/// state of a generator.
///
/// Philox 4x64 with ten rounds (Salmon, Moraes, Dror and Shaw 2011) of Random123: its key is (seed, purpose), its
/// counter (i, j, count, n) for words 4 n to 4 n + 3 of the sequence. Each function below says how many words it takes.
class Random {
 public:
  LICHTENBERG_HOST_DEVICE explicit Random(const RandomKey& key)
      : key_{{key.seed, static_cast<std::uint64_t>(key.purpose)}}, counter_{{key.i, key.j, key.count, 0}} {}

  /// The next word: 64 bits, each as likely 0 as 1.
  LICHTENBERG_HOST_DEVICE std::uint64_t word() {
    if (used_ == 4) {
      block_ = r123::Philox4x64()(counter_, key_);
      ++counter_[3];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Uniform in (0, 1), neither end ever: (n + 1/2) / 2^52 with the word's upper 52 bits as n, which is exact. One
  /// word.
  LICHTENBERG_HOST_DEVICE double uniform() { return (static_cast<double>(word() >> 12) + 0.5) * 0x1p-52; }

  /// Uniform between `low` and `high`. One word.
  LICHTENBERG_HOST_DEVICE double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Gaussian of mean 0 and variance 1, up to 8.6 (Box and Muller 1958, the cosine alone). Two words.
  LICHTENBERG_HOST_DEVICE double normal() {
    const double distance = std::sqrt(-2 * std::log(uniform()));
    return distance * std::cos(2 * std::numbers::pi * uniform());
  }

  /// 1 or -1, a fair coin: the word's highest bit. One word.
  LICHTENBERG_HOST_DEVICE double sign() { return word() >> 63 ? -1 : 1; }

 private:
  r123::Philox4x64::key_type key_;
  r123::Philox4x64::ctr_type counter_, block_{};
  int used_ = 4;
};

}  // namespace lichtenberg
