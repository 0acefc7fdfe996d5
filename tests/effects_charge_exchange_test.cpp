#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "src/effects/charge_exchange.hpp"
#include "src/model/bodies.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/grain_contact.hpp"

namespace effects_charge_exchange_test {

using namespace lichtenberg;
using namespace lichtenberg::effects;

namespace {

constexpr double strength = 0.01, speed = 1.7;

/// Two grains of radii 0.5 and 0.3 and masses 1 and 0.5, which touch along z; the first is above.
Bodies two_grains() {
  Bodies bodies;
  bodies.dimension = 3;
  bodies.box.lengths = {20, 20, 20};
  bodies.position = {10, 10, 10.8, 10, 10, 10};
  bodies.momentum.assign(6, 0);
  bodies.mass = {1, 0.5};
  bodies.radius = {0.5, 0.3};
  bodies.charge = {0, 0};
  return bodies;
}

/// Lets the two grains collide. Returns the charge of the first; both charges sum to exactly 0.
double collide(ChargeExchange& effect, Bodies& bodies, int times = 1) {
  ContactRecord contacts;
  contacts.begun = {{.pair = {0, 1}, .impact_speed = speed}};
  for (int k = 0; k < times; ++k) {
    std::vector<double> charge = bodies.charge;
    effect.exchange_charges(contacts, bodies, charge);
    bodies.charge = charge;
    CHECK(charge[0] + charge[1] == 0);
  }
  return bodies.charge[0];
}

ChargeExchangeOptions directed(ExchangeModel model) { return {.model = model, .strength = strength, .exponent = 0.83}; }

/// Q (m_eff v^2)^eta of a collision.
const double unit = strength * std::pow(0.5 / 1.5 * speed * speed, 0.83);
/// Transfers are rounded to 2^(floor(log2 Q) - 30).
const double quantum = strength * std::pow(2, -29);

}  // namespace

TEST_CASE("charge exchange by size: larger grain gains in proportion") {
  Bodies bodies = two_grains();
  ChargeExchange effect(directed(ExchangeModel::size), 1);
  CHECK(std::abs(collide(effect, bodies) - unit * 0.2 / 0.8) < quantum);
  std::swap(bodies.radius[0], bodies.radius[1]);
  CHECK(std::abs(collide(effect, bodies)) < 2 * quantum);
  bodies.radius[0] = bodies.radius[1];
  const double before = bodies.charge[0];
  CHECK(collide(effect, bodies) == before);
}

// Each of n collisions has N pairs of patches, which transfer +-Q with the probability 1/2: the variance is n N Q^2
// / 2.
TEST_CASE("charge exchange by patches: whole patches, variance of random steps") {
  const int samples = 20000, collisions = 20, pairs = 8;
  ChargeExchangeOptions options{.model = ExchangeModel::patches, .strength = strength, .exponent = 0};
  options.patches = pairs, options.affinity = {0.5, 0.5};
  const double patch = whole_quanta(strength, charge_quantum(strength));
  double square = 0, fourth = 0;
  for (int seed = 0; seed < samples; ++seed) {
    Bodies bodies = two_grains();
    ChargeExchange effect(options, seed);
    const double charge = collide(effect, bodies, collisions) / patch;
    CHECK(charge == std::round(charge));
    square += charge * charge / samples, fourth += std::pow(charge, 4) / samples;
  }
  const double variance = 0.5 * collisions * pairs;
  CHECK(std::abs(square - variance) < 4 * std::sqrt((fourth - square * square) / samples));
  // Donors alone against acceptors alone give all patches.
  options.affinity = {1, 0};
  Bodies bodies = two_grains();
  ChargeExchange effect(options, 1);
  CHECK(collide(effect, bodies, collisions) == collisions * pairs * patch);
}

TEST_CASE("charge exchange by material: proportional to affinities") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::material);
  options.affinity = {-0.4, 0.2};
  ChargeExchange effect(options, 1);
  CHECK(std::abs(collide(effect, bodies) + 0.6 * unit) < quantum);
  CHECK(std::abs(collide(effect, bodies, 9) + 6 * unit) < 10 * quantum);  // constant rate
}

