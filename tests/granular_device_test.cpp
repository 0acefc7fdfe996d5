// The device's steps of a gas, run by the CPU item after item, against Multirate's.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/granular_motion.hpp"
#include "tests/grains.hpp"

using namespace lichtenberg;

namespace {

Scene gas(int count, double edge, double temperature) {
  Scene scene = grains::cube(edge);
  grains::add_gas(scene, count, edge - 1.1, temperature);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  return scene;
}

Scene charged_gas(int count, double edge, double temperature) {
  Scene scene = gas(count, edge, temperature);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-6});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  return scene;
}

/// The device's state as a gas.
Checkpoint stored(const granular::device::DeviceGas& device, Checkpoint checkpoint) {
  device.store(checkpoint);
  return checkpoint;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  REQUIRE(a.size() == b.size());
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

}  // namespace

TEST_CASE("a step of a neutral gas on the device is the CPU's to rounding") {
  for (const bool linear : {false, true}) {
    Scene scene = gas(100, 8, 5);
    if (linear) {
      scene.effects = {};
      scene.effects.add(effects::LinearContactOptions{.stiffness = 278.6});
    }
    grains::Run cpu(scene);
    const Checkpoint start = cpu.gas.save();
    const auto device = granular::device::make_host_gas(scene);
    device->load(start, cpu.gas.law(), false);
    for (int n = 0; n < 60; ++n) {
      cpu.step(10);
      device->step(10);
      REQUIRE(device->time() == cpu.gas.time());
    }
    const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
    REQUIRE(cpu.gas.collisions > 30);
    CHECK(found.integers.at("counters") == expected.integers.at("counters"));
    CHECK(found.integers.at("contact_pairs") == expected.integers.at("contact_pairs"));
    CHECK(found.integers.at("image") == expected.integers.at("image"));
    // The same operations, which compilers contract as they like: rounding, of which each collision makes ten times as
    // much.
    CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-8);
    CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 1e-8);
    CHECK(largest_difference(found.reals.at("contact_touches"), expected.reals.at("contact_touches")) < 1e-8);
    // dissipated energy in quanta of 2^-32, a few thousand of them rounded
    CHECK(found.reals.at("book")[0] == doctest::Approx(expected.reals.at("book")[0]).epsilon(1e-9));
    CHECK(found.reals.at("book")[4] == doctest::Approx(expected.reals.at("book")[4]).epsilon(1e-9));
  }
}

TEST_CASE("a step of a charged gas on the device is the CPU's to the precision of its forces") {
  const Scene scene = charged_gas(100, 8, 5);
  grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto device = granular::device::make_host_gas(scene);
  device->load(start, cpu.gas.law(), false);
  const double energy = cpu.gas.energy().total();
  for (int n = 0; n < 40; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 20);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(found.integers.at("contact_pairs") == expected.integers.at("contact_pairs"));
  CHECK(found.integers.at("effects.charge_exchange.collisions") ==
        expected.integers.at("effects.charge_exchange.collisions"));
  CHECK(found.integers.at("effects.charge_exchange.counters") ==
        expected.integers.at("effects.charge_exchange.counters"));
  // Forces of about 1, each to 1e-6 of the exact ones, over .4; collisions make some ten times more of it.
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-5);
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 1e-5);
  CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) < 1e-5);
  double charge = 0;
  for (const double q : found.reals.at("charge")) charge += q;
  CHECK(charge == 0);
  CHECK(found.reals.at("book")[1] == doctest::Approx(expected.reals.at("book")[1]).epsilon(1e-4));
  // The book closes on what the device has done as it does on the CPU.
  const double off = cpu.gas.energy().total() - energy;
  cpu.gas.restore(found);
  CHECK(cpu.gas.energy().total() - energy == doctest::Approx(off).epsilon(1e-2));
}

TEST_CASE("a gas goes on bit for bit from a device's checkpoint, wherever it was made") {
  const Scene scene = charged_gas(60, 7, 3);
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto whole = granular::device::make_host_gas(scene);
  whole->load(start, cpu.gas.law(), false);
  Checkpoint middle;
  for (int n = 0; n < 50; ++n) {
    if (n == 23) middle = stored(*whole, start);
    whole->step(10);
  }
  const auto resumed = granular::device::make_host_gas(scene);
  resumed->load(middle, cpu.gas.law(), false);
  for (int n = 23; n < 50; ++n) resumed->step(10);
  const Checkpoint a = stored(*whole, start), b = stored(*resumed, start);
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
}

