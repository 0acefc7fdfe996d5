// Tests of the device kernels for a granular gas. The CPU executes the kernels item by item; the reference is
// Multirate.

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <span>
#include <thread>

#include "solvers/error.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/device/lists.hpp"
#include "src/granular/granular_motion.hpp"
#include "tests/device_gases.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

namespace granular_device_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;

TEST_CASE("device memory: too large a gas is refused with the number that would fit") {
  granular::device::GasOptions options = granular::device::gas_options(gas(100, 12, 1));
  options.path = "gas.toml";
  options.bytes = 1 << 30;
  CHECK_NOTHROW(granular::device::check_memory(options, 1 << 30));
  CHECK_THROWS_WITH_AS(granular::device::check_memory(options, 1 << 28),
                       "gas.toml: 100 grains take about 1024 MiB of the CUDA device, of which 256 are free: 25 of them "
                       "would fit",
                       Failure);
}

TEST_CASE("device lists: a gas with too many list entries is refused") {
  Scene scene = gas(100, 12, 1);
  scene.path = "gas.toml";
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-4});
  CHECK_NOTHROW(granular::device::check_scene(scene));
  // The grains coincide; check_scene() does not compare positions.
  scene.conductors.resize(300000, scene.conductors.front());
  const std::string sentence = message_of([&] { granular::device::check_scene(scene); });
  CHECK_MESSAGE(sentence.starts_with("gas.toml: device = \"cuda\" does not support lists for 300000 grains with "),
                sentence);
}

TEST_CASE("device: 60 steps of a neutral gas equal the CPU's within rounding") {
  for (const bool linear : {false, true}) {
    Scene scene = gas(100, 8, 5);
    if (linear) {
      scene.effects = {};
      scene.effects.add(effects::LinearContactOptions{.stiffness = 278.6});
    }
    auto [cpu, start, device] = OnBoth(scene);
    CHECK(device->potential_energy() == 0);
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
    // Compilers contract the same operations differently. Each collision amplifies the rounding by a factor of ten.
    CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-8);
    CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 1e-8);
    CHECK(largest_difference(found.reals.at("contact_touches"), expected.reals.at("contact_touches")) < 1e-8);
    // The dissipated energy is a multiple of 2^-32, summed over a few thousand rounded terms.
    CHECK(found.reals.at("book")[0] == doctest::Approx(expected.reals.at("book")[0]).epsilon(1e-9));
    CHECK(found.reals.at("book")[4] == doctest::Approx(expected.reals.at("book")[4]).epsilon(1e-9));
  }
}

TEST_CASE("device cells: a large box has few cells, limited by its grains") {
  const auto cells_in = [](double length, int n) {
    const Vec3 edge = granular::device::contact_cell_edges({length, length, length}, n);
    return length * length * length / (edge.x * edge.y * edge.z);
  };
  CHECK(cells_in(400, 2) < 5000);
  CHECK(cells_in(1e6, 1000) < 70'000);
  // A gas of volume fraction 0.03 keeps the cell edge of the collision search.
  CHECK(granular::device::contact_cell_edges({260, 260, 260}, 1'000'000).x == 1);
  // Grains in a box of 10^9 possible cells take the same steps as on the CPU.
  Scene scene = gas(8, 4, 5);
  scene.domain.size = {1000, 1000, 1000};
  auto [cpu, start, device] = OnBoth(scene);
  for (int n = 0; n < 30; ++n) {
    cpu.step(10);
    device->step(10);
  }
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 0);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-8);
}

