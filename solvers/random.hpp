#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Purpose of a sequence of random numbers, a part of its key: sequences of different purposes are statistically
/// independent. The enumerators' values affect results: they must never be changed or reused.
enum class RandomPurpose : std::uint64_t {
  population = 1,  ///< Initial positions, velocities and charges
  exchange = 2,    ///< Charge that a contact transfers
  gas = 3,         ///< Velocity of the gas at a grain
  flow = 4,        ///< Perturbation of a flow, by its wave vector
};

/// Key that selects a sequence of random numbers. It consists of the run's seed, a purpose, a particle i or a pair of
/// particles i < j, and `count`. `count` distinguishes repeated uses, such as the collisions of one pair or the time
/// steps.
struct RandomKey {
  std::uint64_t seed = 0;  ///< Random seed of the run
  RandomPurpose purpose = {};
  std::uint64_t i = 0, j = 0, count = 0;
};

/// Counter-based random number generator: draws the sequence that a RandomKey selects. A number depends only on the key
/// and its index in the sequence. It is therefore the same for any order of draws and any number of threads, and a
/// resumed run needs no generator state.
/// The generator is Philox 4x64 with ten rounds (Salmon, Moraes, Dror and Shaw 2011) of the library Random123. Its key
/// is (seed, purpose); its counter (i, j, count, n) gives words 4 n to 4 n + 3 of the sequence. Each function that
/// draws numbers states how many words it consumes.
class Random {
 public:
  LICHTENBERG_HOST_DEVICE explicit Random(const RandomKey& key)
      : key_{{key.seed, static_cast<std::uint64_t>(key.purpose)}}, counter_{{key.i, key.j, key.count, 0}} {}

  /// Returns the next word of the sequence: 64 pseudo-random bits, each 0 or 1 with equal probability.
  LICHTENBERG_HOST_DEVICE std::uint64_t word() {
    if (used_ == 4) {
      block_ = r123::Philox4x64()(counter_, key_);
      ++counter_[3];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Returns a uniformly distributed number in (0, 1), both ends excluded. It is (n + 1/2) / 2^52, without rounding,
  /// with the upper 52 bits of a word as n. Consumes one word.
  LICHTENBERG_HOST_DEVICE double uniform() { return (static_cast<double>(word() >> 12) + 0.5) * 0x1p-52; }

  /// Returns a uniformly distributed number between `low` and `high`. Consumes one word.
  LICHTENBERG_HOST_DEVICE double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Returns a normally distributed (Gaussian) number of mean 0 and variance 1, by the cosine formula of Box and Muller
  /// (1958). Its magnitude is at most 8.6. Consumes two words.
  LICHTENBERG_HOST_DEVICE double normal() {
    const double distance = std::sqrt(-2 * std::log(uniform()));
    return distance * std::cos(2 * std::numbers::pi * uniform());
  }

  /// Returns 1 or -1 with equal probability, by the highest bit of a word. Consumes one word.
  LICHTENBERG_HOST_DEVICE double sign() { return word() >> 63 ? -1 : 1; }

 private:
  r123::Philox4x64::key_type key_;
  r123::Philox4x64::ctr_type counter_, block_{};
  int used_ = 4;
};

}  // namespace lichtenberg
