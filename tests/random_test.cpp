#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/random.hpp"
#include "src/scene/charge_distribution.hpp"

namespace random_test {

using namespace lichtenberg;

namespace {

constexpr std::uint64_t all_ones = ~0ull;

/// Means of the first four powers of n numbers, each the first number of its own key, or all from one key.
using Moments = std::array<double, 4>;
template <class Draw>
Moments moments(int n, const Draw& draw) {
  Moments sum{};
  for (int k = 0; k < n; ++k) {
    const double x = draw(k);
    for (double power = x; double& s : sum) s += power / n, power *= x;
  }
  return sum;
}

/// Five standard deviations of a mean of n: exceeded once in two million seeds, and the seed is fixed.
double five_sigma(double variance, int n) { return 5 * std::sqrt(variance / n); }

}  // namespace

TEST_CASE("Random: known answers of Random123's Philox 4x64 with ten rounds") {
  // The counter is (i, j, count, n) and the key (seed, purpose). n counts blocks, so a stream gives the answers for
  // counters that end in 0. The generator itself gives the others.
  Random zeros(RandomKey{});
  for (const std::uint64_t word :
       {0x16554d9eca36314cull, 0xdb20fe9d672d0fdcull, 0xd7e772cee186176bull, 0x7e68b68aec7ba23bull})
    CHECK(zeros.word() == word);
  const auto ones = r123::Philox4x64()({{all_ones, all_ones, all_ones, all_ones}}, {{all_ones, all_ones}});
  CHECK(ones[0] == 0x87b092c3013fe90b);
  CHECK(ones[3] == 0xa09caebf594f0ba0);
  const auto pi = r123::Philox4x64()({{0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89}},
                                     {{0x452821e638d01377, 0xbe5466cf34e90c6c}});
  CHECK(pi[0] == 0xa528f45403e61d95);
  CHECK(pi[3] == 0x57bd43b5e52b7fe6);
}

TEST_CASE("Random: a key's sequence has counters (i, j, count, n), n = 0, 1, 2") {
  Random random({7, RandomPurpose::exchange, 11, 13, 17});
  for (std::uint64_t n = 0; n < 3; ++n)
    for (const std::uint64_t word : r123::Philox4x64()({{11, 13, 17, n}}, {{7, 2}})) CHECK(random.word() == word);
}

TEST_CASE("Random: numbers of a key do not depend on draws of other keys") {
  const RandomKey key{1, RandomPurpose::gas, 5, 0, 3};
  Random alone(key), among(key), other({2, RandomPurpose::gas, 5, 0, 3});
  for (int k = 0; k < 10; ++k) {
    other.normal();
    CHECK(alone.uniform() == among.uniform());
  }
}

TEST_CASE("RandomKey: each part (seed, purpose, i, j, count) changes the sequence") {
  std::vector<std::uint64_t> first;
  for (const RandomKey& key : {RandomKey{},
                               {.seed = 1},
                               {.purpose = RandomPurpose::population},
                               {.purpose = RandomPurpose::gas},
                               {.i = 1},
                               {.j = 1},
                               {.count = 1},
                               {.i = 1, .j = 1}})
    first.push_back(Random(key).word());
  std::ranges::sort(first);
  CHECK(std::ranges::adjacent_find(first) == first.end());
}

TEST_CASE("Random::uniform: right moments along a sequence and across keys") {
  const int n = 200000;
  Random random({1, RandomPurpose::population});
  const auto along = [&](int) { return random.uniform(); };
  const auto across = [](int k) {
    return Random(
               {1, RandomPurpose::exchange, static_cast<std::uint64_t>(k / 500), static_cast<std::uint64_t>(k % 500)})
        .uniform();
  };
  for (const Moments& found : {moments(n, along), moments(n, across)})
    for (int p = 1; p <= 4; ++p)  // <x^p> = 1/(p+1), with the variance 1/(2p+1) - 1/(p+1)^2.
      CHECK(std::abs(found[p - 1] - 1.0 / (p + 1)) < five_sigma(1.0 / (2 * p + 1) - 1.0 / ((p + 1) * (p + 1)), n));
}

TEST_CASE("Random::uniform: neighbouring keys are uncorrelated") {
  const int n = 200000;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const auto i = static_cast<std::uint64_t>(k);
    sum +=
        (Random({1, RandomPurpose::gas, i}).uniform() - 0.5) * (Random({1, RandomPurpose::gas, i + 1}).uniform() - 0.5);
  }
  CHECK(std::abs(sum / n) < five_sigma(1.0 / 144, n));  // The product of two independent variances of 1/12.
}

