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

/// Runs a gas for some outer steps on a number of ranks, and returns its checkpoint.
Checkpoint after_steps(const Scene& scene, const Checkpoint& start, int ranks, int steps) {
  granular::Gas gas(scene);
  gas.restore(start);
  const auto device = granular::device::make_host_gas(scene, ranks);
  device->load(start, gas.law(), false, 0, gas.surface());
  device->step(1e3, steps);
  CHECK(device->counts().lists > 2);
  Checkpoint end = start;
  device->store(end);
  return end;
}
void check_same_on_ranks(const Scene& scene, int steps) {
  const Checkpoint start = granular::Gas(scene).save();
  const Checkpoint one = after_steps(scene, start, 1, steps);
  CHECK(one.integers.at("counters").at(2) > 10);
  for (const int ranks : {2, 3}) {
    CAPTURE(ranks);
    const Checkpoint several = after_steps(scene, start, ranks, steps);
    for (const auto& [name, values] : one.reals) {
      CAPTURE(name);
      CHECK(values == several.reals.at(name));
    }
    for (const auto& [name, values] : one.integers) {
      CAPTURE(name);
      CHECK(values == several.integers.at(name));
    }
  }
}

}  // namespace

TEST_CASE("ranks: a neutral gas has the same bits on one, two and three") {
  Scene scene = gas(2500, 24, 3);
  scene.mechanics.step = 0.05;
  check_same_on_ranks(scene, 60);
}

TEST_CASE("ranks: a charged gas has the same bits on one, two and three") {
  Scene scene = gas(800, 16, 2);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-4});
  scene.mechanics.step = 0.01;
  scene.mechanics.contact_steps = 10;
  check_same_on_ranks(scene, 60);
}

}  // namespace granular_device_ranks_test
