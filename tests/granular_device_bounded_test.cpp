// Tests of charged gases on a device in domains that are not periodic, executed by the CPU item by item, against
// Multirate.

#include <doctest/doctest.h>

#include <cmath>

#include "solvers/error.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "src/granular/device/gas.hpp"
#include "tests/device_gases.hpp"
#include "tests/message.hpp"
#include "tests/rough_grains.hpp"

namespace granular_device_bounded_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;
using doctest::Approx;

namespace {

/// Returns the gas of a scene, also of one between sides without walls.
std::unique_ptr<granular::device::DeviceGas> loaded_between_sides(const Scene& scene, const Checkpoint& from) {
  using Host = parallel::HostExecutor;
  const grains::Run cpu(scene);
  std::unique_ptr<granular::device::DeviceGas> device =
      std::make_unique<granular::device::GasImpl<Host>>(std::make_unique<Host>(), granular::device::gas_options(scene));
  device->load(from, cpu.gas.law(), false, 0, cpu.gas.surface());
  return device;
}

void unbound(Scene& scene) {
  for (DomainSide& side : scene.domain.sides) side.periodic = false;
  scene.domain.open = true;
}

/// A cloud of equal charges, which grows to several times its size.
Scene exploding(double accuracy) {
  Scene scene = gas(60, 7, 4);
  unbound(scene);
  for (Conductor& grain : scene.conductors) grain.charge = 1;
  scene.effects.add(effects::CoulombOptions{.accuracy = accuracy});
  return scene;
}

double extent(const Checkpoint& checkpoint, int axis) {
  double low = INFINITY, high = -INFINITY;
  const std::vector<double>& position = checkpoint.reals.at("position");
  for (std::size_t k = axis; k < position.size(); k += 3)
    low = std::min(low, position[k]), high = std::max(high, position[k]);
  return high - low;
}

}  // namespace

// Two pairs of grains: one meets inside of the cube, the same pair shifted by 40 edges meets outside. Grains that are
// far apart have neighbours in common only in the periodic search.
TEST_CASE("device, unbounded: grains leave the domain and collide outside as inside") {
  Scene scene = gas(0, 10, 1);
  unbound(scene);
  grains::add(scene, {4, 5, 5}, {1, 0, 0});
  grains::add(scene, {6, 5.3, 5}, {-1, 0, 0});
  grains::add(scene, {404.05, 5, 5}, {0, 0, 0});  // at the first grain, 20 edges of the search apart
  for (const Vec3 shift : {Vec3{}, Vec3{-400, 400, 0}}) {
    for (Conductor& grain : scene.conductors) grain.position += shift;
    auto [cpu, start, device] = OnBoth(scene);
    while (cpu.gas.time() < 30) cpu.step(30), device->step(30);
    const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
    CHECK(cpu.gas.collisions == 1);
    CHECK(found.integers == expected.integers);
    CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-9);
    CHECK(found.reals.at("position")[3] - shift.x > 9);
  }
}

TEST_CASE("device, unbounded: steps of an exploding charged cloud equal the CPU's") {
  Scene scene = exploding(1e-6);
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  auto [cpu, start, device] = OnBoth(scene);
  CHECK(device->potential_energy() == Approx(cpu.gas.energy().potential).epsilon(1e-5));
  for (int n = 0; n < 60; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(cpu.gas.collisions > 3);
  CHECK(extent(found, 0) > 1.3 * extent(start, 0));
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(found.integers.at("image") == expected.integers.at("image"));
  // Forces are about 10, with an error of 1e-6, over a time of 1, and collisions amplify their effect tenfold.
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 3e-4);
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 3e-4);
  CHECK(sum(found.reals.at("charge")) == 60);
  cpu.gas.restore(found);
  CHECK(cpu.gas.energy().potential == Approx(device->potential_energy()).epsilon(1e-5));
}

// The CPU sums few charges by pairs. With the distance r the energy is q^2 / r.
TEST_CASE("device, unbounded: one charge flies, two move apart by Coulomb's law") {
  for (const int count : {1, 2}) {
    Scene scene = gas(0, 10, 1);
    unbound(scene);
    grains::add(scene, {4, 5, 5}, {0.5, 0, 0}, 2);
    if (count > 1) grains::add(scene, {6, 5, 5}, {0.5, 0, 0}, 2);
    scene.effects.add(effects::CoulombOptions{.accuracy = 1e-5});
    auto [cpu, start, device] = OnBoth(scene);
    for (int n = 0; n < 80; ++n) cpu.step(10), device->step(10);
    const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
    REQUIRE(device->time() == Approx(cpu.gas.time()));
    // An error of 1e-5 of forces of 1, over a time of 4.
    CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 8e-5);
    CHECK(device->potential_energy() == Approx(count > 1 ? 4 / extent(found, 0) : 0).epsilon(1e-4));
  }
}

