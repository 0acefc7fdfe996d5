// Compares gases of a thousand grains with kinetic theory, and checks their energy and momentum balance.
//
//   gas         half a minute
//   gas long    more seeds, longer runs, and the contributions to the energy error
//
// Intervals are 95 % confidence intervals of means over the seeds (Student). Bounds include the estimated error of the
// theory.

#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/contact_steps.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/monopolar.hpp"
#include "src/theory/restitution.hpp"
#include "tests/grains.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace gas_validation {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using namespace lichtenberg::validation;

namespace {

constexpr double edge = 19;
constexpr int grains_of_a_gas = 1000;
const double density = grains_of_a_gas / (edge * edge * edge);

double temperature(const Run& run) { return 2 * run.gas.model().kinetic_energy() / (3.0 * grains_of_a_gas); }
double mean_square_charge(const Run& run) {
  double sum = 0;
  for (const double q : run.gas.bodies().charge) sum += q * q;
  return sum / grains_of_a_gas;
}

struct Interval {
  double mean = 0, half = 0;
};
/// Returns the 95 % confidence interval of the mean of a small sample.
Interval interval(const std::vector<double>& sample) {
  const Spread s = spread(sample);
  const auto n = static_cast<double>(sample.size());
  const double mean = [&] {
    double sum = 0;
    for (const double x : sample) sum += x / n;
    return sum;
  }();
  const double student = n > 10 ? 2.2 : n > 5 ? 2.5 : 3.2;  // for samples of at least 4
  return {mean, student * s.jitter / std::sqrt(n - 1)};
}

// Cooling and charging

Scene cooling(double stiffness, std::uint64_t seed) {
  Scene scene = cube(edge);
  // Shorter contacts with the same loss at each speed: (D/E) E^(2/5) is constant.
  scene.effects.add(effects::ViscoelasticContactOptions{278.6 * stiffness, 27.7 * std::pow(stiffness, 0.6)});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 1});  // without forces between charges
  scene.stages = {{.duration = 2, .stiffness = 10 / stiffness < 1 ? 1 : 10 / stiffness, .temperature = 1}};
  scene.seed = seed;
  add_gas(scene, grains_of_a_gas, edge, 1, seed);
  return scene;
}

theory::Impacts impacts_of(double stiffness, bool last) {
  const theory::ViscoelasticPair pair{278.6 * stiffness, 27.7 * std::pow(stiffness, 0.6)};
  theory::Impacts impacts{.restitution = [pair](double v) { return theory::collision(pair, v).restitution; },
                          .charge_square = [](double v) { return theory::impact_charge_square(1, 0.83, 0.5, v); }};
  if (last)
    impacts.duration = [pair](double t) {
      return theory::impact_mean(t, [&](double v, double) { return theory::collision(pair, v).duration; });
    };
  return impacts;
}

void haff(Report& report, bool all) {
  const std::vector<double> times = {1, 2, 5, 10, 20};
  const int seeds = all ? 12 : 4;
  for (const double stiffness : {1.0, 100.0}) {
    report.section(fmt::format("cooling from T = 1, E = {:g}: temperature over Haff's with the true restitution",
                               278.6 * stiffness));
    std::vector<std::vector<double>> found(times.size()), charge(times.size());
    for (int seed = 1; seed <= seeds; ++seed) {
      Run run(cooling(stiffness, seed));
      for (std::size_t k = 0; k < times.size(); ++k) {
        run.to(2 + times[k]);
        found[k].push_back(temperature(run)), charge[k].push_back(mean_square_charge(run));
      }
    }
    const auto theory = theory::cool(density, impacts_of(stiffness, true), 1, times);
    const auto at_once = theory::cool(density, impacts_of(stiffness, false), 1, times);
    const double left_out = stiffness == 1 ? 0.28 * 0.28 : 0.03;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const auto [mean, half] = interval(found[k]);
      // Errors of the theory: finite contact duration (omega t_c = .28 at T = 1, 20 % of that at a hundred times the
      // stiffness), whose second order is neglected in 1 / (1 + omega t_c); velocity correlations, .03. Beyond about
      // five collisions per grain, correlated grains are warmer than predicted, and no bound is available.
      const std::optional<double> bound = times[k] > 2 ? std::nullopt : std::optional(half / mean + left_out);
      report.at_most(fmt::format("t = {:g}: {:.4f} +- {:.4f} (95 %), off by", times[k], mean, half),
                     std::abs(mean / theory[k].temperature - 1), bound);
    }
    // Grains in contact still collide with others, but less often. To first order in omega t_c, charges lie between
    // those for exclusive contacts and those for instantaneous contacts. The second order is neglected as above.
    for (const std::size_t k : {0, 1, 2}) {
      const auto [mean, half] = interval(charge[k]);
      const double low = theory[k].charge_square, high = at_once[k].charge_square;
      report.at_most(fmt::format("t = {:g}: <q^2>/Q^2 = {:.2f} +- {:.2f}, outside {:.2f} to {:.2f} by", times[k], mean,
                                 half, low, high),
                     std::max({low - mean, mean - high, 0.0}) / mean, half / mean + left_out);
    }
  }
}

