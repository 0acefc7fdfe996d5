// Tests of the device kernels for rough grains: friction, adhesion and walls. The CPU executes the kernels item by
// item; the reference is Multirate.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/granular/device/device.hpp"
#include "tests/device_gases.hpp"
#include "tests/message.hpp"
#include "tests/rough_grains.hpp"

namespace granular_device_rough_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;

namespace {

void add_spins(Scene& scene, double size) {
  Random random({.seed = 3, .purpose = RandomPurpose::population});
  for (Conductor& grain : scene.conductors)
    for (int k = 0; k < 3; ++k) grain.angular_velocity[k] = size * random.normal();
}

Scene frictional_gas(int count, double edge, double temperature) {
  Scene scene = gas(count, edge, temperature);
  scene.effects.add(effects::FrictionOptions{.coefficient = 0.4, .rolling_coefficient = 0.05});
  add_spins(scene, 2);
  return scene;
}
Scene sticky_gas(AdhesionModel model) {
  Scene scene = frictional_gas(100, 7, 0.3);
  scene.effects.add(effects::AdhesionOptions{.model = model, .surface_energy = 0.5});
  return scene;
}
/// Grains that fall onto the walls of a box, which have their own material, as have some grains. `adhesive`: with
/// adhesion, and walls on all sides.
Scene walled_gas(bool adhesive) {
  Scene scene = frictional_gas(100, 7, 2);
  for (std::size_t i = 0; i < scene.conductors.size(); i += 3)
    scene.conductors[i].material = {.density = 2, .stiffness = 3, .damping = 0.5};
  scene.effects.add(effects::UniformForceOptions{.acceleration = {{0.5, 0, -3}, 0}});
  const effects::FlatWallsOptions walls{.stiffness = 600, .damping = 20, .friction = 0.2};
  if (!adhesive) {
    grains::add_walls(scene, {0, 2}, walls);
    return scene;
  }
  scene.effects.add(effects::AdhesionOptions{.model = AdhesionModel::jkr, .surface_energy = 0.5});
  grains::add_walls(scene, {0, 1, 2}, walls);
  return scene;
}
/// Mixture of two sizes and two materials.
Scene mixture() {
  Scene scene = frictional_gas(80, 8, 3);
  for (std::size_t i = 0; i < scene.conductors.size(); i += 2) {
    scene.conductors[i].radius = 0.35;
    scene.conductors[i].material = {.density = 2, .stiffness = 3, .damping = 0.5};
  }
  return scene;
}

/// Compares the device with the CPU after `steps` steps. `most`: bound on differences.
void compare(const Scene& scene, int steps, double most) {
  auto [cpu, start, device] = OnBoth(scene);
  const double energy = cpu.gas.energy().total();
  for (int n = 0; n < steps; ++n) {
    cpu.step(10);
    device->step(10);
    REQUIRE(device->time() == doctest::Approx(cpu.gas.time()).epsilon(1e-12));
  }
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  REQUIRE(cpu.gas.collisions > 20);
  for (const std::string name : {"counters", "contact_pairs", "wall_contacts", "image"}) {
    CAPTURE(name);
    CHECK(found.integers.at(name) == expected.integers.at(name));
  }
  for (const std::string name :
       {"position", "momentum", "angular_velocity", "surface_springs", "wall_springs", "contact_touches", "charge"})
    if (expected.reals.contains(name)) {
      CAPTURE(name);
      CHECK(largest_difference(found.reals.at(name), expected.reals.at(name)) < most);
    }
  for (const int k : {0, 1, 2, 4}) CHECK(std::abs(found.reals.at("book")[k] - expected.reals.at("book")[k]) < most);
  // The energy balance of the device's state has the same residual as that of the CPU.
  const double off = cpu.gas.energy().total() - energy;
  cpu.gas.restore(found);
  CHECK(std::abs(cpu.gas.energy().total() - energy - off) < 10 * most);
}

}  // namespace

