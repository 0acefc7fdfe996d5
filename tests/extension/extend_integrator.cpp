// An integrator of conductors added from outside: Heun's method (explicit trapezoidal rule), with a field solve for
// each of its two force evaluations.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/mechanics/stepper.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

using namespace lichtenberg;
using steel_spheres::radius;

namespace {

class Heun : public mechanics::Stepper {
 public:
  explicit Heun(const mechanics::Workplace& workplace) : at_(workplace) {}
  void begin(double) override {}
  void advance(double time, double end) override {
    const int steps = std::max(1, static_cast<int>(std::lround((end - time) / at_.scene.mechanics.largest_step)));
    const double start = time;
    for (int k = 1; k <= steps; ++k) {
      at_.between_steps();
      const double next = start + (end - start) * k / steps;
      step(time, next - time);
      ++at_.counters.steps;
      if (at_.electrics) at_.electrics->accept(at_.electrics->solve(next)), at_.electrics->reconnect(next);
      at_.model.accept(next, next - time);
      time = next;
    }
  }

 private:
  struct Rate {
    std::vector<double> velocity, force;  ///< m/s, N
  };

  Rate rate(double time) {
    if (at_.electrics) {
      mechanics::Trial trial = at_.electrics->solve(time);
      const std::vector<Vec3> constant(trial.field.force.size());
      at_.electrics->hold({.time = time, .force = std::move(trial.field.force), .force_rate = constant});
    }
    const Bodies& b = at_.model.bodies;
    Rate rate{b.momentum, std::vector<double>(b.momentum.size())};
    for (std::size_t k = 0; k < rate.velocity.size(); ++k) rate.velocity[k] /= b.mass[k / b.dimension];
    at_.model.forces(time, rate.force);
    return rate;
  }
  void step(double time, double dt) {
    Bodies& b = at_.model.bodies;
    const Rate first = rate(time);
    const auto add = [&](double weight, const Rate& rate) {
      for (std::size_t k = 0; k < b.position.size(); ++k) {
        b.position[k] += weight * dt * rate.velocity[k];
        b.momentum[k] += weight * dt * rate.force[k];
      }
    };
    add(1, first);
    const Rate second = rate(time + dt);
    add(-0.5, first), add(0.5, second);
  }

  mechanics::Workplace at_;
};

std::unique_ptr<mechanics::Stepper> make_heun(const mechanics::Workplace& workplace) {
  return std::make_unique<Heun>(workplace);
}

constexpr IntegratorKind heun = {.name = "heun",
                                 .moves_conductors = true,
                                 .keys = {"largest_step"},
                                 .accuracy_key = "largest_step",
                                 .accuracy = &MechanicsOptions::largest_step,
                                 .make_stepper = make_heun};

/// Two charged conductors that repel each other in oil, after 10 ms: some relaxation times.
ConductorFrame pushed_apart(const MechanicsOptions& mechanics, double charge = 2e-10) {
  Scene scene = steel_spheres::conductor_scene({{0.045, 0.05}, {0.055, 0.052}});
  for (Conductor& conductor : scene.conductors) conductor.charge = charge;
  const double tolerance = scene.mechanics.position_tolerance;
  scene.mechanics = mechanics;
  scene.mechanics.position_tolerance = tolerance;
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(0.01);
  return simulation.now();
}

}  // namespace

TEST_CASE("Heun's method from outside: errors fall as the square of the step") {
  const ConductorFrame exact =
      pushed_apart({.coupling = FieldCoupling::monolithic, .relative_tolerance = 1e-9, .largest_step = 1});
  std::vector<double> error;
  for (const double step : {4e-4, 2e-4, 1e-4})
    error.push_back(steel_spheres::largest_distance(pushed_apart({.integrator = heun, .largest_step = step}), exact));
  // The way is a few radii; of a step of 0.26 relaxation times a few per cent of it are wrong. What is left of third
  // order is some tenths of the second at the longest step.
  CHECK(error[0] < 0.1 * radius);
  CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.2));
  CHECK(error[1] / error[2] == doctest::Approx(4).epsilon(0.1));
}

TEST_CASE("Heun's method from outside: scenes of grains refuse it, and the summary names its key") {
  Scene scene = steel_spheres::conductor_scene({{0.05, 0.05}});
  scene.mechanics.integrator = heun;
  CHECK(name_of(scene.mechanics.integrator) == "heun");
  CHECK(!scene.mechanics.kind().moves_grains);
  scene.mechanics.integrator = Integrator::verlet;
  CHECK_THROWS_WITH_AS(Simulation(scene, std::make_unique<LineCharges>()),
                       doctest::Contains("\"verlet\" does not move conductors: \"cvode\" and \"euler\" do"),
                       InputError);
}
