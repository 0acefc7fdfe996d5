// Tests of the added force of yukawa.hpp in a gas on a device, by the host executor and, if available, by CUDA.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>

#include "solvers/error.hpp"
#include "src/granular/device/device.hpp"
#include "tests/extension/yukawa.hpp"

namespace extend_pair_force_device {

using namespace lichtenberg;

TEST_CASE("user-defined pair force: device steps equal the CPU's to rounding") {
  Scene scene = yukawa_gas();
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  grains::Run cpu(scene);
  const auto device = granular::device::make_host_gas(scene);
  device->load(cpu.gas.save(), cpu.gas.law(), false);
  CHECK(device->potential_energy() == doctest::Approx(cpu.gas.energy().potential).epsilon(1e-10));
  for (int n = 0; n < 60; ++n) cpu.step(10), device->step(10);
  REQUIRE(cpu.gas.collisions > 3);
  Checkpoint found = cpu.gas.save();
  device->store(found);
  const Checkpoint expected = cpu.gas.save();
  for (std::size_t k = 0; k < 180; ++k)
    CHECK(std::abs(found.reals.at("momentum")[k] - expected.reals.at("momentum")[k]) < 1e-8);
  CHECK(device->potential_energy() == doctest::Approx(cpu.gas.energy().potential).epsilon(1e-8));
  CHECK(found.reals.at("book")[1] == doctest::Approx(expected.reals.at("book")[1]).epsilon(1e-7));
  CHECK(std::abs(expected.reals.at("book")[1]) > 1e-6);
}

TEST_CASE("user-defined pair force: CUDA refuses a law without kernels by name") {
  EffectKind kind = YukawaOptions::kind();
  kind.device = [](const Scene& scene, effects::DeviceForces& forces) {
    effects::add_pair_law(scene, YukawaLaw{}, forces);
  };
  Scene scene = yukawa_gas();
  CHECK_NOTHROW(granular::device::check_scene(scene));
  scene.effects.remove<YukawaOptions>();
  scene.effects.add(kind, YukawaOptions{});
  CHECK_THROWS_WITH_AS(granular::device::check_scene(scene),
                       doctest::Contains("a law without kernels in effects.yukawa"), InputError);
  CHECK_NOTHROW(granular::device::make_host_gas(scene));
}

#ifdef LICHTENBERG_WITH_CUDA
TEST_CASE("user-defined pair force: CUDA equals the device algorithms on the CPU") {
  const Scene scene = yukawa_gas();
  std::unique_ptr<granular::device::DeviceGas> device;
  try {
    device = granular::device::make_cuda_gas(scene);
  } catch (const InputError& no_device) {
    MESSAGE(no_device.what());
    return;
  }
  const auto host = granular::device::make_host_gas(scene);
  const Checkpoint start = granular::Gas(scene).save();
  const GrainContactLaw law = granular::Gas(scene).law();
  for (granular::device::DeviceGas* each : {host.get(), device.get()}) {
    each->load(start, law, false);
    each->step(0.5, 1000);
  }
  CHECK(device->time() == host->time());
  CHECK(device->potential_energy() == doctest::Approx(host->potential_energy()).epsilon(1e-8));
}
#endif

}  // namespace extend_pair_force_device