TEST_CASE("device: restitution of isolated collisions is recorded as on the CPU") {
  for (const bool linear : {false, true}) {
    CAPTURE(linear);
    Scene scene = grains::cube(40);
    if (linear)
      scene.effects.add(effects::LinearContactOptions{.stiffness = 278.6, .restitution = 0.8});
    else
      scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
    // Nine pairs collide head-on at different speeds on parallel lines. The fastest grains travel 8 and meet no other
    // pair. A grain that passes at a distance does not count, nor does a pair that a third grain hits during its
    // contact.
    for (int k = 0; k < 9; ++k) {
      const double v = 0.02 * std::pow(2, k), y = 2 + 4.0 * k;
      grains::add(scene, {5, y, 5}, {v / 2, 0, 0});
      grains::add(scene, {6 + 0.2 * v, y, 5}, {-v / 2, 0, 0});
    }
    grains::add(scene, {10, 20, 20}, {1, 0, 0});
    grains::add(scene, {11.2, 20.6, 20}, {-1, 0, 0});
    for (const double x : {20.0, 21.1, 22.2}) grains::add(scene, {x, 20, 20}, {21.1 - x, 0, 0});
    auto [cpu, start, device] = OnBoth(scene);
    while (cpu.gas.time() < 3) cpu.step(3), device->step(3);
    REQUIRE(device->time() == cpu.gas.time());
    const auto expected = cpu.gas.save().reals.at("restitution_check"),
               middle = stored(*device, start).reals.at("restitution_check");
    CHECK(cpu.gas.restitution.all().collisions == 9);
    CHECK(cpu.gas.restitution.all().collisions < cpu.gas.collisions);
    CHECK(largest_difference(middle, expected) < 1e-8);  // The bound covers rounding and the quantum of 1e-9.
    // With many steps per call, some are started after the last one that is needed. They count no collision again.
    const Device ahead = loaded(scene, cpu, start);
    while (ahead->time() < 3) ahead->step(3, 100);
    CHECK(stored(*ahead, start).reals.at("restitution_check") == middle);
    // The statistics continue from the checkpoint. A contact of an earlier stage does not count.
    const auto again = granular::device::make_host_gas(scene), later = granular::device::make_host_gas(scene);
    again->load(stored(*device, start), cpu.gas.law(), false);
    CHECK(stored(*again, start).reals.at("restitution_check") == middle);
    later->load(start, cpu.gas.law(), false, 3);
    while (later->time() < 3) later->step(3);
    CHECK(stored(*later, start).reals.at("restitution_check") == start.reals.at("restitution_check"));
  }
}

TEST_CASE("device: drag, wind and uniform force act as on the CPU, also in energy") {
  Scene scene = gas(100, 8, 5);
  scene.effects.add(effects::GasDragOptions{.stokes = 0.3, .speed = 2, .correlation_time = 0.07});
  scene.effects.add(effects::UniformForceOptions{.acceleration = {{0.5, 0, -1}, 3}});
  auto [cpu, start, device] = OnBoth(scene);
  for (int n = 0; n < 40; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 20);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 1e-8);
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-8);
  // 80 kicks of 100 grains, each energy rounded to a multiple of 2^-32.
  CHECK(std::abs(found.reals.at("book")[2]) > 1);
  CHECK(std::abs(found.reals.at("book")[2] - expected.reals.at("book")[2]) < 1e-7);
}

TEST_CASE("device: 40 steps of a charged gas equal the CPU's within force accuracy") {
  const Scene scene = charged_gas(100, 8, 5);
  auto [cpu, start, device] = OnBoth(scene);
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
  // Forces are about 1, with an rms error of 1e-6 on either mesh, hence sqrt(2) times that between both, over a time of
  // 0.4. Collisions amplify it tenfold. The largest of 300 numbers is three times the rms.
  const double most = std::sqrt(2) * 1e-6 * 0.4 * 10 * 3;
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < most);
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < most);
  CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) < most);
  double charge = 0;
  for (const double q : found.reals.at("charge")) charge += q;
  CHECK(charge == 0);
  CHECK(found.reals.at("book")[1] == doctest::Approx(expected.reals.at("book")[1]).epsilon(1e-4));
  // The energy balance of the device's state has the same residual as that of the CPU.
  const double off = cpu.gas.energy().total() - energy;
  cpu.gas.restore(found);
  CHECK(cpu.gas.energy().total() - energy == doctest::Approx(off).epsilon(1e-2));
}

TEST_CASE("device: single steps and batches of steps give identical bits") {
  const Scene scene = charged_gas(60, 7, 3);
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const Device one = loaded(scene, cpu, start), many = loaded(scene, cpu, start);
  for (int n = 0; n < 60; ++n) one->step(10);
  for (const int n : {1, 7, 40, 12}) many->step(10, n);
  CHECK(one->counts().steps == 60);
  CHECK(many->counts().contact_steps == one->counts().contact_steps);
  const Checkpoint a = stored(*one, start), b = stored(*many, start);
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
}

