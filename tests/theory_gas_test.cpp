#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/monopolar.hpp"
#include "src/theory/restitution.hpp"
#include "tests/message.hpp"
#include "validation/theory/two_grains.hpp"

namespace theory_gas_test {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using doctest::Approx;
using std::numbers::pi;

namespace {

const ViscoelasticPair grains{278.6, 27.7};           // G chapter 4
constexpr double density = 50016 / (70.0 * 70 * 70);  // G chapter 4: phi = 0.0763.

double restitution(double speed) { return collision(grains, speed).restitution; }

/// Local exponent of the temperature, over 1 % of the time.
double slope(const Impacts& impacts, double time) {
  const std::vector<CoolingState> states = cool(density, impacts, 10, std::vector{time, 1.01 * time});
  return std::log(states[1].temperature / states[0].temperature) / std::log(1.01);
}

}  // namespace

TEST_CASE("integrate: CVODE ends at an event or at the given time") {
  Ode oscillator{
      .rates = [](double, std::span<const double> y, std::span<double> rate) { rate[0] = y[1], rate[1] = -y[0]; },
      .absolute = {1e-14, 1e-14}};
  std::vector<double> y = {0, 1};
  CHECK(integrate(oscillator, 0, 2, y).event == -1);
  CHECK(y[0] == Approx(std::sin(2.0)).epsilon(1e-12).scale(0));
  // Both are below zero soon: the sine crosses downwards at pi. The cosine, already below zero, crosses downwards at
  // pi/2 + 2 pi.
  oscillator.falls = {[](double, std::span<const double> now) { return now[1]; },
                      [](double, std::span<const double> now) { return now[0]; }};
  const OdeEnd end = integrate(oscillator, 2, 100, y);
  CHECK(end.event == 1);
  CHECK(end.time == Approx(pi).epsilon(1e-12).scale(0));
  // The whole time series in one call ends where the sine crosses zero, at pi.
  const std::vector<double> times = {2, 2.5, 3, 7, 9};
  const auto course = integrate(oscillator, 2, {std::sin(2.0), std::cos(2.0)}, times);
  REQUIRE(course.size() == 3);
  for (std::size_t k = 0; k < course.size(); ++k)
    CHECK(course[k][0] == Approx(std::sin(times[k])).epsilon(1e-12).scale(0));
  oscillator.rates = [](double, std::span<const double>, std::span<double>) { throw InputError("out of range"); };
  CHECK(message_of([&] { integrate(oscillator, 0, 1, y); }) == "out of range");
}

TEST_CASE("viscoelastic restitution: elastic limit and first terms of its series") {
  const UniversalCollision elastic = universal_collision(0);
  // s'^2 = 1 - (4/5) s^(5/2): the maximum overlap is (5/4)^(2/5), and the duration, by a beta function, 2 (5/4)^(2/5)
  // (2/5) B(2/5, 1/2).
  CHECK(elastic.deepest == Approx(std::pow(1.25, 0.4)).epsilon(1e-12).scale(0));
  CHECK(elastic.duration == Approx(0.8 * std::pow(1.25, 0.4) * std::beta(0.4, 0.5)).epsilon(1e-11).scale(0));
  CHECK(elastic.duration == Approx(3.21806).epsilon(2e-6).scale(0));
  CHECK(elastic.loss == Approx(first_loss()).epsilon(1e-11).scale(0));
  CHECK(first_loss() == Approx(1.153449).epsilon(1e-6).scale(0));
  // eps = 1 - c k + a k^2 + b k^(5/2) with a = (3/5) c^2 (Ramirez et al. 1999). The remainder decreases as k^(3/2).
  const double k = 1e-6, a = 0.6 * first_loss() * first_loss();
  CHECK(a == Approx(0.80).epsilon(3e-3).scale(0));
  CHECK((first_loss() - universal_collision(k).loss) / k == Approx(a).epsilon(2e-3).scale(0));
}

TEST_CASE("restitution curve: equals CVODE's integration at and between its points") {
  for (double k = 1e-9; k < RestitutionCurve::largest; k *= 1.7) {
    const UniversalCollision found = restitution_curve()(k), exact = universal_collision(k);
    CHECK(std::abs(found.loss - exact.loss) < 1e-11);
    CHECK(found.duration == Approx(exact.duration).epsilon(1e-9).scale(0));
    CHECK(found.deepest == Approx(exact.deepest).epsilon(1e-11).scale(0));
  }
  CHECK(restitution_curve()(0).loss == Approx(first_loss()).epsilon(1e-11).scale(0));
  CHECK(restitution_curve()(RestitutionCurve::largest).loss < 0.01);  // (1 - eps) / k
  for (const double refused : {-1e-9, 100.001, std::nan("")}) CHECK_THROWS_AS(restitution_curve()(refused), InputError);
}

TEST_CASE("viscoelastic collision: known values at E = 278.6, D = 27.7") {
  // Speed, restitution, duration and overlap of an independent program, to its printed digits.
  const double known[][4] = {{1e-6, .914344, 4.005, 1.33e-6}, {1e-4, .802964, 1.560, 5.05e-5},
                             {1e-3, .712488, .965, 3.04e-4},  {.01, .597185, .591, 1.80e-3},
                             {.1, .464641, .358, .0103},      {1, .330835, .213, .0573},
                             {5, .246636, .147, .186},        {10, .214278, .125, .307}};
  CHECK(dissipation_number(grains, 1) == Approx(1.2471052287).epsilon(1e-10).scale(0));
  for (const auto& [speed, eps, duration, overlap] : known) {
    const PairCollision found = collision(grains, speed);
    CHECK(std::abs(found.restitution - eps) < 5.1e-7);
    CHECK(found.duration == Approx(duration).epsilon(4e-3).scale(0));
    CHECK(found.overlap == Approx(overlap).epsilon(4e-3).scale(0));
  }
  // The maximum overlap of elastic grains is their diameter where E (2/5) = m_eff v^2 / 2.
  CHECK(piercing_speed(grains) == Approx(21.1).epsilon(1e-3).scale(0));
}

TEST_CASE("restitution: Mueller and Poeschel's closed form is within 0.01") {
  double worst = 0;
  for (double k = 1e-3; k < RestitutionCurve::largest; k *= 1.1)
    worst = std::max(worst, std::abs(pade_restitution(k) - (1 - k * restitution_curve()(k).loss)));
  CHECK(worst < 0.01);
  CHECK(worst > 0.005);
  // The closed form has the curve's series up to k^2, 1 - c k + (3/5) c^2 k^2; its coefficients of six digits leave
  // 1e-6 k.
  const double k = 1e-3, c = first_loss();
  CHECK(std::abs(pade_restitution(k) - (1 - c * k + 0.6 * c * c * k * k)) < std::pow(k, 2.5) + 1e-6 * k);
}

TEST_CASE("Haff's law: collision rate and cooling time of hard spheres") {
  CHECK(contact_value(density) == Approx(1.2206).epsilon(1e-4).scale(0));
  // omega t_c with the elastic duration at v^2 = 4T.
  const auto overlap_in_time = [](double temperature) {
    const double scale = std::pow(0.25 / (278.6 * 278.6 * std::sqrt(4 * temperature)), 0.2);
    return collision_frequency(density, temperature) * scale * universal_collision(0).duration;
  };
  CHECK(overlap_in_time(10) == Approx(0.71).epsilon(0.01).scale(0));
  CHECK(overlap_in_time(1) == Approx(0.28).epsilon(0.01).scale(0));
  CHECK(overlap_in_time(0.1) == Approx(0.112).epsilon(0.01).scale(0));
  CHECK(haff_temperature(10, 2, 2) == 2.5);
  // 1/tau = (2/3) sqrt(pi) (1 - eps^2) n g sqrt(T).
  CHECK(1 / haff_time(density, 10, 0.9) ==
        Approx(2.0 / 3 * std::sqrt(pi) * 0.19 * density * contact_value(density) * std::sqrt(10))
            .epsilon(1e-14)
            .scale(0));
  CHECK(haff_time(density, 10, 0.9) ==
        Approx(haff_time(density, 10, 0.9, 0.1) * (1 + 0.3 / 16)).epsilon(1e-14).scale(0));
}

TEST_CASE("impact_mean: averages over impact speeds equal gamma functions") {
  // v^2 = 4 T x, x ~ exp(-x): <v^p> = (4T)^(p/2) Gamma(1 + p/2). For p = 1/5 the integrand is singular at 0.
  for (const double p : {0.2, 1.0, 2.0})
    CHECK(impact_mean(0.3, [&](double v, double) { return std::pow(v, p); }) ==
          Approx(std::pow(1.2, p / 2) * std::tgamma(1 + p / 2)).epsilon(1e-12).scale(0));
  CHECK(impact_mean(0.3, [](double, double x) { return x * x; }) == Approx(2).epsilon(1e-12).scale(0));
}

TEST_CASE("constant restitution: cooling is Haff's law, slower with contact time") {
  const Impacts constant{[](double) { return 0.9; }};
  const double tau = haff_time(density, 10, 0.9);
  const std::vector<double> times = {1, 10, 1000};
  const std::vector<CoolingState> states = cool(density, constant, 10, times);
  for (std::size_t k = 0; k < times.size(); ++k) {
    CHECK(states[k].temperature == Approx(haff_temperature(10, tau, times[k])).epsilon(1e-9).scale(0));
    // Integral of omega_0 / (1 + t/tau).
    CHECK(states[k].collisions ==
          Approx(collision_frequency(density, 10) * tau * std::log1p(times[k] / tau)).epsilon(1e-9).scale(0));
  }
  // With t_c = c / omega the collision rate decreases by 1 + c at every temperature, and tau increases by it.
  const Impacts slowed{constant.restitution, [](double t) { return 0.5 / collision_frequency(density, t); }};
  CHECK(cool(density, slowed, 10, times)[1].temperature ==
        Approx(haff_temperature(10, 1.5 * tau, 10)).epsilon(1e-9).scale(0));
}

TEST_CASE("viscoelastic gas: cooling exponent is -1.87 early and -1.73 late") {
  CHECK(slope({restitution}, 1e2) == Approx(-1.87).epsilon(3e-3).scale(0));
  CHECK(slope({restitution}, 1e6) == Approx(-1.73).epsilon(3e-3).scale(0));
  // Weakly dissipative grains reach -5/3 (Brilliantov and Poeschel 2000): 1 - eps^2 = 2 c v^(1/5) gives dT/dt ~
  // -T^(8/5). At v < 0.1, where 1 - eps < 1e-2 k c = 0.007, the solution is within that of the power law.
  const ViscoelasticPair weak{278.6, 0.277};
  CHECK(slope({[&](double v) { return collision(weak, v).restitution; }}, 1e4) ==
        Approx(-5.0 / 3).epsilon(7e-3).scale(0));
}

TEST_CASE("charging gas: <q^2> is <dq^2> times the number of collisions") {
  // dq constant: <q^2> = dq^2 collisions.
  const Impacts constant{restitution, {}, [](double) { return 0.25; }};
  const CoolingState state = cool(density, constant, 10, std::vector{5.0})[0];
  CHECK(state.charge_square == Approx(0.25 * state.collisions).epsilon(1e-9).scale(0));

  // With G's law of exchange K <q^2> / T is 1 at t = 870, 73, 21 for K Q^2 = 5e-8, 5e-6, 5e-5. These are whole units of
  // time, in each of which it grows by 2.7 / t; its exponent is slightly above 1.8.
  const Impacts impact{restitution, {}, [](double v) { return impact_charge_square(1, 0.83, 0.5, v); }};
  const double known[][2] = {{870, 5e-8}, {73, 5e-6}, {21, 5e-5}};
  for (const auto& [time, strength] : known) {
    const CoolingState then = cool(density, impact, 10, std::vector{time})[0];
    CHECK(strength * then.charge_square / then.temperature == Approx(1).epsilon(0.015).scale(0));
  }
}

TEST_CASE("impact_charge_square: mean square exchanged charge includes the noise") {
  // eta -> 0: the noise has no effect, <dq^2> = Q^2. eta = 1/2 with a half-width of the exponent's noise of 0.025:
  // <Psi_1> = 1.63114 m_eff v^2 Q^2, and a correction of the order of 0.025^2.
  CHECK(impact_charge_square(2, 1e-9, 0.5, 3) == Approx(4).epsilon(1e-7).scale(0));
  CHECK(impact_charge_square(2, 0.5, 0.5, 3) == Approx(4 * 4.5 * (0.1 + std::sqrt(10)) / 2).epsilon(3e-3).scale(0));
  CHECK(impact_charge_square(1, 0.5, 0.5, 3) != Approx(4.5 * (0.1 + std::sqrt(10)) / 2).epsilon(1e-6).scale(0));
}

TEST_CASE("log_h: logarithm of e^x Dawson(sqrt x) for small and large x") {
  CHECK(std::exp(log_h(1) - 1) ==
        Approx(0.53807950691276841914).epsilon(1e-14).scale(0));  // Dawson(1), Abramowitz & Stegun 7.5.
  CHECK(std::exp(log_h(4) - 4) == Approx(0.30134038892379196603).epsilon(1e-14).scale(0));  // Dawson(2).
  CHECK(log_h(1e-20) == Approx(-10 * std::log(10)).epsilon(1e-14).scale(0));                // sqrt(x) (1 + x/3).
  CHECK(log_h(50) ==
        Approx(log_h(std::nextafter(50, 0))).epsilon(1e-15).scale(0));  // The series and the asymptotic expansion.
  CHECK(log_h(1e4) == Approx(1e4 - std::log(200) + std::log1p(0.5e-4 + 0.75e-8)).epsilon(1e-14).scale(0));
}

TEST_CASE("monopolar gas: its temperature solves the rate equation") {
  for (const double barrier : {0.01, 1.0, 30.0}) {
    const MonopolarGas gas{10, 3, barrier};
    const Ode ode{.rates =
                      [&](double, std::span<const double> y, std::span<double> rate) {
                        rate[0] =
                            -2 / (gas.tau * std::sqrt(gas.initial)) * std::pow(y[0], 1.5) * std::exp(-barrier / y[0]);
                      },
                  .absolute = {1e-15}};
    std::vector<double> temperature = {10};
    double time = 0;
    for (const double next : {1e-3, 1.0, 30.0, 1e3}) {
      time = integrate(ode, time, next, temperature).time;
      CHECK(monopolar_temperature(gas, time) == Approx(temperature[0]).epsilon(1e-12).scale(0));
      CHECK(monopolar_time(gas, monopolar_temperature(gas, time)) == Approx(time).epsilon(1e-11).scale(0));
    }
  }
}

// (1 - 1.2 phi^(1/3))^2 = 1 - 2.4 phi^(1/3) + 1.44 phi^(2/3).
TEST_CASE("effective_barrier: falls with the filling from that of a pair to 0") {
  CHECK(effective_barrier(3, 0) == 3);
  for (const double phi : {1e-3, 0.0763, 0.3})
    CHECK(effective_barrier(3, phi) == Approx(3 * std::pow(1 - 1.2 * std::cbrt(phi), 2)).epsilon(1e-12).scale(0));
  CHECK(effective_barrier(3, std::pow(1 / 1.2, 3)) < 1e-12);
}

TEST_CASE("monopolar gas: Haff's law without repulsion, T = U / ln t at late times") {
  CHECK(monopolar_temperature({10, 3, 0}, 5) == haff_temperature(10, 3, 5));
  CHECK(monopolar_time({10, 3, 0}, haff_temperature(10, 3, 5)) == Approx(5));
  CHECK(monopolar_temperature({10, 3, 1e-300}, 5) == Approx(haff_temperature(10, 3, 5)).epsilon(1e-12).scale(0));
  CHECK(monopolar_temperature({10, 3, 1}, 0) == Approx(10).epsilon(1e-14).scale(0));
  // So cold that no collision occurs, and the inverse function.
  CHECK(monopolar_temperature({10, 3, 1e5}, 1e3) == Approx(10).epsilon(1e-14).scale(0));
  CHECK(std::isinf(monopolar_time({10, 3, 1e5}, 5)));
  // e^x / (2 sqrt(x)) (1 + 1/(2x) + ...) = (t/tau) sqrt(U/T_0), x = U/T.
  for (const double time : {1e6, 1e30, 1e300}) {
    const double x = 1 / monopolar_temperature({10, 3, 1}, time);
    CHECK(std::abs(x - std::log(2 * std::sqrt(x / 10) * time / 3)) < 1 / x);
  }
}

TEST_CASE("two neutral grains: restitution as in theory for both contact laws") {
  for (const double speed : {0.01, 1.0, 5.0}) {
    const PairContact found = contact({.elastic = 278.6, .dissipative = 27.7}, speed);
    const PairCollision theory = collision(grains, speed);
    CHECK(found.opens);
    CHECK(found.release / speed == Approx(theory.restitution).epsilon(1e-10).scale(0));
    CHECK(found.force_ends == Approx(theory.duration).epsilon(1e-9).scale(0));
    CHECK(found.deepest == Approx(theory.overlap).epsilon(1e-10).scale(0));
    CHECK(found.dissipated == Approx((speed * speed - found.release * found.release) / 4).epsilon(1e-10).scale(0));
    CHECK(found.duration > found.force_ends);
  }
  // A linear spring: exp(-2 z acos(z) / sqrt(1 - z^2)), z = B / sqrt(4 A m_eff).
  const double z = 10 / std::sqrt(2 * 278.6);
  CHECK(contact({.elastic = 278.6, .dissipative = 10, .exponent = 1}, 2).release / 2 ==
        Approx(std::exp(-2 * z * std::acos(z) / std::sqrt(1 - z * z))).epsilon(1e-10).scale(0));
  const PairContact elastic = contact({.elastic = 278.6}, 2);
  CHECK(elastic.release == Approx(2).epsilon(1e-10).scale(0));
  CHECK(elastic.dissipated == Approx(0));
  CHECK_THROWS_AS(contact({.elastic = 278.6}, 25), Failure);
  CHECK_NOTHROW(contact({.elastic = 278.6}, 21));
}

TEST_CASE("bound pair of grains: dissipates its energy down to resting contact") {
  for (const double coulomb : {-0.1, -0.001, -5.0})
    for (const double factor : {1.01, 1.5}) {
      const TwoGrains pair{.elastic = 278.6, .dissipative = 27.7, .coulomb = coulomb};
      const double rest = static_overlap(pair), impact = factor * escape_speed(pair);
      CHECK(278.6 * std::pow(rest, 1.5) == Approx(-coulomb / ((1 - rest) * (1 - rest))).epsilon(1e-13).scale(0));
      const PairOutcome found = outcome(pair, impact);
      CHECK(found.captured);
      CHECK(found.dissipated == Approx(impact * impact / 4 + coulomb - static_energy(pair)).epsilon(3e-10).scale(0));
    }
  const TwoGrains spring{.elastic = 278.6, .dissipative = 10, .coulomb = -0.1, .exponent = 1};
  CHECK(outcome(spring, 0.8).dissipated == Approx(0.16 - 0.1 - static_energy(spring)).epsilon(3e-10).scale(0));
  // E xi^p (1 - xi)^2 is at most E (3/7)^(3/2) (4/7)^2 = 25.5.
  CHECK(static_overlap({.elastic = 278.6, .coulomb = -25}) < 3.0 / 7);
  CHECK_THROWS_AS(static_overlap({.elastic = 278.6, .coulomb = -26}), InputError);
}

TEST_CASE("two attracting grains: captured below capture_speed, escape above it") {
  for (const double coulomb : {-0.1, -0.001}) {
    const TwoGrains pair{.elastic = 278.6, .dissipative = 27.7, .coulomb = coulomb};
    const double limit = capture_speed(pair);
    CHECK(escape_speed(pair) == Approx(2 * std::sqrt(-coulomb)));
    CHECK(limit > escape_speed(pair));
    CHECK(outcome(pair, limit * (1 - 1e-9)).captured);
    const double above = limit * (1 + 1e-9);
    const PairOutcome free = outcome(pair, above);
    CHECK_FALSE(free.captured);
    CHECK(free.contacts == 1);
    // The dashpot dissipates the rest of the kinetic energy, with or without charge.
    CHECK(free.dissipated == Approx((above * above - free.last * free.last) / 4).epsilon(1e-10).scale(0));
  }
  const PairOutcome repelled = outcome({.elastic = 278.6, .dissipative = 27.7, .coulomb = 0.1}, 0.8);
  CHECK_FALSE(repelled.captured);
  CHECK(repelled.contacts == 1);
  CHECK(capture_speed({.elastic = 278.6, .dissipative = 27.7}) == 0);
}

TEST_CASE("ImpactTable: a gas cools as with means by quadrature") {
  const Impacts impacts{.restitution = restitution,
                        .duration =
                            [](double temperature) {
                              return impact_mean(temperature,
                                                 [](double v, double) { return collision(grains, v).duration; });
                            },
                        .charge_square = [](double v) { return impact_charge_square(4.5e-3, 0.83, 0.5, v); }};
  const ImpactTable means(impacts), others(impacts);
  others.lost(3e-7), others.lost(40);
  for (const double temperature : {1e-6, 1e-3, 0.9, 1.0, std::exp(2.0), 9.7}) {
    CAPTURE(temperature);
    const auto lost = [](double v, double x) { return x * (1 - restitution(v) * restitution(v)); };
    // The quadrature has an error of 1e-13, and the restitution curve of 1e-11.
    CHECK(means.lost(temperature) == Approx(impact_mean(temperature, lost)).epsilon(1e-10).scale(0));
    CHECK(means.duration(temperature) == Approx(impacts.duration(temperature)).epsilon(1e-8).scale(0));
    CHECK(means.charge_square(temperature) ==
          Approx(impact_mean(temperature, [&](double v, double) { return impacts.charge_square(v); }))
              .epsilon(1e-11)
              .scale(0));
    CHECK(means.lost(temperature) == others.lost(temperature));
  }
  // Both have an error of 1e-9.
  const CoolingState by_table = cool(density, means, 10, std::vector{20.0})[0],
                     by_quadrature = cool(density, impacts, 10, std::vector{20.0})[0];
  CHECK(by_table.temperature == Approx(by_quadrature.temperature).epsilon(2e-9).scale(0));
  CHECK(by_table.charge_square == Approx(by_quadrature.charge_square).epsilon(2e-9).scale(0));
  CHECK(by_table.collisions == Approx(by_quadrature.collisions).epsilon(2e-9).scale(0));
}

}  // namespace theory_gas_test
