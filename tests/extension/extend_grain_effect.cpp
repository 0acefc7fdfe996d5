// Tests of an effect of grains added from outside: it acts, or is refused by name.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <span>

#include "src/commands/explain_grains.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/slow_force_limits.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

namespace extend_grain_effect {

using namespace lichtenberg;

namespace {

/// Options of an effect whose class is E.
template <class E>
struct OptionsOf {
  static const EffectKind& kind() {
    static const EffectKind kind = {
        .name = "standing_wave",
        .options = OptionsOf{},
        .dimensions = {2, 3},
        .periodic = true,
        .grains = E::grains,
        .make = [](const Scene&) { return std::make_unique<E>(); },
        .steps = {.force_accuracy = [](const Scene& s) { return 1e-6 * s.conductors.at(0).radius; },
                  .force_length = [](const Scene&) { return 0.1; },
                  .contact_attraction =
                      [](const Scene&) {
                        return ContactAttraction{0.25, 0};
                      }}};
    return kind;
  }
};

template <class E>
struct Named : Effect {
  static constexpr bool grains = true;
  const EffectKind& kind() const override { return OptionsOf<E>::kind(); }
};

constexpr double depth = 0.5, edge = 8, wave = 2 * std::numbers::pi / edge;

/// The potential depth (1 - cos(wave x)) for every grain.
struct StandingWave : Named<StandingWave> {
  void add_forces(const State& state, std::span<double> force) const override {
    for (std::size_t i = 0; i < force.size(); i += 3)
      force[i] -= depth * wave * std::sin(wave * state.bodies.position[i]);
  }
  double stored_energy(const State& state) const override {
    double energy = 0;
    for (std::size_t i = 0; i < state.bodies.position.size(); i += 3)
      energy += depth * (1 - std::cos(wave * state.bodies.position[i]));
    return energy;
  }
};
struct ForceAlone : Named<ForceAlone> {
  void add_forces(const State&, std::span<double>) const override {}
};
struct Currents : Named<Currents> {
  void add_currents(const State&, std::span<double>) const override {}
};
struct Driven : Named<Driven> {
  static constexpr bool grains = false;
  std::optional<double> drive(double, double, Bodies&) override { return 0; }
};

template <class E>
Scene scene_with() {
  Scene scene = grains::viscoelastic(edge);
  scene.effects.add(OptionsOf<E>{});
  grains::add(scene, {1, 4, 4}, {0, 0, 0});
  return scene;
}

}  // namespace

TEST_CASE("user-defined grain effect: its force moves a grain, energy is conserved") {
  grains::Run run(scene_with<StandingWave>());
  // A quarter of a pendulum's period from an angle of pi / 4, 2 K(sin(pi / 8)) / pi = 1.0399733 times that of small
  // oscillations, brings the grain to the bottom. Steps of 0.05 have an error of (wave sqrt(depth) dt)^2 / 24 of a path
  // of 1.
  run.to(0.25 * 1.0399733 * 2 * std::numbers::pi / (wave * std::sqrt(depth)));
  CHECK(std::abs(std::remainder(run.gas.bodies().position[0], edge)) < 1e-4);
  const granular::GasEnergy energy = run.gas.energy();
  CHECK(energy.kinetic == doctest::Approx(depth * (1 - std::sqrt(0.5))).epsilon(1e-4));
  CHECK(energy.potential < 1e-8);
}

TEST_CASE("user-defined grain effect: CUDA refuses it by name without device form") {
  Scene scene = scene_with<StandingWave>();
  const auto refusal = doctest::Contains("device = \"cuda\" does not support effects.standing_wave");
  CHECK_THROWS_WITH_AS(granular::device::check_scene(scene), refusal, InputError);
  CHECK_THROWS_WITH_AS(granular::device::make_host_gas(scene), refusal, InputError);
  scene.field_table = FieldOptions{.device = FieldDevice::cuda};
  Explanation out;
  CHECK_THROWS_WITH_AS(explain_grains(out, scene), refusal, InputError);
}

TEST_CASE("user-defined grain effect: unsupported functions are refused by name") {
  CHECK_THROWS_WITH_AS(granular::Gas(scene_with<Currents>()), doctest::Contains("effects.standing_wave"), InputError);
  CHECK_THROWS_WITH_AS(granular::Gas(scene_with<Currents>()), doctest::Contains("add_currents"), InputError);
  CHECK_THROWS_WITH_AS(granular::Gas(scene_with<ForceAlone>()), doctest::Contains("stored_energy"), InputError);
  CHECK_THROWS_WITH_AS(granular::Gas(scene_with<Driven>()), doctest::Contains("overrides drive"), InputError);
}

TEST_CASE("user-defined grain effect: strictest step limit holds, attractions add") {
  Scene scene = scene_with<StandingWave>();
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-2});
  // The root of the accuracy, 1e-6 / 2, for the fastest of few grains (3.2 times the thermal speed), and 0.1 d0.
  const double max_path = 0.1 * std::sqrt(0.5e-6) * granular::fastest_of(1);
  CHECK(granular::path_by_accuracy(scene) == doctest::Approx(max_path));
  CHECK(granular::path_by_length(scene) == doctest::Approx(0.02));
  // Sum of both effects: K q^2 is Coulomb's at a distance of 1.
  CHECK(granular::contact_attraction(scene)(2) == 0.25 + 4);
  granular::Gas gas(scene);
  CHECK(gas.seconds_of_forces(*std::as_const(gas).model().effects.back()) > 0);
}

}  // namespace extend_grain_effect
