// Drag law added from outside: quadratic drag of conductors, F = c v^2 against the velocity v.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "src/effects/leakage.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/effect_kind.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

namespace extend_drag_law {

using namespace lichtenberg;
using steel_spheres::mass;

namespace {

struct QuadraticDragOptions {
  double coefficient = 2e-3;  ///< c in kg/m
  bool is_declared = true;    ///< Declared as drag; false: as an ordinary force.
  static const EffectKind& kind();
};

class QuadraticDrag : public Effect {
 public:
  explicit QuadraticDrag(const QuadraticDragOptions& options) : options_(options) {}
  const EffectKind& kind() const override { return QuadraticDragOptions::kind(); }
  DragLaw drag(const Bodies&, int) const override {
    if (!options_.is_declared) return {};
    return {.nonlinear = [c = options_.coefficient](double v) { return DragForce{c * v * v, 2 * c * v}; }};
  }
  void add_forces(const State& state, std::span<double> force) const override {
    const Bodies& b = state.bodies;
    for (int k = 0; k < std::ssize(force) && !options_.is_declared; ++k)
      force[k] -=
          options_.coefficient * norm(velocity_in_space(b, k / b.dimension)) * b.momentum[k] / b.mass[k / b.dimension];
  }

 private:
  QuadraticDragOptions options_;
};

const EffectKind& QuadraticDragOptions::kind() {
  static const EffectKind kind = {.name = "quadratic_drag",
                                  .description = "drag at high Reynolds number",
                                  .help = "Drag c v^2.",
                                  .options = QuadraticDragOptions{},
                                  .make = [](const Scene& scene) {
                                    return std::make_unique<QuadraticDrag>(*scene.effects.find<QuadraticDragOptions>());
                                  }};
  return kind;
}

constexpr double speed = 0.05, end = 0.5;             // m/s and s
const Vec2 start = {0.02, 0.03}, along = {0.6, 0.8};  // In m; direction of the velocity.

struct Choice {
  Integrator integrator;
  FieldCoupling coupling;
  bool has_field = true, leaks = true;  ///< A conducting fluid makes a circuit with an energy balance.
};

/// Scene of one uncharged conductor.
Scene one_conductor(const Choice& choice) {
  Scene scene = steel_spheres::scene_of({start});
  scene.conductors[0].velocity = in_space(speed * along);
  scene.mechanics.integrator = choice.integrator;
  scene.mechanics.coupling = choice.coupling;
  if (choice.has_field) scene.effects.add<effects::FloatingConductorsOptions>();
  if (choice.leaks) scene.effects.add(effects::LeakageOptions{.conductivity = 1e-12});
  return scene;
}

struct Outcome {
  ConductorFrame frame;
  bool warns;  ///< Whether the energy balance gives a warning.
};

Outcome run(Scene scene, const QuadraticDragOptions& drag = {}) {
  scene.effects.add(drag);
  Simulation simulation(scene, steel_spheres::no_forces());
  simulation.advance_to(end);
  const auto is_of_energy = [](const std::string& w) { return w.starts_with("energy balance off"); };
  return {simulation.now(), std::ranges::any_of(simulation.summary().warnings, is_of_energy)};
}

}  // namespace

TEST_CASE("user-defined quadratic drag: closed form and heat with each integrator") {
  const double k = QuadraticDragOptions{}.coefficient / mass;                                 // 1/m
  const double path = std::log1p(k * speed * end) / k, left = speed / (1 + k * speed * end);  // m and m/s
  using enum FieldCoupling;
  constexpr auto cvode = Integrator::cvode, euler = Integrator::euler;
  for (const Choice& how : {Choice{cvode, split, false, false}, Choice{cvode, split, true, false}, Choice{cvode, split},
                            Choice{cvode, monolithic}, Choice{euler, split}}) {
    CAPTURE(name_of(how.integrator));
    CAPTURE(name_of(how.coupling));
    const Scene scene = one_conductor(how);
    const auto [frame, warns] = run(scene);
    // Relative errors of v and of the path. CVODE: each of some hundred steps may have an error of the tolerance.
    // Euler: the errors per step, dt^2 / 2 times the largest second derivatives 2 k^2 v^3 of v and k v^2 of x,
    // accumulate without growth.
    const double dt = scene.mechanics.euler_step;
    const bool is_euler = how.integrator == euler;
    const double slower = is_euler ? dt * end * k * k * speed * speed * speed : 300 * 1e-6 * speed;
    const double off = is_euler ? end * (slower + dt / 2 * k * speed * speed) : 300 * 1e-6 * steel_spheres::radius;
    CHECK(std::abs(dot(plane(frame.velocity[0]), along) - left) < slower);
    CHECK(std::abs(dot(plane(frame.position[0]) - start, along) - path) < off);
    if (!how.leaks) continue;
    const double lost = mass / 2 * (speed * speed - left * left), part = is_euler ? 2 * k * speed * dt : 600 * 1e-6;
    CHECK(frame.energy_balance->flows.drag == doctest::Approx(lost).epsilon(part).scale(0));
    CHECK(!warns);
  }
}

TEST_CASE("quadratic drag not declared as drag: equal motion but energy warning") {
  const Scene scene = one_conductor({Integrator::cvode, FieldCoupling::split});
  const Outcome plain = run(scene, {.is_declared = false});
  CHECK(steel_spheres::largest_distance(plain.frame, run(scene).frame) < 1e-3 * steel_spheres::radius);
  CHECK(plain.warns);
}

}  // namespace extend_drag_law