// Differences are those of rounding, 1e-16, which each of the up to 10 successive collisions of a grain amplifies
// tenfold at most.
TEST_CASE("device friction: 40 steps of a gas equal the CPU's within rounding") {
  compare(frictional_gas(100, 8, 5), 40, 1e-7);
}
TEST_CASE("device friction: 40 steps of a mixture equal the CPU's within rounding") { compare(mixture(), 40, 1e-7); }
TEST_CASE("device adhesion: 40 steps of a gas equal the CPU's within rounding") {
  for (const AdhesionModel model : {AdhesionModel::jkr, AdhesionModel::dmt}) {
    CAPTURE(static_cast<int>(model));
    compare(sticky_gas(model), 40, 1e-7);
  }
}
// Without damping two slow grains oscillate, and are at a gap of up to 0.006 in a part of each period. A step moves
// them by less.
TEST_CASE("device adhesion: a contact lasts at a gap also in short steps") {
  Scene scene = grains::cube(10);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 0});
  scene.effects.add(effects::AdhesionOptions{.model = AdhesionModel::jkr, .surface_energy = 0.7});
  scene.mechanics.step = 5e-4;
  grains::add_pair(scene, 0.1, 1e-3);
  auto [cpu, start, device] = OnBoth(scene);
  double widest = 0;
  for (int n = 0; n < 1500; ++n) {
    cpu.step(10), device->step(10);
    const std::vector<double>& x = cpu.gas.bodies().position;
    if (!cpu.gas.contacts().empty()) widest = std::max(widest, x[3] - x[0] - 1);
  }
  CHECK(widest > 0.003);
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  CHECK(found.integers.at("contact_pairs") == expected.integers.at("contact_pairs"));
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-9);
}

TEST_CASE("device walls: 60 steps of falling grains equal the CPU's within rounding") {
  for (const bool adhesive : {false, true}) {
    CAPTURE(adhesive);
    compare(walled_gas(adhesive), 60, 1e-7);
  }
}

// Forces of the sums are about 1, with an error of 1e-6, over a time of 2; collisions amplify it tenfold.
TEST_CASE("device friction: 40 steps of a charged gas equal the CPU's" * doctest::test_suite("long")) {
  Scene scene = charged_gas(100, 8, 5);
  scene.effects.add(effects::FrictionOptions{.coefficient = 0.4});
  compare(scene, 40, 2e-4);
}

TEST_CASE("device friction: batches of steps and checkpoints give identical bits") {
  Scene charged = charged_gas(60, 7, 3);
  charged.effects.add(effects::FrictionOptions{.coefficient = 0.4, .rolling_coefficient = 0.05});
  for (const Scene& scene : {charged, walled_gas(true), sticky_gas(AdhesionModel::dmt)}) {
    const grains::Run cpu(scene);
    const Checkpoint start = cpu.gas.save();
    const Device one = loaded(scene, cpu, start), many = loaded(scene, cpu, start);
    Checkpoint middle;
    for (int n = 0; n < 60; ++n) {
      if (n == 23) middle = stored(*one, start);
      one->step(10);
    }
    for (const int n : {1, 8, 48, 60})  // a driven gas makes one step in each call
      while (many->counts().steps < n) many->step(10, n - static_cast<int>(many->counts().steps));
    CHECK(one->counts().steps == 60);
    const Checkpoint a = stored(*one, start), b = stored(*many, start);
    CHECK(a.reals == b.reals);
    CHECK(a.integers == b.integers);
    REQUIRE(!a.reals.at("surface_springs").empty());
    const Device resumed = loaded(scene, cpu, middle);
    while (resumed->counts().steps < 37) resumed->step(10, 37 - static_cast<int>(resumed->counts().steps));
    const Checkpoint c = stored(*resumed, start);
    CHECK(a.reals == c.reals);
    CHECK(a.integers == c.integers);
  }
}

TEST_CASE("device friction: the CPU continues from a checkpoint of the device") {
  const Scene scene = walled_gas(false);
  grains::Run cpu(scene), other(scene);
  const Checkpoint start = cpu.gas.save();
  const Device device = loaded(scene, cpu, start);
  for (int n = 0; n < 20; ++n) cpu.step(10), device->step(10);
  other.restore(stored(*device, start));
  for (int n = 0; n < 20; ++n) cpu.step(10), other.step(10);
  const Checkpoint expected = cpu.gas.save(), found = other.gas.save();
  CHECK(found.integers.at("contact_pairs") == expected.integers.at("contact_pairs"));
  CHECK(found.integers.at("wall_contacts") == expected.integers.at("wall_contacts"));
  CHECK(largest_difference(found.reals.at("position"), expected.reals.at("position")) < 1e-7);
  CHECK(largest_difference(found.reals.at("angular_velocity"), expected.reals.at("angular_velocity")) < 1e-6);
}

