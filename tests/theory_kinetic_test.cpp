#include <doctest/doctest.h>

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/random.hpp"
#include "src/theory/kinetic.hpp"
#include "src/theory/kinetic_printed.hpp"
#include "src/theory/restitution.hpp"
#include "tests/charge_integrals.hpp"
#include "tests/message.hpp"

namespace theory_kinetic_test {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using doctest::Approx;
using std::numbers::pi;

namespace {

const ViscoelasticPair grains{278.6, 27.7};           // G chapter 4
constexpr double density = 50016 / (70.0 * 70 * 70);  // phi = 0.0763
const Impacts true_laws{.restitution = [](double v) { return collision(grains, v).restitution; },
                        .charge_square = [](double v) { return impact_charge_square(1, 0.83, 0.5, v); }};

Approx near(double value, double relative) { return Approx(value).epsilon(relative).scale(1e-290); }

/// 1 - eps^2 = 2 dissipation v^(1/5) and dq = transfer v^exponent as in G (5.28, 5.31).
ImpactMeans power_law_means(double dissipation, double transfer, double exponent) {
  return {[=](double t) { return 2 * dissipation * std::pow(4 * t, 0.1) * std::tgamma(2.1); },
          [=](double t) { return transfer * transfer * std::pow(4 * t, exponent) * std::tgamma(exponent + 1); }};
}

struct Estimates {
  Estimate mergers, contact_loss, merging_loss, contact_charge, merging_charge;
};

/// Monte Carlo estimates of the collision integrals of such a gas. Pairs have velocities and charges from their
/// Gaussians, and impact positions uniform over the disk of the cross section.
Estimates sampled(const Aggregates& gas, double coupling, const Impacts& impacts, bool at_contact, int samples) {
  Estimates found;
  for (int k = 0; k < samples; ++k) {
    Random random({.seed = 5, .purpose = RandomPurpose::population, .i = static_cast<std::uint64_t>(k)});
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) square += std::pow(random.normal() - random.normal(), 2);
    square *= gas.temperature / gas.mass;
    const double q = random.normal(), p = random.normal(), u = random.uniform();
    const double product = gas.charge_square * q * p, energy = gas.mass * square / 4;
    const double least = coupling * std::abs(product) / gas.diameter;  // b T
    // n^2 / 2 pairs, their speed, and the disk.
    const double disk = pi * gas.diameter * gas.diameter * (1 - coupling * product / (gas.diameter * energy));
    const double rate = disk > 0 ? gas.density * gas.density / 2 * std::sqrt(square) * disk : 0;
    const double gained = at_contact ? -coupling * product / gas.diameter : 0;
    const double normal = std::sqrt(std::max(4 / gas.mass * (energy + gained) * u, 0.0));
    const double eps = impacts.restitution(normal), loss = gas.mass / 4 * (1 - eps * eps) * normal * normal;
    const bool merges = product < 0 && (at_contact ? energy < loss : energy < least);
    const bool bounces = at_contact ? rate > 0 && !merges : energy > least;
    found.mergers.add(merges ? rate : 0);
    found.merging_loss.add(merges ? rate * energy : 0);
    found.merging_charge.add(merges ? -2 * rate * product : 0);
    found.contact_loss.add(bounces ? rate * loss : 0);
    found.contact_charge.add(bounces ? rate * 2 * impacts.charge_square(normal) : 0);
  }
  return found;
}

/// Five standard errors: once in two million seeds, and the seed is fixed.
void check(const Estimate& found, double expected) {
  CHECK(found.error() < 0.02 * found.mean());
  CHECK(std::abs(found.mean() - expected) < 5 * found.error());
}
void check(const Estimates& found, const KineticRates& expected) {
  check(found.mergers, expected.mergers);
  check(found.contact_loss, expected.contact_loss);
  check(found.merging_loss, expected.merging_loss);
  check(found.contact_charge, expected.contact_charge);
  check(found.merging_charge, expected.merging_charge);
}

KineticGas gas_of(double coupling) {
  return {.density = density, .temperature = 10, .coupling = coupling, .impacts = true_laws};
}

}  // namespace