TEST_CASE("device: the outer step is at most a quarter of a bound-pair period") {
  Scene scene = charged_gas(60, 7, 0.01);
  scene.effects.remove("charge_exchange");
  scene.mechanics.step = 0.3;  // A pair of charges +1 and -1 oscillates with a period of 0.55.
  grains::Run cpu(scene);
  cpu.gas.steps = 1;  // At step 0 the gas would refuse this outer step.
  const Device device = loaded(scene, cpu, cpu.gas.save());
  cpu.step(10);
  device->step(10);
  CHECK(cpu.gas.time() < 0.15);
  CHECK(device->time() == cpu.gas.time());
}

TEST_CASE("device: the outer step from the force accuracy equals the CPU's") {
  Scene scene = charged_gas(60, 7, 0.3);
  scene.effects.find<effects::CoulombOptions>()->accuracy = 1e-4;
  scene.mechanics.step = INFINITY;
  grains::Run cpu(scene);
  const Device device = loaded(scene, cpu, cpu.gas.save());
  cpu.step(10);
  device->step(10);
  // The largest force has single precision.
  CHECK(device->time() == doctest::Approx(cpu.gas.time()).epsilon(1e-5));
}

TEST_CASE("device: potential energy of constant charges equals the CPU's") {
  Scene scene = charged_gas(60, 7, 3);
  scene.effects.remove("charge_exchange");
  grains::Run cpu(scene);
  const Device device = loaded(scene, cpu, cpu.gas.save());
  for (int n = 0; n < 5; ++n) cpu.step(10), device->step(10);
  const double energy = cpu.gas.energy().potential;
  // Single precision of 60 energies.
  CHECK(device->potential_energy() == doctest::Approx(energy).epsilon(1e-5));
}

TEST_CASE("device: 40 steps of a polarizable charged gas equal the CPU's") {
  const Scene scene = polarized_gas();
  auto [cpu, start, device] = OnBoth(scene);
  CHECK(device->potential_energy() == doctest::Approx(cpu.gas.energy().potential).epsilon(1e-5));
  for (int n = 0; n < 40; ++n) cpu.step(10), device->step(10);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 20);
  CHECK(found.integers.at("counters")[2] == expected.integers.at("counters")[2]);
  // Forces are about 1, with an error of 1e-6, over a time of 2. Collisions amplify it tenfold.
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-4);
  CHECK(largest_difference(found.reals.at("momentum"), expected.reals.at("momentum")) < 1e-4);
  CHECK(largest_difference(found.reals.at("effects.coulomb.dipole"), expected.reals.at("effects.coulomb.dipole")) <
        1e-5);
  CHECK(largest_difference(found.reals.at("effects.coulomb.force"), expected.reals.at("effects.coulomb.force")) < 1e-4);
  CHECK(found.reals.at("effects.coulomb.energy")[0] ==
        doctest::Approx(expected.reals.at("effects.coulomb.energy")[0]).epsilon(1e-4));
  CHECK(found.reals.at("effects.coulomb.dipole_3").size() == 300);
  // The CPU takes the dipoles and their forces from the checkpoint without an evaluation.
  const std::int64_t evaluations = found.integers.at("effects.coulomb.counters")[0];
  cpu.gas.restore(found);
  CHECK(cpu.gas.energy().potential == doctest::Approx(device->potential_energy()).epsilon(1e-12));
  CHECK(cpu.gas.save().integers.at("effects.coulomb.counters")[0] == evaluations);
}

TEST_CASE("device dipoles: at most 2.05 evaluations a short step, 3.05 a long step") {
  for (const bool is_short : {true, false}) {
    Scene scene = polarized_gas();
    scene.effects.remove("charge_exchange");
    scene.effects.find<effects::InducedDipolesOptions>()->tolerance = 1e-4;
    if (is_short) scene.mechanics.step = 0.005;
    auto [cpu, start, device] = OnBoth(scene);
    device->step(10, 5);  // The dipole history is complete after five steps.
    const std::vector<std::int64_t> before = stored(*device, start).integers.at("effects.coulomb.counters");
    device->step(10, 40);
    const std::vector<std::int64_t> after = stored(*device, start).integers.at("effects.coulomb.counters");
    CHECK(after[0] - before[0] == 40);
    CHECK(after[1] - before[1] <= (is_short ? 42 : 82));  // Evaluations beyond the first one of each step.
  }
}