TEST_CASE("device friction: a collision conserves both momenta") {
  Scene scene = grains::frictional(40, {.stiffness = 1e4, .restitution = 0.9}, {.coefficient = 0.5});
  grains::add(scene, {19, 20, 20}, {1, 0.3, 0});
  grains::add(scene, {21, 20.4, 20}, {-1, 0, 0.2});
  scene.conductors[0].angular_velocity = {0, 1, 2};
  grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const grains::Momenta before = grains::momenta(cpu.gas.bodies());
  const Device device = loaded(scene, cpu, start);
  while (device->time() < 2) device->step(2);
  cpu.gas.restore(stored(*device, start));
  REQUIRE(cpu.gas.collisions == 1);
  REQUIRE(cpu.gas.contacts().empty());
  const grains::Momenta after = grains::momenta(cpu.gas.bodies());
  // Momenta at distances of up to 34 from the origin are rounded to 2^-52 in some 100 substeps of the contact.
  CHECK(norm(after.linear - before.linear) < 1e-13);
  CHECK(norm(after.angular - before.angular) < 34 * 100 * 0x1p-52 * 10);
  CHECK(norm(granular::spin_of(cpu.gas.bodies(), 1)) > 0.1);
}

// A row of ever lighter grains: each hits the next one, all within one step. The last one becomes four times as fast as
// any before, and hits another at a distance in the same step.
TEST_CASE("device friction: a chain of collisions in a step misses no contact") {
  Scene scene = grains::frictional(30, {.stiffness = 1e7, .damping = 0}, {.coefficient = 0.5});
  scene.mechanics.step = 0.02;
  double x = 10;
  for (const auto& [radius, speed, gap] :
       {std::array{2.0, 4.0, 0.001}, {0.7, 0.0, 0.001}, {0.25, 0.0, 0.001}, {0.1, 0.0, 0.1}, {0.1, 0.0, 0.0}}) {
    scene.conductors.push_back({.position = {x + radius, 15, 15}, .velocity = {speed, 0, 0}, .radius = radius});
    x += 2 * radius + gap;
  }
  auto [cpu, start, device] = OnBoth(scene);
  cpu.step(10), device->step(10);
  REQUIRE(device->time() == cpu.gas.time());
  const Checkpoint expected = cpu.gas.save(), found = stored(*device, start);
  CHECK(cpu.gas.collisions >= 4);
  CHECK(found.integers.at("counters") == expected.integers.at("counters"));
  for (int i = 0; i < 5; ++i)
    CHECK(found.reals.at("momentum")[3 * i] == doctest::Approx(expected.reals.at("momentum")[3 * i]).epsilon(1e-3));
}

TEST_CASE("device friction: an elastic stage has walls, but no friction") {
  Scene scene = walled_gas(false);
  scene.stages = {{.duration = 1, .elastic = true}};
  auto [cpu, start, device] = OnBoth(scene);
  while (device->time() < 0.9) device->step(0.9);
  const Checkpoint found = stored(*device, start);
  CHECK(found.integers.at("counters")[2] > 10);
  CHECK(found.reals.at("angular_velocity") == start.reals.at("angular_velocity"));
  CHECK(std::abs(found.reals.at("book")[0]) < 1e-9);
}

// Forces of the sums have the error of the test of a charged gas.
TEST_CASE("device walls: 40 steps of charges between walls equal the CPU's") {
  for (const bool grounded : {false, true}) {
    CAPTURE(grounded);
    Scene scene = charged_gas(100, 8, 5);
    scene.effects.add(effects::FrictionOptions{.coefficient = 0.4});
    grains::add_walls(scene, {2});
    if (grounded) scene.domain.sides[4].electrode = scene.domain.sides[5].electrode = true;
    compare(scene, 40, 2e-4);
  }
}

TEST_CASE("device friction: ordered charge exchange equals the CPU's") {
  Scene scene = frictional_gas(100, 8, 5);
  for (std::size_t i = 0; i < scene.conductors.size(); i += 2) scene.conductors[i].radius = 0.35;
  scene.effects.add(effects::ChargeExchangeOptions{.model = effects::ExchangeModel::size, .strength = 0.25});
  compare(scene, 40, 1e-7);
}

TEST_CASE("device walls: a grain that passes through a wall ends the run") {
  Scene scene = walled_gas(false);
  scene.effects.find<effects::FlatWallsOptions>()->stiffness = 1;
  scene.effects.find<effects::FlatWallsOptions>()->damping = 0;
  const grains::Run cpu(scene);
  const Device device = loaded(scene, cpu, cpu.gas.save());
  const std::string message = message_of([&] {
    for (int n = 0; n < 100; ++n) device->step(10);
  });
  CHECK_MESSAGE(message.find("flies through a wall: the contact is too soft") != std::string::npos, message);
}

TEST_CASE("device walls: sides that are not periodic without walls are refused") {
  Scene scene = walled_gas(false);
  CHECK_NOTHROW(granular::device::check_scene(scene));
  scene.effects = {};
  scene.effects.add(effects::LinearContactOptions{.stiffness = 1e4});
  CHECK(message_of([&] { granular::device::check_scene(scene); }).find("without effects.flat_walls") !=
        std::string::npos);
}

}  // namespace granular_device_rough_test