TEST_CASE("Random::uniform: excludes the ends of (0, 1) and of intervals") {
  // The smallest and the largest number that a word can give.
  CHECK((static_cast<double>(all_ones >> 12) + 0.5) * 0x1p-52 < 1);
  Random random({3});
  double least = 1, most = 0;
  for (int k = 0; k < 10000; ++k) {
    const double x = random.uniform(-2, 3);
    least = std::min(least, x), most = std::max(most, x);
  }
  // No number within 0.01 of an end has a probability of (1 - 0.002)^10000 = 2e-9.
  CHECK(least > -2);
  CHECK(least < -1.99);
  CHECK(most > 2.99);
  CHECK(most < 3);
}

TEST_CASE("Random::normal: moments and tails of a Gaussian") {
  const int n = 200000;
  Random random({1, RandomPurpose::gas});
  double beyond[3] = {};
  const Moments found = moments(n, [&](int) {
    const double x = random.normal();
    for (int k = 0; k < 3; ++k) beyond[k] += x > k + 1 ? 1.0 / n : 0;
    return x;
  });
  // Moments 0, 1, 0, 3; variances of x^p: 1, 2, 15, 105 - 9.
  CHECK(std::abs(found[0]) < five_sigma(1, n));
  CHECK(std::abs(found[1] - 1) < five_sigma(2, n));
  CHECK(std::abs(found[2]) < five_sigma(15, n));
  CHECK(std::abs(found[3] - 3) < five_sigma(96, n));
  for (int k = 0; k < 3; ++k) {
    const double tail = 0.5 * std::erfc((k + 1) / std::sqrt(2.0));
    CHECK(std::abs(beyond[k] - tail) < five_sigma(tail * (1 - tail), n));
  }
}

TEST_CASE("Random::sign: fair and uncorrelated along a sequence") {
  const int n = 200000;
  Random random({1, RandomPurpose::exchange});
  double sum = 0, repeats = 0, before = 1;
  for (int k = 0; k < n; ++k) {
    const double sign = random.sign();
    CHECK_MESSAGE(std::abs(sign) == 1, sign);
    sum += sign, repeats += sign * before, before = sign;
  }
  CHECK(std::abs(sum / n) < five_sigma(1, n));
  CHECK(std::abs(repeats / n) < five_sigma(1, n));
}

TEST_CASE("random_charge: density exp(-|q|^z) with its variance") {
  const int n = 200000;
  // z = 200 is nearly uniform in (-1, 1), and |q|^z underflows for small q.
  for (const double z : {0.5, 1.0, 2.0, 8.0, 20.0, 200.0}) {
    Random random({1, RandomPurpose::population});
    double within = 0;
    int zeros = 0;
    const Moments found = moments(n, [&](int) {
      const double q = random_charge(z, random);
      zeros += q == 0;
      within += std::abs(q) < 0.1 ? 1.0 / n : 0;
      return q;
    });
    CHECK(zeros == 0);
    const double norm = std::tgamma(1 / z), variance = std::tgamma(3 / z) / norm, fourth = std::tgamma(5 / z) / norm;
    CHECK(std::abs(found[0]) < five_sigma(variance, n));
    CHECK(std::abs(found[1] - variance) < five_sigma(fourth - variance * variance, n));
    // Probability of |q| < 0.1 by the midpoint rule with 1000 intervals of sqrt(q), because the density may have a
    // cusp.
    double probability = 0;
    for (int k = 0; k < 1000; ++k) {
      const double root = std::sqrt(0.1) * (k + 0.5) / 1000, width = 2 * root * std::sqrt(0.1) / 1000;
      probability += z / norm * std::exp(-std::pow(root * root, z)) * width;
    }
    CHECK(std::abs(within - probability) < five_sigma(probability * (1 - probability), n));
  }
  for (const double refused : {0.0, -1.0, std::nan("")}) {
    Random random({1});
    CHECK_THROWS_AS(random_charge(refused, random), InputError);
  }
}

}  // namespace random_test
