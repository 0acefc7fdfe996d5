// Known difficult cases of gases of charged grains (docs/validation.md) on a device. These are the rows of
// ../hard_cases_gas.cpp on steps, lists, contacts and sums, with the bounds derived there and in ../gas_cases.hpp.
//
//   device_hard_cases [--host] [SECTION]
//
// --host: runs the device's algorithms on the CPU sequentially. Sections: `to-one-cluster`, `at-rest`, `elastic`,
// `cold`, `cooled`, `lists`, `charges`, `bits`, `too-fast`, `held-forces`, `restitution`.

#include <string_view>

#include "solvers/error.hpp"
#include "src/analysis/gas_clusters.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/note.hpp"
#include "src/theory/restitution.hpp"
#include "tests/grains.hpp"
#include "validation/gas_cases.hpp"
#include "validation/harness.hpp"

using namespace lichtenberg;
using gas_cases::clusters;
using gas_cases::left_over;
using gas_cases::viscoelastic;
using lichtenberg::grains::add_gas;
using lichtenberg::grains::add_pair;
using lichtenberg::grains::charge_alternately;
using lichtenberg::grains::momentum;
using lichtenberg::grains::thermal_momentum;
using namespace lichtenberg::validation;

namespace {

bool on_host = false;

/// Gas that a device advances.
class DeviceGas {
 public:
  explicit DeviceGas(const Scene& scene)
      : gas_(scene),
        device_(on_host ? granular::device::make_host_gas(scene) : granular::device::make_cuda_gas(scene)) {
    load();
  }

  double time() const { return device_->time(); }
  void to(double time) {
    while (this->time() < time) {
      const double end = std::min(time, gas_.stage_end());
      while (this->time() < end) device_->step(end, 100);
      if (this->time() < gas_.stage_end()) continue;
      now().leave_stage();
      load();
    }
  }
  /// Advances one step, but not beyond `time`.
  void step(double time) { device_->step(time); }
  /// Copies the device's state into the host's gas and returns that.
  granular::Gas& now() {
    Checkpoint checkpoint = gas_.save();
    device_->store(checkpoint);
    gas_.restore(checkpoint);
    return gas_;
  }

 private:
  void load() { device_->load(gas_.save(), gas_.law(), gas_.in_elastic_stage(), gas_.stage_begin(), gas_.surface()); }

