// Tests of external fields and of ordered charge exchange on a device, executed by the CPU item by item, against
// Multirate.

#include <doctest/doctest.h>

#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/uniform_field.hpp"
#include "src/granular/device/device.hpp"
#include "tests/device_gases.hpp"
#include "tests/message.hpp"

namespace granular_device_exchange_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;
using effects::ChargeExchangeOptions;
using effects::ExchangeModel;

namespace {

constexpr double quantum = 0x1p-35;  // of the prefactor 0.05

/// A dense gas of grains of several radii without Coulomb forces, so that device and CPU differ by rounding only.
Scene exchanging(const ChargeExchangeOptions& exchange) {
  Scene scene = gas(100, 6.6, 5);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i)
    scene.conductors[i].radius = 0.4 + 0.1 * static_cast<double>(i % 2);
  scene.effects.add(exchange);
  scene.effects.find<ChargeExchangeOptions>()->strength = 0.05;
  for (std::size_t i = 0; i < scene.conductors.size(); ++i)
    scene.effects.find<ChargeExchangeOptions>()->affinity.push_back(0.1 * static_cast<double>(i % 5));
  return scene;
}

}  // namespace

TEST_CASE("device, uniform field: 40 steps of a charged gas equal the CPU's") {
  Scene scene = charged_gas(100, 8, 5);
  scene.effects.add(effects::UniformFieldOptions{.field = {{3, 0, -8}, 3}});
  auto [cpu, start, device] = OnBoth(scene);
  CHECK(device->potential_energy() == doctest::Approx(cpu.gas.energy().potential).epsilon(1e-5));
  for (int n = 0; n < 40; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 20);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(found.integers.at("image") == expected.integers.at("image"));
  // As without the field (granular_device_test.cpp).
  const double most = std::sqrt(2) * 1e-6 * 0.4 * 10 * 3;
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < most);
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < most);
  CHECK(sum(found.reals.at("charge")) == 0);
  // The energy by exchange includes that of the charges in the field.
  CHECK(found.reals.at("book")[1] == doctest::Approx(expected.reals.at("book")[1]).epsilon(1e-4));
  const double by_device = device->potential_energy();
  cpu.gas.restore(found);
  CHECK(cpu.gas.energy().potential == doctest::Approx(by_device).epsilon(1e-5));
}

// Charges without other forces: x = q E t^2 / 2 with m = 1, across periodic sides, and the energy -q E.r.
TEST_CASE("device, uniform field alone: charges fall, and energy is conserved") {
  Scene scene = grains::cube(20);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  scene.effects.add(effects::UniformFieldOptions{.field = {{0.5, -1, 0}, 3}});
  grains::add(scene, {5, 5, 5}, {}, 2);
  grains::add(scene, {5, 5, 12}, {}, 0);
  auto [cpu, start, device] = OnBoth(scene);
  const double before = device->potential_energy();
  CHECK(before == doctest::Approx(-2 * (0.5 * 5 - 5)));
  while (device->time() < 8) device->step(8);
  const Checkpoint found = stored(*device, start);
  const auto path = [&](int k) {
    return found.reals.at("position")[k] + 20 * static_cast<double>(found.integers.at("image")[k]) - 5;
  };
  // Forces and energies are multiples of 2^-44 of the largest ones, or of 64 times it.
  CHECK(path(0) == doctest::Approx(32).epsilon(1e-10));
  CHECK(path(1) == doctest::Approx(-64).epsilon(1e-10));
  CHECK(found.reals.at("position")[5] == 12);
  CHECK(device->potential_energy() - before == doctest::Approx(-(32 + 2 * 64)).epsilon(1e-9));
}

TEST_CASE("device, exchange with a sign: charges and counters equal the CPU's") {
  for (const ExchangeModel model : {ExchangeModel::size, ExchangeModel::material, ExchangeModel::polarization})
    for (const double feedback : {-0.4, 0.0, 3.0}) {
      CAPTURE(name_of(model));
      CAPTURE(feedback);
      ChargeExchangeOptions exchange{.model = model, .feedback = feedback, .memory = 6};
      if (model == ExchangeModel::polarization) exchange.field = Coordinates{{0.3, 0, 1}, 3};
      if (feedback > 0) exchange.capacity = 0.02;
      const Scene scene = exchanging(exchange);
      auto [cpu, start, device] = OnBoth(scene);
      for (int n = 0; n < 25; ++n) cpu.step(10), device->step(10);
      const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
      REQUIRE(cpu.gas.collisions > 60);
      CHECK(found.integers == expected.integers);
      if (feedback > 0) CHECK(expected.integers.at("effects.charge_exchange.counters")[2] > 0);
      // Impact speeds differ by the amplified rounding of positions, and charges by that or by one quantum.
      CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) < 1e-8 + quantum);
      CHECK(std::ranges::max(expected.reals.at("charge")) > 1e-3);
      CHECK(sum(found.reals.at("charge")) == 0);
      for (const double charge : found.reals.at("charge")) REQUIRE(std::remainder(charge, quantum) == 0);
    }
}

