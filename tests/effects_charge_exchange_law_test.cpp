#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "src/effects/charge_exchange_law.hpp"

namespace effects_charge_exchange_law_test {

using namespace lichtenberg;
using namespace lichtenberg::effects;
using doctest::Approx;
using std::numbers::pi;

namespace {

constexpr int many = 200000;

Random pair_random(std::uint64_t count) { return Random({1, RandomPurpose::exchange, 3, 8, count}); }

/// Mean and mean square over many collisions, and five standard deviations of each.
struct Sample {
  double mean = 0, square = 0, mean_error = 0, square_error = 0;
};
Sample sample(const std::function<double(Random&)>& draw) {
  Sample s;
  double fourth = 0;
  for (int k = 0; k < many; ++k) {
    Random random = pair_random(k);
    const double dq = draw(random);
    s.mean += dq / many, s.square += dq * dq / many, fourth += dq * dq * dq * dq / many;
  }
  s.mean_error = 5 * std::sqrt(s.square / many);
  s.square_error = 5 * std::sqrt((fourth - s.square * s.square) / many);
  return s;
}

/// <(Psi_1 energy)^(2 (eta + Psi_2))>: exact in Psi_1, and by the midpoint rule with 100 intervals in Psi_2.
double impact_square(double eta, double energy) {
  const double low = 0.1, high = std::sqrt(10.0);
  double sum = 0;
  for (int k = 0; k < 100; ++k) {
    const double p = 2 * eta * (0.95 + 0.1 * (k + 0.5) / 100);
    sum += std::pow(energy, p) * (std::pow(high, p + 1) - std::pow(low, p + 1)) / ((p + 1) * (high - low)) / 100;
  }
  return sum;
}

}  // namespace

TEST_CASE("ImpactExchange of charge: zero mean, mean square of its law") {
  const ImpactExchange law{2, 0.83};
  for (const double speed : {0.1, 3.0}) {
    const Sample s = sample([&](Random& random) { return law(0.5, speed, random); });
    CHECK(std::abs(s.mean) < s.mean_error);
    CHECK(std::abs(s.square - 4 * impact_square(0.83, 0.5 * speed * speed)) < s.square_error);
  }
}

TEST_CASE("ImpactExchange of charge: random factors stay within the law's limits") {
  double least = 1e9, most = 0;
  const ImpactExchange law{1, 2};
  for (int k = 0; k < many; ++k) {
    Random random = pair_random(k);
    // With m_eff v^2 = 1 the charge is Psi_1^(2 + Psi_2), with Psi_2 within +-0.1.
    const double dq = std::abs(law(0.5, std::sqrt(2.0), random));
    least = std::min(least, dq), most = std::max(most, dq);
  }
  CHECK(least > std::pow(0.1, 2.1));
  CHECK(least < std::pow(0.1, 2.0));
  CHECK(most < std::pow(10, 1.05));
  CHECK(most > 10);
}

// Above 256 pairs of patches the law has the Gaussian limit.
TEST_CASE("PatchExchange of charge: mean and variance of its pairs of patches") {
  for (const double patches : {0.3, 12.0, 250.0, 1000.0})
    for (const auto& [donor_i, donor_j] : {std::pair{0.5, 0.5}, {0.7, 0.2}, {0.0, 1.0}}) {
      CAPTURE(patches);
      CAPTURE(donor_i);
      const PatchExchange law{1, patches, 0.4};
      const double gain = donor_i * (1 - donor_j), loss = donor_j * (1 - donor_i), drift = gain - loss;
      const double pairs = patches * std::pow(2, 0.4);
      const double fraction = pairs - std::floor(pairs);  // their number is rounded at random
      const double variance = pairs * (gain + loss - drift * drift) + drift * drift * fraction * (1 - fraction);
      const Sample s = sample([&](Random& random) { return law(2, donor_i, donor_j, random) - pairs * drift; });
      CHECK(std::abs(s.mean) <= s.mean_error);
      CHECK(std::abs(s.square - variance - (pairs > 256 && std::abs(drift) < 1 ? 1.0 / 12 : 0)) <=
            s.square_error + 1e-12);
    }
}

TEST_CASE("charge exchange by random walk: variance proportional to the time step") {
  const RandomWalkExchange walk{2, 5};
  const ContactAreaExchange area{2, 5};
  for (const double dt : {0.01, 0.04}) {
    const Sample s = sample([&](Random& random) { return walk(dt, random); });
    CHECK(std::abs(s.mean) < s.mean_error);
    CHECK(std::abs(s.square - 4 * 5 * dt) < s.square_error);
    const Sample a = sample([&](Random& random) { return area(0.3, dt, random); });
    CHECK(std::abs(a.square - 4 * 0.09 * 5 * dt) < a.square_error);
  }
}

TEST_CASE("contact_area: area of the circle in which two spheres intersect") {
  for (const double overlap : {0.0, 1e-9, 0.1, 0.4})
    CHECK(contact_area(0.5, 0.5, overlap) == Approx(pi * overlap / 2 * (1 - overlap / 2)).epsilon(1e-14));
  // For radii 3 and 4 at distance 5 the circle's radius is the height of a right triangle, 12/5.
  CHECK(contact_area(3, 4, 2) == Approx(pi * 5.76).epsilon(1e-14));
}

TEST_CASE("charge quanta: charges sum to exactly zero after a million transfers") {
  const double strength = 4.5e-3, quantum = charge_quantum(strength);
  CHECK(quantum == std::ldexp(1.0, -38));  // 2^-8 <= Q < 2^-7
  CHECK(charge_quantum(2) == std::ldexp(1.0, -29));
  const ImpactExchange law{strength, 0.83};
  std::vector<double> charge(1000);
  Random random({5, RandomPurpose::exchange});
  for (int k = 0; k < 1000000; ++k) {
    const std::size_t i = random.word() % charge.size(), j = random.word() % charge.size();
    const double dq = whole_quanta(law(0.5, 3 * random.uniform(), random), quantum);
    if (i == j) continue;
    const ExchangedCharges after = exchange_charges(charge[i], charge[j], dq, INFINITY, OverCapacity::refuse);
    charge[i] = after.i, charge[j] = after.j;
  }
  double up = 0, down = 0, square = 0;
  for (std::size_t k = 0; k < charge.size(); ++k)
    up += charge[k], down += charge[charge.size() - 1 - k], square += charge[k] * charge[k];
  CHECK(square > 1);
  CHECK(up == 0);
  CHECK(down == 0);
}

TEST_CASE("charge transfer: half the strength gives exactly half the charge") {
  for (int k = 0; k < 1000; ++k) {
    Random one = pair_random(k), other = pair_random(k);
    const double whole = ImpactExchange{4.5e-3, 0.83}(0.5, 1.7, one);
    const double half = ImpactExchange{2.25e-3, 0.83}(0.5, 1.7, other);
    CHECK(whole == 2 * half);
    CHECK(whole_quanta(whole, charge_quantum(4.5e-3)) == 2 * whole_quanta(half, charge_quantum(2.25e-3)));
    CHECK(std::abs(whole_quanta(whole, charge_quantum(4.5e-3)) - whole) <= charge_quantum(4.5e-3) / 2);
  }
}

TEST_CASE("exchange_charges: above capacity refuses or resets, states lost charge") {
  const auto refused = exchange_charges(0.75, -0.5, 0.5, 1, OverCapacity::refuse);
  CHECK(refused.i == 0.75);
  CHECK(refused.j == -0.5);
  CHECK(refused.lost == 0);
  CHECK(exchange_charges(0, 0.75, -0.5, 1, OverCapacity::refuse).j == 0.75);
  CHECK(exchange_charges(0.75, -0.5, 0.25, 1, OverCapacity::refuse).i == 1);  // Up to the capacity.
  CHECK(exchange_charges(-0.75, 0.5, -0.5, 1, OverCapacity::refuse).i == -0.75);
  CHECK(exchange_charges(0.5, 0.75, -0.25, 1, OverCapacity::refuse).j == 1);
  const auto reset = exchange_charges(0.75, -0.75, 0.5, 1, OverCapacity::reset);
  CHECK(reset.i == 0);
  CHECK(reset.j == 0);
  CHECK(reset.lost == 0);  // 1.25 and -1.25
  const auto one = exchange_charges(0.75, 0.25, 0.5, 1, OverCapacity::reset);
  CHECK(one.i == 0);
  CHECK(one.j == -0.25);
  CHECK(one.lost == 1.25);
  CHECK(exchange_charges(0.75, 0.25, 0.125, 1, OverCapacity::reset).i == 0.875);
  CHECK(exchange_charges(1e9, -1e9, 1e9, INFINITY, OverCapacity::refuse).i == 2e9);
}

}  // namespace effects_charge_exchange_law_test
