// Integrator of conductors added from outside: Heun's method (explicit trapezoidal rule), with a field solve for each
// of its two force evaluations.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/mechanics/stepper.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

namespace extend_integrator {

using namespace lichtenberg;
using steel_spheres::radius;

namespace {

class Heun : public mechanics::Stepper {
 public:
  explicit Heun(const mechanics::StepperContext& context) : context_(context) {}
  void begin(double) override {}
  void advance(double time, double end) override {
    const int steps = std::max(1, static_cast<int>(std::lround((end - time) / context_.scene.mechanics.largest_step)));
    const double start = time;
    for (int k = 1; k <= steps; ++k) {
      context_.between_steps();
      const double next = start + (end - start) * k / steps;
      step(time, next - time);
      ++context_.counters.steps;
      context_.electrics->accept(context_.electrics->solve(next)), context_.electrics->reconnect(next);
      context_.commit(next, next - time);
      time = next;
    }
  }

 private:
  struct Rate {
    std::vector<double> velocity, force;  ///< m/s and N
  };

  Rate rate(double time) {
    mechanics::Trial trial = context_.electrics->solve(time);
    const std::vector<Vec3> constant(trial.field.force.size());
    context_.electrics->set_extrapolation(
        {.time = time, .force = std::move(trial.field.force), .force_rate = constant});
    const Bodies& b = context_.model.bodies;
    Rate rate{b.momentum, std::vector<double>(b.momentum.size())};
    for (std::size_t k = 0; k < rate.velocity.size(); ++k) rate.velocity[k] /= b.mass[k / b.dimension];
    context_.model.forces(time, rate.force);
    return rate;
  }
  void step(double time, double dt) {
    Bodies& b = context_.model.bodies;
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

  mechanics::StepperContext context_;
};

constexpr IntegratorKind heun = {
    .name = "heun", .moves_conductors = true, .keys = {"largest_step"}, .accuracy_key = "largest_step"};

/// Integrator that moves each body by `shift` (m) along x and commits a part of the interval.
class Careless : public mechanics::Stepper {
 public:
  static inline double shift = 0, committed_part = 1;

  explicit Careless(const mechanics::StepperContext& context) : context_(context) {}
  void begin(double) override {}
  void advance(double time, double end) override {
    Bodies& b = context_.model.bodies;
    for (int i = 0; i < b.size(); ++i) b.position[i * b.dimension] += shift;
    context_.between_steps();
    context_.electrics->accept(context_.electrics->solve(end)), context_.electrics->reconnect(end);
    context_.commit(end, committed_part * (end - time));
  }

 private:
  mechanics::StepperContext context_;
};

constexpr IntegratorKind careless = {.name = "careless", .moves_conductors = true};

constexpr auto make = [](const mechanics::StepperContext& context) -> std::unique_ptr<mechanics::Stepper> {
  return std::make_unique<Heun>(context);
};

Scene scene_with(const std::string& mechanics, const std::string& effects = "") {
  std::string text =
      "domain = { size = [0.1, 0.1], bottom = { potential = 0.0 } }\noutput = { every = 1.0 }\n"
      "medium = { permittivity = 4.2e-11, viscosity = 0.7 }\nmechanics = { " +
      mechanics + " }\neffects = { floating_conductors = {}, stokes_drag = {}" + effects + " }\n";
  for (const char* position : {"[0.045, 0.05]", "[0.055, 0.052]"})
    text += fmt::format("[[conductor]]\nposition = {}\nradius = {}\ncharge = 2e-10\n", position, radius);
  return parse_scene(text, "scene.toml");
}

/// Two charged conductors that repel each other in oil, after 10 ms: several relaxation times.
ConductorFrame pushed_apart(const std::string& mechanics) {
  Simulation simulation(scene_with(mechanics), std::make_unique<LineCharges>());
  simulation.advance_to(0.01);
  return simulation.now();
}

}  // namespace

TEST_CASE("user-defined conductor integrator (Heun): error is of second order") {
  mechanics::add_integrator(heun, make);
  const ConductorFrame exact = pushed_apart("coupling = \"monolithic\", relative_tolerance = 1e-9");
  std::vector<double> error;
  for (const double step : {4e-4, 2e-4, 1e-4})
    error.push_back(steel_spheres::largest_distance(
        pushed_apart(fmt::format("integrator = \"heun\", largest_step = {}", step)), exact));
  // The path is a few radii. A step of 0.26 relaxation times has an error of a few per cent of it. At the longest step
  // the third-order terms are some tenths of the second-order ones.
  CHECK(error[0] < 0.1 * radius);
  CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.2));
  CHECK(error[1] / error[2] == doctest::Approx(4).epsilon(0.1));
}

TEST_CASE("user-defined conductor integrator (Heun): listed; wrong keys are refused") {
  mechanics::add_integrator(heun, make);
  CHECK(scene_help("mechanics.integrator").find("\"heun\"") != std::string::npos);
  // The integrator does not read this key.
  CHECK_THROWS_AS(scene_with("integrator = \"heun\", euler_step = 1e-5"), InputError);
  CHECK_THROWS_WITH_AS(scene_with("integrator = \"verlet\""), doctest::Contains("\"euler\" and \"heun\" are allowed"),
                       InputError);
  const IntegratorKind other = {.name = "euler", .moves_conductors = true};
  CHECK_THROWS_AS(mechanics::add_integrator(other, make), InputError);
}

TEST_CASE("user-defined conductor integrator: faulty steps end the run") {
  mechanics::add_integrator(careless, [](const mechanics::StepperContext& context) {
    return std::unique_ptr<mechanics::Stepper>(new Careless(context));
  });
  const auto advance = [](double shift, double committed_part, const std::string& effects = "") {
    Careless::shift = shift, Careless::committed_part = committed_part;
    Simulation simulation(scene_with("integrator = \"careless\"", effects), std::make_unique<LineCharges>());
    simulation.advance_to(0.01);
  };
  const std::string contact = ", hertz_contact = {}";  // Hertzian contacts allow half a radius in a step.
  CHECK_NOTHROW(advance(0.49 * radius, 1, contact));
  CHECK_NOTHROW(advance(2 * radius, 1));
  CHECK_THROWS_WITH_AS(advance(0.51 * radius, 1, contact),
                       doctest::Contains("integrator = \"careless\" moved conductor 0 by"), Failure);
  CHECK_THROWS_WITH_AS(advance(0, 0.5), doctest::Contains("call StepperContext::commit once after each step"), Failure);
}

}  // namespace extend_integrator