TEST_CASE("a grain that two others touch in the same step gets the random numbers that it has on the CPU") {
  Scene scene = grains::cube(8);
  for (const double x : {4.0, 2.9, 5.1}) grains::add(scene, {x, 4, 4}, {4 - x, 0, 0});
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto device = granular::device::make_host_gas(scene);
  device->load(start, cpu.gas.law(), false);
  for (int n = 0; n < 4; ++n) cpu.step(10), device->step(10);
  REQUIRE(cpu.gas.collisions == 2);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(expected.integers.at("effects.charge_exchange.collisions") == std::vector<std::int64_t>{2, 1, 1});
  CHECK(found.integers == expected.integers);
  CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) < 1e-10);
  CHECK(std::abs(expected.reals.at("charge")[1]) > 1e-3);
}

TEST_CASE("no charge moves while a gas is mixed") {
  const Scene scene = charged_gas(60, 7, 3);
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto device = granular::device::make_host_gas(scene);
  device->load(start, elastic(cpu.gas.law(), 1), true);
  for (int n = 0; n < 40; ++n) device->step(10);
  const Checkpoint found = stored(*device, start);
  CHECK(found.integers.at("counters")[2] > 10);
  CHECK(found.reals.at("charge") == start.reals.at("charge"));
  CHECK(std::abs(found.reals.at("book")[0]) < 1e-9);
}

TEST_CASE("a device says what it lacks") {
  const auto sentence = [](const Scene& scene) {
    try {
      granular::device::check_scene(scene);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  Scene scene = charged_gas(10, 8, 1);
  CHECK(sentence(scene).empty());
  scene.effects.find<effects::ChargeExchangeOptions>()->capacity = 1;
  CHECK(sentence(scene).find("has no effects.charge_exchange.capacity") != std::string::npos);
  scene = charged_gas(10, 8, 1);
  scene.effects.find<effects::CoulombOptions>()->accuracy = 1e-8;
  CHECK(sentence(scene).find("single precision reaches 1e-6") != std::string::npos);
  scene = gas(10, 8, 1);
  scene.effects.add<effects::GasDragOptions>();
  CHECK(sentence(scene).find("has no effects.gas_drag") != std::string::npos);
  scene = gas(10, 8, 1);
  scene.mechanics.integrator = Integrator::verlet;
  CHECK(sentence(scene).find("mechanics.integrator = \"verlet\"") != std::string::npos);
#ifndef LICHTENBERG_WITH_CUDA
  CHECK_THROWS_AS(granular::device::make_cuda_gas(gas(10, 8, 1)), InputError);
#endif
}

TEST_CASE(
    "a motion on a device shows what the CPU's does, through stages, and either goes on from the other's checkpoint") {
  Scene scene = charged_gas(60, 7, 3);
  scene.stages = {{.duration = 0.3, .elastic = true, .stiffness = 10, .temperature = 2}};
  scene.stop.time = 1;
  scene.output.every = 0.25;
  GranularMotion cpu(scene), there(scene, granular::device::make_host_gas(scene));
  const auto never = [] { return false; };
  cpu.advance_to(0.5, never);
  there.advance_to(0.5, never);
  REQUIRE(there.time() == cpu.time());
  const Frame expected = cpu.frame(), found = there.frame();
  CHECK(largest_difference(found.reals("position"), expected.reals("position")) < 1e-5);
  CHECK(largest_difference(found.reals("charge"), expected.reals("charge")) < 1e-6);
  CHECK(*found.number("collisions") == *expected.number("collisions"));
  GranularMotion here(scene), over(scene, granular::device::make_host_gas(scene));
  here.restore(there.checkpoint());
  over.restore(cpu.checkpoint());
  for (GranularMotion* motion : {&cpu, &there, &here, &over}) motion->advance_to(0.75, never);
  for (GranularMotion* motion : {&there, &here, &over}) {
    CHECK(largest_difference(motion->frame().reals("position"), cpu.frame().reals("position")) < 1e-4);
  }
}
