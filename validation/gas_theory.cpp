// Compares theories of a gas of grains with quadrature, Monte Carlo, exact solutions and each other.
//
//   gas_theory         some seconds
//   gas_theory long    more samples, finer classes of sizes

#include <ctime>
#include <numbers>

#include "solvers/random.hpp"
#include "src/analysis/gas_growth.hpp"
#include "src/theory/kinetic.hpp"
#include "src/theory/kinetic_printed.hpp"
#include "src/theory/restitution.hpp"
#include "src/theory/smoluchowski.hpp"
#include "src/theory/stability.hpp"
#include "tests/charge_integrals.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace gas_theory_validation {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using namespace lichtenberg::validation;
using std::numbers::pi;

namespace {

const ViscoelasticPair grains{278.6, 27.7};
constexpr double density = 50016 / (70.0 * 70 * 70);
const Impacts laws{.restitution = [](double v) { return collision(grains, v).restitution; },
                   .charge_square = [](double v) { return impact_charge_square(1, 0.83, 0.5, v); }};

/// Returns the processor time of `work`.
template <class Work>
double seconds_of(const Work& work) {
  const std::clock_t before = std::clock();
  work();
  return static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
}

// Closed forms.

void closed_forms(Report& report) {
  report.section("rates of merging and contact, 1e-4 <= B <= 1e3, closed forms over quadrature - 1");
  std::vector<double> number, energy, charge, contact;
  for (double bjerrum = 1e-4; bjerrum < 1.01e3; bjerrum *= 1.19) {
    const double beta = 2 * bjerrum;
    const MergingIntegrals found = merging_integrals(beta);
    number.push_back(found.number / over_charges([&](double w) { return h_number(beta * w); }) - 1);
    energy.push_back(found.energy / over_charges([&](double w) { return h_energy(beta * w); }) - 1);
    charge.push_back(found.charge / over_charges([&](double w) { return w * h_number(beta * w); }) - 1);
    contact.push_back(contact_integral(3.1, beta) /
                          (2 * over_charges([&](double w) { return boost::math::tgamma(3.1, beta * w); })) -
                      1);
  }
  report.at_most("P_N", spread(number), 1e-10);  // the tolerance of the quadratures
  report.at_most("P_T", spread(energy), 1e-10);
  report.at_most("P_Q", spread(charge), 1e-10);
  report.at_most("G(31/10)", spread(contact), 1e-10);
}

// Monte Carlo.

void chance(Report& report, bool all) {
  report.section("collision integrals by Monte Carlo: differences in standard errors");
  const int samples = all ? 20'000'000 : 200'000;
  const Aggregates gas{.density = 0.1, .temperature = 0.02, .charge_square = 0.03, .mass = 5, .diameter = 1.7};
  for (const double bjerrum : {0.05, 1.0, 20.0}) {
    const double coupling = bjerrum * 0.02 * 1.7 / 0.03;
    Estimate mergers, loss, charge;
    for (int k = 0; k < samples; ++k) {
      Random random({.seed = 11, .purpose = RandomPurpose::population, .i = static_cast<std::uint64_t>(k)});
      double square = 0;
      for (int axis = 0; axis < 3; ++axis) square += std::pow(random.normal(), 2) * 2 * gas.temperature / gas.mass;
      const double product = gas.charge_square * random.normal() * random.normal(), energy = gas.mass * square / 4;
      const double coulomb = coupling * product / gas.diameter;
      const double rate = pi * std::pow(gas.density * gas.diameter, 2) / 2 * std::sqrt(square) * (1 - coulomb / energy);
      const bool bounces = energy > std::abs(coulomb), merges = coulomb < 0 && !bounces;
      const double normal = std::sqrt(square * random.uniform()), eps = laws.restitution(normal);
      mergers.add(merges ? rate : 0);
      loss.add(bounces ? rate * gas.mass / 4 * (1 - eps * eps) * normal * normal : merges ? rate * energy : 0);
      charge.add(bounces ? rate * 2 * laws.charge_square(normal) : merges ? 2 * rate * product : 0);
    }
    const KineticRates rates = kinetic_rates(gas, coupling, tabulated_means(laws, 10));
    const auto check = [&](const std::string& what, const Estimate& found, double expected) {
      // Five standard errors: exceeded once in two million seeds, and the seed is fixed.
      report.at_most(fmt::format("B = {:g}: {} {:.5g} +- {:.1g}", bjerrum, what, found.mean(), found.error()),
                     std::abs(found.mean() - expected) / found.error(), 5);
    };
    check("mergers", mergers, rates.mergers);
    check("energy", loss, rates.contact_loss + rates.merging_loss);
    check("charge", charge, rates.contact_charge - rates.merging_charge);
  }
}

// Time evolution.

void courses(Report& report) {
  report.section("a gas that charges and merges, to t = 1e4");
  const std::vector<double> times = {1, 10, 100, 1000, 1e4};
  for (const double coupling : {5e-6, 2e-5, 1e-4}) {
    KineticGas gas{.density = density,
                   .temperature = 10,
                   .coupling = coupling,
                   .impacts = laws,
                   .contact_value = contact_value(density)};
    std::vector<KineticState> found;
    const double seconds = seconds_of([&] { found = kinetic_evolution(gas, times); });
    report.at_most(fmt::format("K Q^2 = {:g}: seconds of processor", coupling), seconds, std::nullopt);
    for (std::size_t k = 0; k < times.size(); ++k)
      fmt::print("  t = {:<7g} T = {:<11.5g} n = {:<11.5g} <q^2>/Q^2 = {:<11.5g} B = {:.5g}\n", times[k],
                 found[k].temperature, found[k].density, found[k].charge_square, found[k].bjerrum);
    // There are no constants of motion. A run with fewer outputs must give the same final state within the tolerance.
    const double again = kinetic_evolution(gas, std::span(times).last(1))[0].temperature;
    report.at_most("T at the end with one output over that with five - 1",
                   std::abs(again / found.back().temperature - 1), 1e-8);
  }
  fmt::print("\ng_1 ... g_5 as they ought to be, and as printed (G 5.32-5.37)\n");
  for (const double b : {0.1, 0.5, 0.9}) {
    const KineticFunctions right = corrected_functions(b, 1.6), printed = printed_functions(b, 1.6);
    fmt::print("  B = {:g}: {:.4g} {:.4g}, {:.4g} {:.4g}, {:.4g} {:.4g}, {:.4g} {:.4g}, {:.4g} {:.4g}\n", b,
               right.mergers, printed.mergers, right.contact_loss, printed.contact_loss, right.merging_loss,
               printed.merging_loss, right.contact_charge, printed.contact_charge, right.merging_charge,
               printed.merging_charge);
  }
}

// Coagulation.

void coagulation(Report& report, bool all) {
  for (const double beta : {2.0, 3.0}) {
    report.section(fmt::format("coagulation in flight, beta = {:g}, to S = 1e3 and beyond", beta));
    std::vector<double> times, means;
    for (double t = 0.01; t < 150; t *= 1.2) times.push_back(t);
    std::vector<double> last;
    for (const double ratio : all ? std::vector{1.06, 1.03, 1.015} : std::vector{1.12, 1.06, 1.03}) {
      const std::vector<double> sizes = size_classes(60, ratio, 1e6);
      std::vector<SizeDistribution> found;
      const double seconds = seconds_of([&] { found = coagulate(flight_kernel(beta), sizes, times); });
      means.clear();
      for (const SizeDistribution& f : found) means.push_back(f.mean_size(sizes));
      last.push_back(means[40]);
      const double mass = found.back().moment(sizes, 1) + found.back().lost - 1;
      report.at_most(
          fmt::format("ratio {:g}, {} classes, S = {:.4g}: mass that left", ratio, sizes.size(), means.back()),
          found.back().lost, 1e-9);
      // Coalescence moves mass between classes. Thousands of steps round it, and CVODE conserves sums.
      report.at_most("all mass - 1", std::abs(mass), 1e-12);
      report.at_most("seconds of processor", seconds, std::nullopt);
      if (ratio > 1.02) continue;
      const auto from = std::ranges::lower_bound(means, 10.0) - means.begin();
      const auto fit =
          *analysis::fit_growth(std::span(times).subspan(from, means.size() - from), std::span(means).subspan(from));
      fmt::print("  S = {:.4g} (t + {:.4g})^{:.5g} from S = 10 on; z is {:g}; last local slope {:.4f}\n", fit.amplitude,
                 fit.shift, fit.exponent, flight_exponent(beta),
                 analysis::local_slopes(std::span(times).first(means.size()), means).back());
    }
    // Fixed pivots spread each aggregate's size over its class: an error of second order in the ratio.
    report.at_most("order of S in ratio - 1, less 2",
                   std::abs(std::log2((last[0] - last[1]) / (last[1] - last[2])) - 2), 0.15);
  }
}

// Stability.

void stability(Report& report) {
  report.section("stability: critical wave numbers by eigenvalues and by Routh and Hurwitz");
  std::vector<double> differences;
  for (double eps = 0.3; eps < 0.99; eps += 0.03)
    for (double r = 1e-4; r < 10; r *= 2) {
      const TransportCoefficients c = transport_coefficients(eps);
      const auto found = critical_waves(c, r), same = routh_hurwitz_waves(c, r);
      differences.push_back(found.size() == same.size() ? 0 : 1);
      for (std::size_t k = 0; k < std::min(found.size(), same.size()); ++k)
        differences.push_back(found[k].wave_number / same[k].wave_number - 1);
    }
  // The brackets shrink to 2^-48 = 4e-15. Where the heat mode is about to vanish, two of its wave numbers nearly
  // coincide and its rate barely crosses zero. The error is then at worst the root of the rounding error, and smaller
  // on this grid of R.
  report.at_most("relative", spread(differences), 1e-11);
  std::vector<double> k;
  for (int n = 1; n <= 300; ++n) k.push_back(0.001 * n);
  const double seconds = seconds_of([&] {
    for (const double eps : {0.8, 0.7, 0.6, 0.5, 0.4, 0.3})
      for (const double r : {0.0, 0.9}) growth_rates(transport_coefficients(eps), r, k);
  });
  report.at_most("seconds of processor for 12 curves of 300 wave numbers (G 6.2)", seconds, std::nullopt);
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Theories of a gas of grains");
  closed_forms(report);
  const bool all = long_run_requested(argc, argv);
  chance(report, all);
  courses(report);
  coagulation(report, all);
  stability(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("gas_theory", validate);

}  // namespace gas_theory_validation