  granular::Gas gas_;
  std::unique_ptr<granular::device::DeviceGas> device_;
};

void to_one_cluster(Report& report) {
  const Scene scene = gas_cases::to_one_cluster();
  const auto n = static_cast<double>(scene.conductors.size());
  DeviceGas there(scene);
  granular::Gas& start = there.now();
  const double energy = start.energy().total(), thermal = thermal_momentum(start);
  double largest = 0;
  while (largest < n && there.time() < 5000) there.to(there.time() + 100), largest = clusters(there.now()).largest;
  there.to(there.time() + 500);
  granular::Gas& gas = there.now();
  const granular::GasEnergy now = gas.energy();
  report.section(
      fmt::format("{} charged grains cool from T = 10 to rest in one cluster, t = {:g}, {:.2g} steps, {:.2g} of "
                  "contacts",
                  n, there.time(), static_cast<double>(gas.steps), static_cast<double>(gas.contact_steps)));
  report.at_most("residual of the energy balance, fraction of the dissipated energy", left_over(now, energy), 1e-3);
  report.at_least("grains in the largest cluster", clusters(gas).largest, n);
  report.at_most("kinetic energy, of that at the start", now.kinetic / (1.5 * 10 * n), std::nullopt);
  report.at_most("momentum, of the thermal one at the start", momentum(gas.bodies()) / thermal, std::nullopt);
}

void at_rest(Report& report) {
  report.section("13 charged grains cool to rest");
  DeviceGas there(gas_cases::thirteen_grains({.strength = 0.1, .accuracy = 1e-4}));
  const double start = there.now().energy().total();
  double before = INFINITY, rise = 0;
  for (int n = 1; n <= 200; ++n) {
    there.to(0.5 * n);
    const granular::GasEnergy now = there.now().energy();
    const double left = now.kinetic + now.contact + now.potential;
    rise = std::max(rise, left - before);
    before = left;
  }
  report.at_most("largest rise of the energy between two looks", rise, 1e-3);
  report.at_most("residual of the energy balance, fraction of the dissipated energy",
                 left_over(there.now().energy(), start), 1e-3);
  report.at_most("clusters", static_cast<double>(clusters(there.now()).number), 1);
}

void elastic_gas(Report& report) {
  report.section("an elastic gas, dilute: collisions over omega N t / 2");
  const gas_cases::ElasticGas elastic{4000};
  const double time = 20;
  DeviceGas there(elastic.scene(25));
  there.to(1);
  const granular::GasEnergy before = there.now().energy();
  const std::int64_t first = there.now().collisions;
  there.to(1 + time);
  granular::Gas& gas = there.now();
  const granular::GasEnergy after = gas.energy();
  const double expected = elastic.collisions(2 * after.kinetic / (3 * elastic.n), time);
  report.at_most("25 steps a contact: off by", std::abs(static_cast<double>(gas.collisions - first) / expected - 1),
                 elastic.bound(expected));
  report.at_most("  kinetic + stored energy, change over it",
                 std::abs(after.kinetic + after.contact - before.kinetic - before.contact) / before.kinetic,
                 elastic.bound_of_energy(expected));
}

void cold_gas(Report& report) {
  report.section("force errors and a gas that is nearly cold");
  DeviceGas there(gas_cases::cold_gas());
  const std::vector<double> forces = there.now().smooth_forces();
  const double time = 1000, before = there.now().energy().total();
  there.to(time);
  report.at_most(fmt::format("elastic, T = 1e-5, t = {:g}: growth of energy over kinetic", time),
                 std::abs(there.now().energy().total() - before) / gas_cases::kinetic_energy_of_cold_gas(),
                 gas_cases::bound_of_cold_gas(forces, time));
}

void cooled_gas(Report& report) {
  report.section("a charged gas cools from T = 10");
  const int n = 1000;
  DeviceGas there(gas_cases::cooling_gas(n));
  const double thermal = thermal_momentum(there.now()), start = there.now().energy().total();
  const auto temperature = [&] { return 2 * there.now().kinetic_energy() / (3 * n); };
  while (there.time() < 400 && temperature() > 1e-4) there.to(there.time() + 10);
  granular::Gas& gas = there.now();
  // Each force in single precision has a rounding error of 6e-8. Subtracting the mean conserves momentum.
  report.at_most(fmt::format("momentum over thermal momentum, at T = {:.2g}, t = {:.3g}", temperature(), there.time()),
                 momentum(gas.bodies()) / thermal_momentum(gas), std::nullopt);
  report.at_most("  over that at the start", momentum(gas.bodies()) / thermal, 1e-3);
  report.at_most("residual of the energy balance, fraction of the dissipated energy", left_over(gas.energy(), start),
                 1e-3);
}

void lists(Report& report) {
  report.section("every pair that overlaps is a contact");
  DeviceGas there(gas_cases::one_fast_grain());
  gas_cases::Overlaps overlaps;
  for (int n = 0; n < 500; ++n) {
    there.step(1e4);
    overlaps.look(there.now());
  }
  report.at_most(fmt::format("one grain at 1e3 thermal speeds: missed of {:g}", overlaps.seen), overlaps.missed, 0);
}

void charges(Report& report) {
  report.section("charges");
  const auto end = [](double strength, double exchange) {
    Scene scene = viscoelastic(12);
    scene.effects.add(effects::CoulombOptions{.strength = strength, .accuracy = 1e-3});
    scene.effects.add(effects::ChargeExchangeOptions{.strength = exchange});
    scene.mechanics.step = 0.02;
    add_gas(scene, 500, 11.9, 1);
    DeviceGas there(scene);
    there.to(5);
    return there.now().bodies();
  };
  const Bodies one = end(1, 0.25);
  double sum = 0;
  for (const double q : one.charge) sum += q;
  report.at_most("sum of 500 charges that were exchanged, as a number", std::abs(sum), 0);
  report.at_least("(K, Q) and (4 K, Q / 2): the same bits", end(4, 0.125).position == one.position, 1);
}

void bits(Report& report) {
  report.section("the same bits");
  Scene scene = viscoelastic(12);
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-3});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.1});
  add_gas(scene, 500, 11.9, 1);
  charge_alternately(scene, 0.2);
  const auto end = [&] {
    DeviceGas there(scene);
    there.to(5);
    return there.now().save();
  };
  const Checkpoint one = end(), other = end();
  report.at_least("run again", one.reals == other.reals && one.integers == other.integers, 1);
}