TEST_CASE("device, exchange by patches: charges are the CPU's, in whole patches") {
  const Scene scene = exchanging({.model = ExchangeModel::patches, .exponent = 0.4, .patches = 12});
  auto [cpu, start, device] = OnBoth(scene);
  for (int n = 0; n < 25; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 60);
  CHECK(found.integers == expected.integers);
  CHECK(found.reals.at("charge") == expected.reals.at("charge"));
  CHECK(std::ranges::max(expected.reals.at("charge")) > 0.05);
  const double patch = effects::whole_quanta(0.05, quantum);
  for (const double charge : found.reals.at("charge")) REQUIRE(std::remainder(charge, patch) == 0);
}

// In one substep the middle grain touches all six others. Each transfer depends on those before it.
TEST_CASE("device, exchange with a sign: six contacts at once act in order") {
  Scene scene = grains::cube(10);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  scene.effects.add(ChargeExchangeOptions{
      .model = ExchangeModel::size, .strength = 0.25, .exponent = 0, .feedback = -1.5, .memory = 2});
  for (int k = 0; k < 7; ++k) {
    const int axis = k < 3 ? k : k - 4, sign = k < 3 ? -1 : 1;
    Vec3 at{5, 5, 5}, v{};
    if (k != 3) at[axis] += 1.001 * sign, v[axis] = -sign;
    grains::add(scene, at, v, 0.25 * (k - 3));
  }
  scene.conductors[3].radius = 0.5 - 0x1p-12, scene.conductors[5].radius = 0.5 + 0x1p-12;
  auto [cpu, start, device] = OnBoth(scene);
  cpu.step(10), device->step(10);
  REQUIRE(cpu.gas.collisions == 6);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(found.integers == expected.integers);
  CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) <= 0x1p-32);
  CHECK(std::abs(expected.reals.at("charge")[3]) > 0.02);
}

TEST_CASE("device, exchange with a sign: batches and resumed runs have same bits") {
  Scene scene = charged_gas(60, 7, 3);
  *scene.effects.find<ChargeExchangeOptions>() = {
      .model = ExchangeModel::polarization, .strength = 0.05, .feedback = 0.5, .memory = 4, .capacity = 1.1};
  scene.effects.find<ChargeExchangeOptions>()->field = Coordinates{{0, 0, 1}, 3};
  scene.effects.add(effects::UniformFieldOptions{.field = {{0, 0, 1}, 3}});
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto one = loaded(scene, cpu, start), many = loaded(scene, cpu, start);
  Checkpoint middle;
  for (int n = 0; n < 60; ++n) {
    if (n == 23) middle = stored(*one, start);
    one->step(10);
  }
  for (const int n : {1, 7, 40, 12}) many->step(10, n);
  const auto resumed = loaded(scene, cpu, middle);
  resumed->step(10, 37);
  const Checkpoint a = stored(*one, start), b = stored(*many, start), c = stored(*resumed, start);
  CHECK(a.integers.at("effects.charge_exchange.counters")[1] > 10);
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
  CHECK(a.reals == c.reals);
  CHECK(a.integers == c.integers);
}

TEST_CASE("device, exchange: models with more transfers are refused") {
  const auto sentence = [](const ChargeExchangeOptions& exchange) {
    Scene scene = charged_gas(10, 8, 1);
    *scene.effects.find<ChargeExchangeOptions>() = exchange;
    return message_of([&] { granular::device::check_scene(scene, granular::device::Target::host); });
  };
  CHECK(sentence({.model = ExchangeModel::contact_area}).find("effects.charge_exchange.model = \"contact-area\"") !=
        std::string::npos);
  CHECK(sentence({.each_step = true}).find("effects.charge_exchange.each_step") != std::string::npos);
  CHECK(sentence({.capacity = 1, .over_capacity = effects::OverCapacity::reset})
            .find("does not support effects.charge_exchange.over_capacity = \"reset\", which does not conserve") !=
        std::string::npos);
}

}  // namespace granular_device_exchange_test