// The recurrence D' = D (1 + 2 f u) + 2 d u of the difference D has the solution (d/f) ((1 + 2 f u)^n - 1).
TEST_CASE("charge exchange, feedback: closed forms of saturation and growth") {
  const int n = 40;
  for (const double feedback : {-3.0, 3.0}) {
    Bodies bodies = two_grains();
    ChargeExchangeOptions options = directed(ExchangeModel::size);
    options.feedback = feedback;
    ChargeExchange effect(options, 1);
    const double drive = 0.25, factor = 1 + 2 * feedback * unit;
    const double expected = drive / feedback * (std::pow(factor, n) - 1) / 2;
    // Each rounding grows by the factor of the later collisions.
    CHECK(std::abs(collide(effect, bodies, n) - expected) < n * quantum * std::max(1.0, std::pow(factor, n)));
  }
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::size);
  options.feedback = -3;
  ChargeExchange effect(options, 1);
  CHECK(std::abs(collide(effect, bodies, 5000) - 0.25 / 3 / 2) < 100 * quantum);
}

// With 2 |f| u = 2.5 the recurrence would diverge.
TEST_CASE("charge exchange, feedback: a fast collision saturates at once") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::size);
  options.feedback = -1.25 / unit;
  ChargeExchange effect(options, 1);
  const double saturated = -0.25 / options.feedback / 2;
  CHECK(std::abs(collide(effect, bodies) - saturated) < quantum);
  CHECK(std::abs(collide(effect, bodies, 40) - saturated) < quantum);
}

TEST_CASE("charge exchange, positive feedback: ends at the capacity") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::size);
  options.feedback = 3, options.capacity = 0.1;
  ChargeExchange effect(options, 1);
  const double last = collide(effect, bodies, 1000);
  CHECK(last <= 0.1);
  CHECK(last > 0.09);  // the last transfer is unit (0.25 + 3 * 0.2) = 0.009
}

TEST_CASE("charge exchange by polarization: linear in the field's component") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::polarization);
  options.field = {{5, 7, -2}, 3};
  ChargeExchange effect(options, 1);
  CHECK(std::abs(collide(effect, bodies) + 2 * unit) < quantum);
  CHECK(std::abs(collide(effect, bodies, 9) + 20 * unit) < 10 * quantum);
  // The upper grain of a pair across a periodic side is the one below the side.
  bodies = two_grains();
  bodies.box.sides[4] = bodies.box.sides[5] = Boundary::periodic;
  bodies.position = {10, 10, 0.3, 10, 10, 19.5};
  CHECK(std::abs(collide(effect, bodies) + 2 * unit) < quantum);
}

// Transfers of collision k are u d e^(-k/N), as both grains had k collisions.
TEST_CASE("charge exchange, memory: sum of a geometric series") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::size);
  options.memory = 5;
  ChargeExchange effect(options, 1);
  CHECK(std::abs(collide(effect, bodies, 12) - 0.25 * unit * std::expm1(-12.0 / 5) / std::expm1(-1.0 / 5)) <
        12 * quantum);
}

TEST_CASE("charge exchange, memory: restored checkpoint gives the same bits") {
  Bodies bodies = two_grains();
  ChargeExchangeOptions options = directed(ExchangeModel::size);
  options.memory = 5, options.feedback = -1;
  ChargeExchange effect(options, 1), later(options, 1);
  collide(effect, bodies, 3);
  Checkpoint checkpoint;
  effect.save(checkpoint);
  later.restore(checkpoint);
  Bodies same = bodies;
  CHECK(collide(effect, bodies, 4) == collide(later, same, 4));
  Bodies fresh = same;
  ChargeExchange without(options, 1);
  CHECK(collide(without, fresh) != collide(later, same));
}

}  // namespace effects_charge_exchange_test
