// Tests of a gas on several devices: threads of the CPU execute the kernels of the ranks.
#include <doctest/doctest.h>

#include <atomic>

#include "src/granular/device/device.hpp"
#include "src/granular/gas.hpp"
#include "tests/device_gases.hpp"

namespace granular_device_ranks_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;

namespace {

/// Box of which each rank keeps a part up to date: `layers` x 5 x 5 grains on a cubic lattice that drifts along x. All
/// grains touch their neighbours, so that forces pass from rank to rank along rows of contacts in each substep.
Scene long_lattice(int layers) {
  constexpr double spacing = 0.99, drift = 4;
  Scene scene = gas(0, 1, 1);
  scene.domain.size = {layers * spacing, 5 * spacing, 5 * spacing};
  Random random({.seed = 1, .purpose = RandomPurpose::population});
  for (int i = 0; i < 25 * layers; ++i) {
    const Vec3 cell = {static_cast<double>(i / 25), static_cast<double>(i / 5 % 5), static_cast<double>(i % 5)};
    const Vec3 noise = 0.1 * Vec3{random.normal(), random.normal(), random.normal()};
    grains::add(scene, spacing * cell + Vec3{0.2, 0.2, 0.2}, Vec3{drift, 0, 0} + noise);
  }
  return scene;
}

/// Runs a gas for some outer steps on a number of ranks, and returns its checkpoint.
Checkpoint after_steps(const Scene& scene, const Checkpoint& start, int ranks, int steps) {
  granular::Gas gas(scene);
  gas.restore(start);
  const auto device = granular::device::make_host_gas(scene, ranks);
  device->load(start, gas.law(), false, 0, gas.surface());
  device->step(1e3, steps);
  CHECK(device->counts().lists > 1);
  Checkpoint end = start;
  device->store(end);
  return end;
}
void check_equal(const Checkpoint& one, const Checkpoint& other) {
  for (const auto& [name, values] : one.reals) {
    CAPTURE(name);
    CHECK(values == other.reals.at(name));
  }
  for (const auto& [name, values] : one.integers) {
    CAPTURE(name);
    CHECK(values == other.integers.at(name));
  }
}
void check_same_on_ranks(const Scene& scene, int steps, int most_ranks = 3) {
  const Checkpoint start = granular::Gas(scene).save();
  const Checkpoint one = after_steps(scene, start, 1, steps);
  CHECK(one.integers.at("counters").at(2) > 10);
  for (int ranks = 2; ranks <= most_ranks; ++ranks) {
    CAPTURE(ranks);
    check_equal(one, after_steps(scene, start, ranks, steps));
  }
}
Scene exchanging_gas() {
  Scene scene = gas(1000, 16, 3);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 0.2 : -0.2;
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-4});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  scene.mechanics.step = 0.02;
  scene.mechanics.contact_steps = 10;
  return scene;
}

}  // namespace

TEST_CASE("ranks: a gas that exchanges charge has equal bits on one and two") {
  check_same_on_ranks(exchanging_gas(), 15, 2);
}

TEST_CASE("ranks: rows of contacts across two have the same bits") {
  Scene scene = long_lattice(24);
  scene.mechanics.step = 0.002;
  check_same_on_ranks(scene, 90, 2);
}

TEST_CASE("ranks: a neutral gas has the same bits on one, two and three" * doctest::test_suite("long")) {
  Scene scene = gas(2500, 24, 3);
  scene.mechanics.step = 0.05;
  check_same_on_ranks(scene, 60);
}

TEST_CASE("ranks: a charged gas has the same bits on one, two and three" * doctest::test_suite("long")) {
  Scene scene = gas(800, 16, 2);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-4});
  scene.mechanics.step = 0.01;
  scene.mechanics.contact_steps = 10;
  check_same_on_ranks(scene, 60);
}

TEST_CASE("ranks: a gas that exchanges charge has equal bits on one, two and three" * doctest::test_suite("long")) {
  const Scene scene = exchanging_gas();
  check_same_on_ranks(scene, 30);
  CHECK(after_steps(scene, granular::Gas(scene).save(), 2, 30).integers.at("effects.charge_exchange.counters").at(1) >
        20);
}

TEST_CASE("ranks: a run that resumes on other numbers of ranks has the same bits" * doctest::test_suite("long")) {
  const Scene scene = exchanging_gas();
  const Checkpoint start = granular::Gas(scene).save(), middle = after_steps(scene, start, 1, 20);
  const Checkpoint end = after_steps(scene, middle, 1, 20);
  check_equal(end, after_steps(scene, after_steps(scene, start, 3, 20), 2, 20));
}

TEST_CASE("ranks: rows of contacts across three have the same bits" * doctest::test_suite("long")) {
  Scene scene = long_lattice(60);
  scene.mechanics.step = 0.002;
  check_same_on_ranks(scene, 90);
}

}  // namespace granular_device_ranks_test