void too_fast(Report& report) {
  report.section("grains that would fly through each other (v > 21.1)");
  bool refused = false;
  try {
    Scene scene = viscoelastic(10, 0);
    add_pair(scene, 25, 0.1);
    DeviceGas there(scene);
    there.to(1);
  } catch (const Failure&) {
    refused = true;
  }
  report.at_least("elastic, v = 25: refused", refused, 1);
}

struct Change {
  double found, rounding;
};

/// Runs a vibrating bound pair for fifty periods. Returns the change of its conserved energy over K q^2 times the
/// overlap, and the rounding bound of five standard deviations. Each contact substep's dissipation is recorded in whole
/// quanta, with an rms error of 1 / sqrt(12) quantum.
Change change_of(const gas_cases::BoundPair& pair, double dissipative) {
  const double period = pair.period();
  Scene scene = pair.scene(dissipative, {.accuracy = 1e-5});
  scene.mechanics.step = 0.25 * period;
  DeviceGas there(scene);
  there.to(0.25 * period);
  const double start = there.now().energy().total();
  there.to(50 * period);
  granular::Gas& gas = there.now();
  const double quanta = 5 * std::sqrt(static_cast<double>(gas.contact_steps) / 12),
               depth = pair.attraction * pair.overlap();
  return {std::abs(gas.energy().total() - start) / depth, quanta * granular::device::energy_quantum(2) / depth};
}

void held_forces(Report& report) {
  report.section("a bound pair followed for 50 of its periods in steps of a quarter: change of the energy");
  for (const double attraction : {0.1, 1e-3}) {
    const gas_cases::BoundPair pair{attraction};
    report.at_most(fmt::format("K q^2 = {:g}, elastic", attraction), change_of(pair, 0).found, pair.bound());
    const Change damped = change_of(pair, 27.7);
    report.at_most("  damped, with the recorded dissipation", damped.found, pair.bound() + damped.rounding);
  }
}

void restitutions(Report& report) {
  report.section("error of restitution by speed, isolated central collisions of a dilute neutral gas");
  const int n = 20000;
  const double edge = std::cbrt(n / 0.002);
  Scene scene = viscoelastic(edge);
  add_gas(scene, n, edge, 1);
  DeviceGas there(scene);
  there.to(20);
  const granular::RestitutionCheck& found = there.now().restitution;
  // Bound: 1e-3 for rotating pairs, plus twice the error of restitution with 45 substeps per contact.
  for (int k = 0; k < granular::RestitutionCheck::decades; ++k)
    if (const auto& decade = found.by_speed()[k]; decade.collisions > 0)
      report.at_most(fmt::format("speed 1e{}, {} collisions, worst", granular::RestitutionCheck::first_decade + k,
                                 decade.collisions),
                     decade.worst, 2e-3);
}

}  // namespace

int main(int argc, char** argv) {
  std::string_view section;
  for (int k = 1; k < argc; ++k)
    if (argv[k] == std::string_view("--host"))
      on_host = true;
    else
      section = argv[k];
  Report report("Hard cases of gases of charged grains, on a device");
  const auto run = [&](std::string_view name, void (*rows)(Report&)) {
    if (section.empty() || section == name) rows(report);
  };
  run("too-fast", too_fast);
  run("lists", lists);
  run("charges", charges);
  run("bits", bits);
  run("held-forces", held_forces);
  run("at-rest", at_rest);
  run("elastic", elastic_gas);
  run("restitution", restitutions);
  run("cold", cold_gas);
  run("cooled", cooled_gas);
  run("to-one-cluster", to_one_cluster);
  return report.exit_status();
}