TEST_CASE("merging integrals: closed forms and series equal quadrature") {
  for (const double bjerrum :
       {1e-4, 1e-3, 0.025, 0.1, 0.2499, 0.2501, 0.5, 0.81, 0.83, 1 - 1e-6, 1.0, 1 + 1e-6, 1.2, 1.3, 5.0, 30.0, 1e3}) {
    const double beta = 2 * bjerrum;
    const MergingIntegrals found = merging_integrals(beta);
    CHECK(found.number == near(over_charges([&](double w) { return h_number(beta * w); }), 1e-11));
    CHECK(found.energy == near(over_charges([&](double w) { return h_energy(beta * w); }), 1e-11));
    CHECK(found.charge == near(over_charges([&](double w) { return w * h_number(beta * w); }), 1e-11));
  }
  // First terms: the neglected ones are of the next order, at most a relative 2 beta.
  const MergingIntegrals small = merging_integrals(1e-6);
  CHECK(small.number == near(3 * pi / 16 * 1e-12, 2e-6));
  CHECK(small.energy == near(5.0 / 12 * 1e-18, 2e-6));
  CHECK(small.charge == near(0.75e-12, 2e-6));
  CHECK(merging_integrals(0).number == 0);
  // All collisions merge: h_N -> 1 + b.
  CHECK(merging_integrals(1e8).number == near((pi + 1e8) / 2, 1e-12));
  for (const double refused : {-1e-9, std::nan(""), 1e160}) CHECK_THROWS_AS(merging_integrals(refused), InputError);
}

TEST_CASE("contact_integral: equals quadrature over charges") {
  // G(p) = 4 int K_0(2w) Gamma(p, beta w) dw.
  for (const double p : {0.7, 2.0, 3.1, 3.66})
    for (const double bjerrum : {1e-4, 0.3, 1.0, 7.0, 1e3})
      CHECK(contact_integral(p, 2 * bjerrum) ==
            near(2 * over_charges([&](double w) { return boost::math::tgamma(p, 2 * bjerrum * w); }), 1e-10));
  CHECK(contact_integral(3.1, 0) == near(pi * std::tgamma(3.1), 1e-14));
  CHECK_THROWS_AS(contact_integral(0, 1), InputError);
  CHECK_THROWS_AS(contact_integral(2, -1), InputError);
}

TEST_CASE("kinetic rates: power laws give closed forms, also from tables") {
  const double loss = 1.3, transfer = 0.4, exponent = 1.6, temperature = 0.02;
  for (const double bjerrum : {0.0, 0.01, 1.0, 100.0}) {
    const Aggregates gas{.density = 0.1, .temperature = temperature, .charge_square = 3, .mass = 8, .diameter = 2};
    const double coupling = bjerrum * temperature * 2 / 3, beta = 2 * bjerrum;
    const KineticRates found = kinetic_rates(gas, coupling, power_law_means(loss, transfer, exponent));
    const double area = std::pow(0.1 * 2, 2), heat = 4 * temperature / 8;
    CHECK(found.contact_loss ==
          near(5 * loss * 8 / (21 * std::sqrt(pi)) * area * std::pow(heat, 1.6) * contact_integral(3.1, beta), 1e-11));
    CHECK(found.contact_charge == near(2 * transfer * transfer / (std::sqrt(pi) * (exponent + 1)) * area *
                                           std::pow(heat, exponent + 0.5) * contact_integral(exponent + 2, beta),
                                       1e-11));
    CHECK(found.mergers ==
          near(2 / std::sqrt(pi) * area * std::sqrt(temperature / 8) * merging_integrals(beta).number, 1e-14));
    const Impacts laws{
        .restitution = [=](double v) { return std::sqrt(std::max(1 - 2 * 0.01 * std::pow(v, 0.2), 0.0)); },
        .charge_square = [=](double v) { return transfer * transfer * std::pow(v, 2 * exponent); }};
    const KineticRates tabulated = kinetic_rates(gas, coupling, tabulated_means(laws, 10));
    CHECK(tabulated.contact_loss == near(found.contact_loss * 0.01 / loss, 1e-9));
    CHECK(tabulated.contact_charge == near(found.contact_charge, 1e-9));
  }
}

