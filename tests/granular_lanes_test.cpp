// Tests of bitwise identity of one pair alone and in groups, and of the minimum time to contact. Compiled without
// contraction of products and sums, as the contacts of a gas are.

#include <doctest/doctest.h>

#include <experimental/simd>

#include "solvers/random.hpp"
#include "src/granular/contact_event_queue.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/model/linear_spring.hpp"
#include "src/model/viscoelastic.hpp"

namespace granular_lanes_test {

using namespace lichtenberg;
using namespace lichtenberg::granular;

namespace {

template <class Law, class Real>
struct ScaledLaw {
  Law law;
  ContactForceTerms<Real> operator()(const Real& overlap) const { return law.force_terms(overlap, Real(1.0)); }
};

/// Pair at the beginning of a step of `dt`: in contact for some time, or separate.
struct Start {
  Vec3 separation, velocity, slow_force, slope;
  bool touching = false;
  double age = 0;
};
constexpr double dt = 0.01;

/// Random pair whose contact begins, continues, ends or begins again within a step, or that misses each other.
Start random_start(Random& random) {
  const auto direction = [&] { return Vec3{random.normal(), random.normal(), random.normal()}; };
  Start start{.velocity = 2.0 * direction(), .slow_force = direction(), .slope = 10.0 * direction()};
  start.touching = random.uniform(0, 1) < 0.6;
  const Vec3 axis = direction();
  start.separation = (start.touching ? random.uniform(0.9, 1) : random.uniform(1, 1.03)) / norm(axis) * axis;
  start.age = start.touching ? random.uniform(0, 0.2) : 0;
  return start;
}

PairStep<3> alone(const auto& law, const Start& s) {
  const PairMotion<3, ScaledLaw<std::decay_t<decltype(law)>, double>> pair({law}, 1, 2, {s.slow_force, s.slope});
  return pair.integrate({s.separation, s.velocity}, s.touching, s.age, dt);
}

template <int lanes, class Law>
void check_same_bits(const Law& law, const std::vector<Start>& starts) {
  using Real = std::experimental::fixed_size_simd<double, lanes>;
  for (std::size_t first = 0; first + lanes <= starts.size(); first += lanes) {
    const auto number = [&](auto of) { return Real([&](int lane) { return of(starts[first + lane]); }); };
    const auto vector = [&](Vec3 Start::*of) {
      return LaneVec<3, Real>::each([&](int k) { return number([&](const Start& s) { return (s.*of)[k]; }); });
    };
    const PairMotion<3, ScaledLaw<Law, Real>, Real> pairs({law}, 1, 2,
                                                          {vector(&Start::slow_force), vector(&Start::slope)});
    const auto touching = number([](const Start& s) { return s.touching; }) > 0.5;
    auto begun = pairs.begin({vector(&Start::separation), vector(&Start::velocity)}, touching,
                             number([](const Start& s) { return s.age; }), dt);
    const auto ends = pairs.advance(begun, dt);
    const PairStep<3, Real> found = any(ends) ? chosen(ends, pairs.release_within(begun, dt), begun.step) : begun.step;
    for (int lane = 0; lane < lanes; ++lane) {
      const PairStep<3> expected = alone(law, starts[first + lane]);
      for (int k = 0; k < 3; ++k) {
        CHECK(found.end.separation[k][lane] == expected.end.separation[k]);
        CHECK(found.end.velocity[k][lane] == expected.end.velocity[k]);
      }
      CHECK(found.dissipated[lane] == expected.dissipated);
      CHECK(found.onset[lane] == expected.onset);
      CHECK(found.impact_speed[lane] == expected.impact_speed);
    }
  }
}

}  // namespace

TEST_CASE("pair motion: identical bits alone and in SIMD packs of 2, 4, 8 pairs") {
  Random random({.seed = 1, .purpose = RandomPurpose::population});
  std::vector<Start> starts;
  for (int n = 0; n < 800; ++n) starts.push_back(random_start(random));
  const ViscoelasticLaw law{278.6, 27.7};
  int begun = 0, ended = 0;
  for (const Start& start : starts) {
    const PairStep<3> step = alone(law, start);
    begun += step.onset >= 0;
    ended += start.touching && norm(step.end.separation) > 1;
  }
  REQUIRE(begun > 50);
  REQUIRE(ended > 20);
  check_same_bits<2>(law, starts);
  check_same_bits<4>(law, starts);
  check_same_bits<8>(law, starts);
  check_same_bits<8>(LinearSpringLaw{278.6, 10}, starts);
}

// Distance of two grains in straight flight, minus all effects of the bounds along the line between them.
TEST_CASE("min_time_to_contact: no contact before it, contact at it if head-on") {
  Random random({.seed = 5, .purpose = RandomPurpose::population});
  int parting = 0, tight = 0;
  for (int n = 0; n < 10000; ++n) {
    const auto direction = [&] { return Vec3{random.normal(), random.normal(), random.normal()}; };
    const Bounds bounds{.fastest = 5,
                        .velocity_kick = n % 3 == 0 ? 0 : random.uniform(0, 0.1),
                        .external_acceleration = n % 5 == 0 ? 0 : random.uniform(0, 2),
                        .contact_acceleration = random.uniform(1, 200),
                        .excess = n % 2 == 0 ? 0 : random.uniform(0, 0.01)};
    const Vec3 axis = direction(), across = direction();
    const Vec3 unit = 1 / norm(axis) * axis, separation = random.uniform(1.011, 1.5) * unit;
    const bool head_on = n % 4 == 0;
    const Vec3 velocity = head_on ? random.uniform(-2, 2) * unit : across;
    const auto broadcast = [](const Vec3& v) { return Vectors<3>::each([&](int k) { return SimdPack(v[k]); }); };
    const double time = min_time_to_contact<3>({broadcast(separation), broadcast(velocity)}, SimdPack(1.0), bounds)[0];
    REQUIRE(time > 0);
    const auto gap = [&](double t) {
      return norm(separation + t * velocity) - 2 * bounds.velocity_kick * t - bounds.contact_deviation(t) -
             bounds.external_acceleration * t * t - bounds.excess - 1;
    };
    constexpr double slack = 1e-8;  // Rounding of lengths, 1e-9, and of these sums.
    for (int part = 0; part <= 8; ++part) CHECK(gap(part * 0.125 * time) > -slack);
    parting += dot(separation, velocity) > 0;
    if (!head_on) continue;
    CHECK(gap(time) < slack);
    ++tight;
  }
  CHECK(parting > 3000);
  CHECK(tight == 2500);
}

}  // namespace granular_lanes_test