TEST_CASE("device, unbounded: resumed runs and batches have equal bits" * doctest::test_suite("long")) {
  const Scene scene = exploding(1e-3);
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const Device one = loaded(scene, cpu, start), many = loaded(scene, cpu, start);
  std::vector<Checkpoint> middle;
  for (int n = 0; n < 60; ++n) {
    if (n % 30 == 3) middle.push_back(stored(*one, start));
    one->step(10);
  }
  for (const int n : {1, 7, 40, 12}) many->step(10, n);
  const Checkpoint a = stored(*one, start), b = stored(*many, start);
  CHECK(extent(a, 1) > 1.3 * extent(start, 1));  // four lengths of the mesh
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
  for (std::size_t k = 0; k < middle.size(); ++k) {
    const auto resumed = granular::device::make_host_gas(scene);
    resumed->load(middle[k], cpu.gas.law(), false);
    resumed->step(10, 57 - 30 * static_cast<int>(k));
    const Checkpoint c = stored(*resumed, start);
    CHECK(a.reals == c.reals);
    CHECK(a.integers == c.integers);
  }
}

TEST_CASE("device, open and grounded sides: steps equal the CPU's") {
  for (const bool grounded : {false, true}) {
    CAPTURE(grounded);
    Scene scene = gas(80, 7, 2);
    grains::add_walls(scene, {2}, {.stiffness = 600, .damping = 20});
    scene.domain.sides[4].electrode = grounded;
    for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
    scene.effects.add(effects::CoulombOptions{.accuracy = 1e-6});
    scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
    if (grounded)  // transfers that depend on earlier ones
      *scene.effects.find<effects::ChargeExchangeOptions>() = {.model = effects::ExchangeModel::polarization,
                                                               .strength = 0.05,
                                                               .feedback = -0.2,
                                                               .field = Coordinates{{0, 0, 1}, 3}};
    grains::Run cpu(scene);
    const Checkpoint start = cpu.gas.save();
    const auto device = loaded_between_sides(scene, start), many = loaded_between_sides(scene, start),
               resumed = loaded_between_sides(scene, start);
    CHECK(device->potential_energy() == Approx(cpu.gas.energy().potential).epsilon(1e-5));
    for (int n = 0; n < 25; ++n) {
      if (n == 11) resumed->load(stored(*device, start), cpu.gas.law(), false, 0, cpu.gas.surface());
      cpu.step(10), device->step(10);
    }
    const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
    CHECK(cpu.gas.collisions > 10);
    CHECK(found.integers.at("counters") == expected.integers.at("counters"));
    CHECK(found.integers.at("image") == expected.integers.at("image"));
    CHECK(found.integers.at("effects.charge_exchange.counters") ==
          expected.integers.at("effects.charge_exchange.counters"));
    // As in a periodic domain (granular_device_test.cpp).
    const double most = std::sqrt(2) * 1e-6 * 0.4 * 10 * 3;
    CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < most);
    CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < most);
    CHECK(sum(found.reals.at("charge")) == sum(start.reals.at("charge")));
    CHECK(found.reals.at("book")[1] == Approx(expected.reals.at("book")[1]).epsilon(1e-4));
    for (const int n : {4, 1, 20}) many->step(10, n);
    resumed->step(10, 14);
    for (const auto& other : {many.get(), resumed.get()}) {
      const Checkpoint same = stored(*other, start);
      CHECK(same.reals == found.reals);
      CHECK(same.integers == found.integers);
    }
  }
}

TEST_CASE("device, open sides: a charge beyond a side ends the run with its name") {
  Scene scene = gas(20, 6, 0.1);
  scene.domain.sides[2] = scene.domain.sides[3] = {};
  for (Conductor& grain : scene.conductors) grain.charge = 0.1;
  scene.conductors[7].velocity.y = 30;
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-3});
  const grains::Run cpu(scene);
  const auto device = loaded_between_sides(scene, cpu.gas.save());
  const std::string message = message_of([&] {
    for (int n = 0; n < 100; ++n) device->step(10);
  });
  CHECK_MESSAGE(message.find("a charge has left the domain through the top side") != std::string::npos, message);
}

TEST_CASE("device, not periodic: dipoles that it lacks are refused") {
  const auto sentence = [](const Scene& scene) {
    return message_of([&] { granular::device::check_scene(scene, granular::device::Target::host); });
  };
  Scene scene = polarized_gas();
  unbound(scene);
  CHECK(sentence(scene).find("does not support effects.induced_dipoles in an unbounded domain") != std::string::npos);
  scene = polarized_gas();
  grains::add_walls(scene, {0});
  CHECK(sentence(scene) == "");
  scene.domain.sides[1].electrode = true;
  CHECK(sentence(scene).find("does not support effects.induced_dipoles between grounded sides") != std::string::npos);
}

}  // namespace granular_device_bounded_test