TEST_CASE("device: a gas with dipoles restored from a checkpoint has identical bits") {
  const Scene scene = polarized_gas();
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto whole = granular::device::make_host_gas(scene), resumed = granular::device::make_host_gas(scene);
  whole->load(start, cpu.gas.law(), false);
  whole->step(10, 8);
  resumed->load(stored(*whole, start), cpu.gas.law(), false);
  whole->step(10, 9);
  resumed->step(10, 9);
  const Checkpoint a = stored(*whole, start), b = stored(*resumed, start);
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
}

TEST_CASE("device: diverging polarization throws an error message") {
  Scene scene = grains::cube(10);
  for (const double x : {4.0, 4.8}) grains::add(scene, {x, 5, 5}, {4.4 - x, 0, 0});
  scene.conductors[0].charge = 1;
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-4});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.3});
  const auto device = granular::device::make_host_gas(scene);
  Checkpoint start;
  {
    Scene unpolarized = scene;
    unpolarized.effects.remove("induced_dipoles");
    grains::Run cpu(unpolarized);
    start = cpu.gas.save();
    const std::string message = message_of<Failure>([&] {
      device->load(start, cpu.gas.law(), false);
      device->step(10);
    });
    CHECK(message.find("mutual polarization") != std::string::npos);
  }
}

TEST_CASE("device: a charged gas restored from a checkpoint has identical bits") {
  const Scene scene = charged_gas(60, 7, 3);
  const grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const Device whole = loaded(scene, cpu, start);
  Checkpoint middle;
  for (int n = 0; n < 50; ++n) {
    if (n == 23) middle = stored(*whole, start);
    whole->step(10);
  }
  const Device resumed = loaded(scene, cpu, middle);
  for (int n = 23; n < 50; ++n) resumed->step(10);
  const Checkpoint a = stored(*whole, start), b = stored(*resumed, start);
  CHECK(a.reals == b.reals);
  CHECK(a.integers == b.integers);
}

TEST_CASE("device: random charge transfers of a grain in two contacts as on CPU") {
  Scene scene = grains::cube(8);
  for (const double x : {4.0, 2.9, 5.1}) grains::add(scene, {x, 4, 4}, {4 - x, 0, 0});
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  auto [cpu, start, device] = OnBoth(scene);
  for (int n = 0; n < 4; ++n) cpu.step(10), device->step(10);
  REQUIRE(cpu.gas.collisions == 2);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(expected.integers.at("effects.charge_exchange.collisions") == std::vector<std::int64_t>{2, 1, 1});
  CHECK(found.integers == expected.integers);
  CHECK(largest_difference(found.reals.at("charge"), expected.reals.at("charge")) < 1e-10);
  CHECK(std::abs(expected.reals.at("charge")[1]) > 1e-3);
}

TEST_CASE("device: charge exchange is off while the gas is mixed elastically") {
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

TEST_CASE("device: a scene with an unsupported feature is refused with its name") {
  const auto sentence = [](const Scene& scene) {
    return message_of<InputError>([&] { granular::device::check_scene(scene); });
  };
  Scene scene = charged_gas(10, 8, 1);
  CHECK(sentence(scene).empty());
  scene.effects.find<effects::ChargeExchangeOptions>()->each_step = true;
  CHECK(sentence(scene).find("does not support effects.charge_exchange.each_step") != std::string::npos);
  scene = charged_gas(10, 8, 1);
  scene.effects.find<effects::CoulombOptions>()->accuracy = 1e-8;
  CHECK(sentence(scene).find("single precision reaches 1e-6") != std::string::npos);
  scene = charged_gas(10, 8, 1);
  scene.effects.find<effects::CoulombOptions>()->cutoff = 3;
  CHECK(sentence(scene).find("does not support given effects.coulomb.cutoff") != std::string::npos);
  scene = polarized_gas();
  CHECK(sentence(scene).empty());
  scene.effects.find<effects::InducedDipolesOptions>()->sum = periodic::DipoleSum::minimum_image;
  CHECK(sentence(scene).find("does not support effects.induced_dipoles.sum = \"minimum-image\"") != std::string::npos);
  scene = gas(10, 8, 1);
  scene.mechanics.integrator = Integrator::verlet;
  CHECK(sentence(scene).find("mechanics.integrator = \"verlet\"") != std::string::npos);
#ifndef LICHTENBERG_WITH_CUDA
  CHECK_THROWS_AS(granular::device::make_cuda_gas(gas(10, 8, 1)), InputError);
#endif
}

}  // namespace granular_device_test
