#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Purposes of random numbers. The values affect results: they must never be changed or used again.
enum class RandomPurpose : std::uint64_t {
  population = 1,  ///< Initial positions, velocities and charges
  exchange = 2,    ///< Charge that a contact transfers
  gas = 3,         ///< Velocity of the gas at a grain
  flow = 4,        ///< Perturbation of a flow, by its wave vector
};

/// Key of a sequence of random numbers: a purpose, for a particle i or a pair (i, j), i < j, and `count` for repeated
/// use (its number of collisions, or the number of a step).
struct RandomKey {
  std::uint64_t seed = 0;
  RandomPurpose purpose = {};
  std::uint64_t i = 0, j = 0, count = 0;
};

/// Sequence of random numbers of a key. The numbers depend only on the key and the index in the sequence. They are
/// therefore the same for any order of draws and any number of threads, and a resumed run needs no generator state.
/// Philox 4x64 with ten rounds (Salmon, Moraes, Dror and Shaw 2011) of Random123: its key is (seed, purpose), its
/// counter (i, j, count, n) for words 4 n to 4 n + 3 of the sequence. Each function below states the number of words
/// that it consumes.
class Random {
 public:
  LICHTENBERG_HOST_DEVICE explicit Random(const RandomKey& key)
      : key_{{key.seed, static_cast<std::uint64_t>(key.purpose)}}, counter_{{key.i, key.j, key.count, 0}} {}

  /// Returns the next word: 64 independent, unbiased bits.
  LICHTENBERG_HOST_DEVICE std::uint64_t word() {
    if (used_ == 4) {
      block_ = r123::Philox4x64()(counter_, key_);
      ++counter_[3];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Returns a uniform number in (0, 1), both ends excluded: (n + 1/2) / 2^52 with the word's upper 52 bits as n, which
  /// is exact. One word.
  LICHTENBERG_HOST_DEVICE double uniform() { return (static_cast<double>(word() >> 12) + 0.5) * 0x1p-52; }

  /// Returns a uniform number between `low` and `high`. One word.
  LICHTENBERG_HOST_DEVICE double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Returns a Gaussian number of mean 0 and variance 1, of magnitude up to 8.6 (Box and Muller 1958, the cosine
  /// alone). Two words.
  LICHTENBERG_HOST_DEVICE double normal() {
    const double distance = std::sqrt(-2 * std::log(uniform()));
    return distance * std::cos(2 * std::numbers::pi * uniform());
  }

  /// Returns 1 or -1 with equal probability: the word's highest bit. One word.
  LICHTENBERG_HOST_DEVICE double sign() { return word() >> 63 ? -1 : 1; }

 private:
  r123::Philox4x64::key_type key_;
  r123::Philox4x64::ctr_type counter_, block_{};
  int used_ = 4;
};

}  // namespace lichtenberg
