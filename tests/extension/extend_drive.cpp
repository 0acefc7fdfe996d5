// Drive of grains added from outside: a drag proportional to the square of the speed, on the CPU and on a device.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>

#include "solvers/error.hpp"
#include "src/effects/device_forces.hpp"
#include "src/granular/device/device.hpp"
#include "src/model/drive_part.hpp"
#include "tests/grains.hpp"

namespace extend_drive {

using namespace lichtenberg;

namespace {

/// m dv/dt = -c v |v| for each grain, with the solution v / (1 + c |v| dt / m).
struct SquareDragLaw {
  double coefficient = 0.4;

  LICHTENBERG_HOST_DEVICE void operator()(double, double dt, int, double mass, double* p, int d) const {
    double square = 0;
    for (int k = 0; k < d; ++k) square += p[k] * p[k];
    for (int k = 0; k < d; ++k) p[k] /= 1 + coefficient * std::sqrt(square) / (mass * mass) * dt;
  }
};

struct SquareDrag;
struct SquareDragOptions {
  static const EffectKind& kind();
};

struct SquareDrag : Effect {
  const EffectKind& kind() const override { return SquareDragOptions::kind(); }
  std::optional<double> drive(double time, double dt, Bodies& b) override {
    const double before = kinetic_energy(b);
    for (int i = 0; i < b.size(); ++i) SquareDragLaw{}(time, dt, i, b.mass[i], &b.momentum[3 * i], 3);
    return kinetic_energy(b) - before;
  }
};

const EffectKind& SquareDragOptions::kind() {
  static const EffectKind kind = {
      .name = "square_drag",
      .options = SquareDragOptions{},
      .dimensions = {3},
      .periodic = true,
      .grains = true,
      .make = [](const Scene&) { return std::make_unique<SquareDrag>(); },
      .device = [](const Scene&,
                   effects::DeviceForces& forces) { forces.drives.push_back(drive_form(SquareDragLaw{})); }};
  return kind;
}

Scene lone_grain() {
  Scene scene = grains::viscoelastic(8);
  grains::add(scene, {4, 4, 4}, {0.6, 0, 0.8});
  scene.effects.add(SquareDragOptions{});
  return scene;
}

}  // namespace

TEST_CASE("user-defined drive: grain speed v / (1 + c v t) on CPU and device") {
  const Scene scene = lone_grain();
  grains::Run cpu(scene);
  const Checkpoint start = cpu.gas.save();
  const auto device = granular::device::make_host_gas(scene);
  device->load(start, cpu.gas.law(), false);
  cpu.to(2);
  while (device->time() < 2) device->step(2, 100);
  Checkpoint found = start;
  device->store(found);
  const double mass = cpu.gas.bodies().mass[0], speed = 1 / (1 + SquareDragLaw{}.coefficient * 2 / mass);
  for (const std::vector<double>& momentum : {cpu.gas.bodies().momentum, found.reals.at("momentum")}) {
    CHECK(momentum[0] == doctest::Approx(0.6 * mass * speed).epsilon(1e-12));
    CHECK(momentum[2] == doctest::Approx(0.8 * mass * speed).epsilon(1e-12));
  }
  const double lost = 0.5 * mass * (1 - speed * speed);
  CHECK(cpu.gas.energy().driven == doctest::Approx(-lost).epsilon(1e-12));
  CHECK(found.reals.at("book")[2] == doctest::Approx(-lost).epsilon(1e-6));  // 80 energies in quanta of 2^-32.
}

TEST_CASE("user-defined drive: CUDA refuses a law without kernels by name") {
  CHECK_THROWS_WITH_AS(granular::device::check_scene(lone_grain()),
                       doctest::Contains("a law without kernels in effects.square"), InputError);
}

}  // namespace extend_drive