// Equal charges.

void monopolar(Report& report, bool all) {
  report.section("identical charges: T(t) with U_eff = U (1 - c phi^(1/3)) fitted");
  Scene scene = read_scene(source_folder() + "/scenes/monopolar.toml");
  scene.mechanics.threads = 1;
  Run run(scene);
  const double end = all ? 1000 : 200;
  std::vector<double> times, found;
  run.to(10);  // the potential energy of random positions becomes heat
  const double start = temperature(run);
  for (double t = 20; t <= end; t *= 1.25) {
    run.to(t);
    times.push_back(t - 10), found.push_back(temperature(run));
  }
  const double tau = theory::haff_time(density, start, 0.9);
  const auto off = [&](double barrier) {
    double squares = 0;
    for (std::size_t k = 0; k < times.size(); ++k)
      squares += std::pow(std::log(found[k] / theory::monopolar_temperature({start, tau, barrier}, times[k])), 2);
    return std::sqrt(squares / static_cast<double>(times.size()));
  };
  double best = 1e-6;
  for (double u = 1e-3; u < 0.2; u *= 1.01)
    if (off(u) < off(best)) best = u;
  const double phi = std::numbers::pi / 6 * density, c = (1 - best / 0.1) / std::cbrt(phi);
  fmt::print("U_eff / U = {:.3f}, c = {:.3f}; T({:g}) = {:.4g}, of Haff's law {:.4g}\n", best / 0.1, c, end,
             found.back(), theory::haff_temperature(start, tau, times.back()));
  // A run with 3 N velocity components: sqrt(2 / 3N) = .026. Haff's rate has an error of .03, which enters T twice. At
  // late times (long) T is far below U, and c increases with U / T instead of being constant.
  report.at_most("rms of ln T about the fit", off(best), all ? std::nullopt : std::optional(0.026 + 2 * 0.03));
  report.at_least("without charges it would be colder, by a factor",
                  found.back() / theory::haff_temperature(start, tau, times.back()), 1.1);
}

// Energy and momentum balance.

struct EnergyBalance {
  double warm_up, after, momentum;
};

EnergyBalance charged_run(double end, double accuracy, double step, int contact_steps) {
  Scene scene = cube(edge);
  scene.effects.add<effects::ViscoelasticContactOptions>();
  scene.effects.add(effects::CoulombOptions{.strength = 2.469, .accuracy = accuracy});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 4.5e-3});
  scene.stages = {{.duration = 2, .stiffness = 10, .temperature = 10}};
  scene.mechanics.step = step;
  scene.mechanics.contact_steps = contact_steps;
  add_gas(scene, grains_of_a_gas, edge, 10);
  Run run(scene);
  const double start = run.gas.energy().total();
  run.to(2);
  const granular::GasEnergy warm = run.gas.energy();
  run.to(2 + end);
  const granular::GasEnergy last = run.gas.energy();
  return {std::abs(warm.total() - start) / warm.kinetic, (last.total() - warm.total()) / last.dissipated,
          momentum(run.gas.bodies()) / std::sqrt(2 * grains_of_a_gas * last.kinetic)};
}

void energy_balances(Report& report, bool all) {
  report.section("energy balance of a charged gas that cools from T = 10 to t = 10, K Q^2 = 5e-5");
  constexpr double requested = 1e-3;
  const EnergyBalance at_requested = charged_run(10, requested, 0.05, contact_steps_for(requested));
  report.at_most("contact steps for an accuracy of 1e-3, warm-up: change over kinetic energy", at_requested.warm_up,
                 requested);
  report.at_most("residual, fraction of the dissipated energy", std::abs(at_requested.after), requested);
  // Second order in the step: 1/8 of the previous error.
  constexpr int usual = 45;
  const EnergyBalance balance = charged_run(10, requested, 0.05, usual);
  report.at_most("45 steps a contact, warm-up: change over kinetic energy", balance.warm_up, 1e-4);
  report.at_most("residual, fraction of the dissipated energy", std::abs(balance.after), 1e-4);
  report.at_most("momentum over thermal momentum", balance.momentum, 1e-10);
  if (!all) return;
  const auto show = [&](const std::string& what, const EnergyBalance& b) {
    report.at_most(what, std::abs(b.after), std::nullopt, fmt::format("{:+.2e}", b.after));
  };
  show("steps of contacts halved", charged_run(10, 1e-3, 0.05, 2 * usual));
  show("steps of contacts halved twice", charged_run(10, 1e-3, 0.05, 4 * usual));
  show("step halved", charged_run(10, 1e-3, 0.025, usual));
  show("forces to 1e-4", charged_run(10, 1e-4, 0.05, usual));
  show("all of these", charged_run(10, 1e-4, 0.025, 2 * usual));
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  Report report("Gases of a thousand grains");
  energy_balances(report, all);
  haff(report, all);
  monopolar(report, all);
  return report.exit_status();
}

const lichtenberg::validation::Program program("gas", validate);

}  // namespace gas_validation