TEST_CASE("kinetic rates: equal Monte Carlo collision integrals" * doctest::test_suite("long")) {
  for (const double bjerrum : {0.3, 2.0}) {
    const Aggregates gas{.density = 0.1, .temperature = 0.5, .charge_square = 0.7, .mass = 3, .diameter = 1.4};
    const double coupling = bjerrum * 0.5 * 1.4 / 0.7;
    check(sampled(gas, coupling, true_laws, false, 200'000),
          kinetic_rates(gas, coupling, tabulated_means(true_laws, 10)));
    check(sampled(gas, coupling, true_laws, true, 200'000), contact_speed_rates(gas, coupling, true_laws));
  }
}

TEST_CASE("contact_speed_rates: kinetic_rates if neutral; no merging if elastic") {
  const Aggregates gas{.density = 0.1, .temperature = 0.5, .charge_square = 0.7};
  const KineticRates neutral = contact_speed_rates(gas, 0, true_laws),
                     same = kinetic_rates(gas, 0, tabulated_means(true_laws, 10));
  CHECK(neutral.mergers == 0);
  CHECK(neutral.contact_loss == near(same.contact_loss, 1e-6));
  CHECK(neutral.contact_charge == near(same.contact_charge, 1e-6));
  CHECK(contact_speed_rates(gas, 1, {.restitution = [](double) { return 1.0; }}).mergers == 0);
}

TEST_CASE("kinetic theory without charge interaction: Haff's law of cooling") {
  const std::vector<double> times = {0, 1, 30, 1000};
  const auto haff = cool(density, true_laws, 10, times);
  for (const bool merges : {true, false}) {
    KineticGas gas = gas_of(0);
    gas.merges = merges, gas.contact_value = contact_value(density);
    const auto found = kinetic_evolution(gas, times);
    for (std::size_t k = 0; k < times.size(); ++k) {
      CHECK(found[k].temperature == near(haff[k].temperature, 1e-7));
      CHECK(found[k].charge_square == near(haff[k].charge_square, 1e-7));
      CHECK(found[k].density == near(density, 1e-12));
      CHECK(found[k].bjerrum == 0);
    }
  }
  KineticGas slow = gas_of(0);
  slow.contact_value = contact_value(density);
  slow.impacts.duration = [](double t) { return 0.5 / std::sqrt(t); };
  CHECK(kinetic_evolution(slow, times)[2].temperature ==
        near(cool(density, slow.impacts, 10, times)[2].temperature, 1e-7));
}

TEST_CASE("Bjerrum number: has a maximum with merging, grows without it") {
  KineticGas gas = gas_of(5e-5);  // Q = 1: K Q^2
  std::vector<double> times;
  for (double t = 1; t < 1e5; t *= 1.3) times.push_back(t);
  double most = 0;
  const auto merging = kinetic_evolution(gas, times);
  for (const KineticState& state : merging) most = std::max(most, state.bjerrum);
  CHECK(most > 0.1);
  CHECK(most < 10);
  CHECK(merging.back().bjerrum < most);
  CHECK(merging.back().density < 0.5 * density);
  gas.merges = false;
  const auto bouncing = kinetic_evolution(gas, times);
  for (std::size_t k = 1; k < times.size(); ++k) CHECK(bouncing[k].bjerrum > bouncing[k - 1].bjerrum);
  CHECK(bouncing.back().bjerrum > 10 * most);
  CHECK(bouncing.back().density == near(density, 1e-12));
}

TEST_CASE("kinetic theory: depends only on Coulomb prefactor times charge squared") {
  const std::vector<double> times = {300};
  KineticGas gas = gas_of(1);
  gas.impacts.charge_square = [](double v) { return impact_charge_square(4.5e-3, 0.83, 0.5, v); };
  const KineticState found = kinetic_evolution(gas, times)[0],
                     same = kinetic_evolution(gas_of(4.5e-3 * 4.5e-3), times)[0];
  CHECK(found.temperature == near(same.temperature, 1e-7));
  CHECK(found.bjerrum == near(same.bjerrum, 1e-7));
}

TEST_CASE("kinetic functions, Bjerrum number 1e-6: printed charging is negative") {
  // At B -> 0, g_2 has 5.47's 80 2^(1/5)/(21 sqrt pi) pi/2, and no grains merge.
  const KineticFunctions none = printed_functions(1e-6, 1.6), right = corrected_functions(1e-6, 1.6);
  CHECK(none.contact_loss == near(80 * std::pow(2, 0.2) / (21 * std::sqrt(pi)) * pi / 2, 1e-5));
  CHECK(std::abs(none.mergers) < 1e-5);
  CHECK(none.contact_charge < 0);
  CHECK(right.contact_charge > 0);
  CHECK(right.contact_loss ==
        near(kinetic_rates({.density = 1, .temperature = 1}, 0, power_law_means(1, 1, 1.6)).contact_loss, 1e-5));
  for (const double refused : {0.0, 1.0, 1.5}) CHECK_THROWS_AS(printed_functions(refused, 1.6), InputError);
}

}  // namespace theory_kinetic_test
