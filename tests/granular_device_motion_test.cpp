// Tests of the motion of a gas on a device: output, histories and checkpoints. The CPU executes the kernels.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <span>
#include <thread>

#include "src/granular/device/device.hpp"
#include "src/granular/granular_motion.hpp"
#include "tests/device_gases.hpp"
#include "tests/rough_grains.hpp"

namespace granular_device_motion_test {

using namespace lichtenberg;
using namespace lichtenberg::device_gases;

namespace {

/// Compares frames, history and checkpoints of a gas on a device with the CPU's. A stage of the scene ends at 0.3.
void compare_motions(const Scene& scene) {
  GranularMotion cpu(scene), there(scene, granular::device::make_host_gas(scene));
  const auto never = [] { return false; };
  cpu.advance_to(0.5, never);
  there.advance_to(0.5, never);
  REQUIRE(there.time() == cpu.time());
  const Frame expected = cpu.frame(), found = there.frame();
  CHECK(largest_difference(found.reals("position"), expected.reals("position")) < 1e-5);
  CHECK(largest_difference(found.reals("charge"), expected.reals("charge")) < 1e-6);
  CHECK(largest_difference(found.reals("angular_velocity"), expected.reals("angular_velocity")) < 1e-6);
  CHECK(*found.number("collisions") == *expected.number("collisions"));
  // Histories between frames come from snapshots. Energies have the precision of the forces; counts are exact.
  const ColumnGroup here_noted = cpu.take_history(), noted = there.take_history();
  REQUIRE(noted.columns.size() == here_noted.columns.size());
  for (std::size_t c = 0; c < noted.columns.size(); ++c) {
    CAPTURE(noted.columns[c].name);
    CHECK(noted.columns[c].name == here_noted.columns[c].name);
    if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&noted.columns[c].values)) {
      CHECK(*whole == std::get<std::vector<std::int64_t>>(here_noted.columns[c].values));
    } else {
      const auto& a = std::get<std::vector<double>>(noted.columns[c].values);
      const auto& b = std::get<std::vector<double>>(here_noted.columns[c].values);
      REQUIRE(a.size() == b.size());
      for (std::size_t k = 0; k < a.size(); ++k)
        CHECK((std::isnan(a[k]) == std::isnan(b[k]) && !(std::abs(a[k] - b[k]) > 1e-4 * (1 + std::abs(b[k])))));
    }
  }
  GranularMotion here(scene), over(scene, granular::device::make_host_gas(scene));
  here.restore(there.checkpoint());
  over.restore(cpu.checkpoint());
  for (GranularMotion* motion : {&cpu, &there, &here, &over}) motion->advance_to(0.75, never);
  for (GranularMotion* motion : {&there, &here, &over}) {
    CHECK(largest_difference(motion->frame().reals("position"), cpu.frame().reals("position")) < 1e-4);
  }
}

Scene staged(Scene scene) {
  scene.stages = {{.duration = 0.3, .elastic = true, .stiffness = 10, .temperature = 2}};
  scene.stop.time = 1;
  scene.output.every = 0.25;
  return scene;
}

}  // namespace

TEST_CASE("device motion: frames, history and checkpoints agree with the CPU's") {
  compare_motions(staged(charged_gas(60, 7, 3)));
}

TEST_CASE("device motion: output of rough grains at walls agrees with the CPU's") {
  Scene scene = gas(60, 6, 3);
  scene.effects.add(effects::FrictionOptions{.coefficient = 0.4});
  scene.effects.add(effects::AdhesionOptions{.model = AdhesionModel::jkr, .surface_energy = 0.5});
  scene.effects.add(effects::UniformForceOptions{.acceleration = {{0.5, 0, -3}, 0}});
  grains::add_walls(scene, {0, 2}, {.stiffness = 600, .friction = 0.2});
  compare_motions(staged(scene));
}

namespace {

void check_same_bits(const std::vector<Column>& found, const std::vector<Column>& expected) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t c = 0; c < found.size(); ++c) {
    CAPTURE(found[c].name);
    CHECK(found[c].name == expected[c].name);
    REQUIRE(found[c].values.index() == expected[c].values.index());
    std::visit(
        [&]<class Number>(const std::vector<Number>& numbers) {
          const auto& others = std::get<std::vector<Number>>(expected[c].values);
          CHECK(std::ranges::equal(std::as_bytes(std::span(numbers)), std::as_bytes(std::span(others))));
        },
        found[c].values);
  }
}

}  // namespace

TEST_CASE("device motion: frames built during later steps equal those built at once") {
  for (const bool polarized : {false, true}) {
    CAPTURE(polarized);
    Scene scene = polarized ? polarized_gas() : charged_gas(60, 7, 3);
    scene.stages = {{.duration = 0.3, .stiffness = 10}};
    scene.stop.time = 1;
    scene.output.every = 0.25;
    GranularMotion at_once(scene, granular::device::make_host_gas(scene)),
        later(scene, granular::device::make_host_gas(scene));
    const auto never = [] { return false; };
    for (const double time : {0.25, 0.5, 0.75}) {
      at_once.advance_to(time, never), later.advance_to(time, never);
      const auto frame_later = later.frame_later();
      const auto saved_state_later = later.saved_state_later();
      // progress() on the calling thread does not wait for pending output.
      CHECK(later.progress() == at_once.progress());
      std::jthread other([&] { later.advance_to(time + 0.1, never); });
      const Frame frame = frame_later();
      CHECK(frame.time == time);
      check_same_bits(frame.columns, at_once.frame().columns);
      const SavedState saved = saved_state_later();
      const Checkpoint checkpoint = at_once.checkpoint();
      CHECK(saved.checkpoint.reals == checkpoint.reals);
      CHECK(saved.checkpoint.integers == checkpoint.integers);
      check_same_bits(saved.history.columns, at_once.take_history().columns);
      at_once.advance_to(time + 0.1, never);
    }
    CHECK(later.leaves_a_core() == (std::thread::hardware_concurrency() > 1));
  }
}

TEST_CASE("device motion: frame() waits for all pending callbacks") {
  Scene scene = charged_gas(60, 7, 3);
  scene.stop.time = 1;
  scene.output.every = 0.25;
  GranularMotion motion(scene, granular::device::make_host_gas(scene));
  motion.advance_to(0.25, [] { return false; });
  std::atomic<bool> begun = false;
  const auto saved_state_later = motion.saved_state_later();
  motion.frame_later();
  const std::jthread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    begun = true;
    saved_state_later();
  });
  motion.frame();
  CHECK(begun.load());
}

}  // namespace granular_device_motion_test
