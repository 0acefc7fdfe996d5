#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/scene/scene.hpp"

/// Scenes of D's spheres, and a field solver with given forces.
namespace lichtenberg::steel_spheres {

inline constexpr double radius = 0.775e-3;                                                  // m
inline const double mass = 4.0 / 3.0 * std::numbers::pi * 8050 * radius * radius * radius;  // 1.57e-5 kg
inline const double drag = 6 * std::numbers::pi * 0.7 * radius;                             // 1.02e-2 kg/s
inline const double relaxation = mass / drag;                                               // 1.53 ms

/// Scene of spheres of D's size and material in a box of 10 cm of castor oil, without effects.
inline Scene scene_of(const std::vector<Vec2>& positions) {
  Scene scene;
  scene.domain.size = {0.1, 0.1};
  scene.medium = {.permittivity = 4.2e-11, .viscosity = 0.7, .depth = 2 * radius};
  for (const Vec2 position : positions) scene.conductors.push_back({.position = in_space(position), .radius = radius});
  scene.mechanics.position_tolerance = 1e-3 * radius;
  scene.mechanics.largest_step = 0.1;
  return scene;
}

/// Scene as above with a field, contacts at a gap of one radius, and drag.
inline Scene conductor_scene(const std::vector<Vec2>& positions) {
  Scene scene = scene_of(positions);
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.01});
  scene.effects.add<effects::StokesDragOptions>();
  return scene;
}

/// Scene of steel spheres in a cube of castor oil with insulating sides, 6 cm long.
inline Scene cube_of(const std::vector<Vec3>& positions, double accuracy) {
  Scene scene = scene_of({});
  scene.domain.size = {0.06, 0.06, 0.06};
  for (const Vec3 position : positions) scene.conductors.push_back({.position = position, .radius = radius});
  scene.field_table = FieldOptions{.method = &spheres_method(), .moving_tolerance = accuracy};
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add<effects::StokesDragOptions>();
  return scene;
}

inline Electrode ball(std::string name, Vec2 centre, double potential) {
  return {std::move(name), Disk{centre, radius}, potential};
}

/// Scene of twelve charged conductors around a grounded ball: contacts of all kinds close and open.
inline Scene random_spheres(unsigned seed = 7) {
  Scene scene = conductor_scene({});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(0.042, 0.058);
  while (scene.conductors.size() < 12) {
    const Vec2 p = {coordinate(random), coordinate(random)};
    const bool free =
        norm(p - Vec2{0.05, 0.05}) > 2.2 * radius && std::ranges::all_of(scene.conductors, [&](const Conductor& c) {
          return norm(p - plane(c.position)) > 2.2 * radius;
        });
    if (free) scene.conductors.push_back({.position = in_space(p), .radius = radius, .charge = 2e-12});
  }
  scene.electrodes = {ball("ground", {0.05, 0.05}, 0)};
  scene.effects.add(effects::CurrentInjectionOptions{.current = 0.2e-9});
  scene.effects.add<effects::HertzContactOptions>();
  scene.effects.add<effects::WallContactOptions>();
  return scene;
}

/// Field solver whose forces (N, for the scenes' depth) are a given function of the problem. Members of a group have
/// equal shares of its charge; fixed groups have none.
class Scripted : public laplace::LaplaceSolver {
 public:
  using Forces = std::function<std::vector<Vec2>(const laplace::LaplaceProblem&)>;
  explicit Scripted(Forces forces) : forces_(std::move(forces)) {}
  laplace::LaplaceSolution solve(const laplace::LaplaceProblem& problem) override {
    laplace::LaplaceSolution solution;
    std::vector<int> members(problem.groups.size());
    for (const laplace::Body& body : problem.bodies) ++members[body.group];
    for (const laplace::Body& body : problem.bodies) {
      const laplace::Group& group = problem.groups[body.group];
      solution.body_charge.push_back(group.floating ? group.charge / members[body.group] : 0);
    }
    for (const Vec2 force : forces_(problem)) solution.body_force.push_back(force / (2 * radius));
    solution.group_potential.resize(problem.groups.size());
    return solution;
  }
  laplace::Field field() const override { return {}; }
  void forget() override {}

 private:
  Forces forces_;
};

inline std::unique_ptr<laplace::LaplaceSolver> scripted(Scripted::Forces forces) {
  return std::make_unique<Scripted>(std::move(forces));
}

/// Solver that gives no forces.
inline std::unique_ptr<laplace::LaplaceSolver> no_forces() {
  return scripted([](const laplace::LaplaceProblem& problem) { return std::vector<Vec2>(problem.bodies.size()); });
}

inline Vec2 centre(const laplace::LaplaceProblem& problem, int body) {
  return std::get<Disk>(problem.bodies[body].shape).centre;
}

inline double largest_distance(const ConductorFrame& a, const ConductorFrame& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i) largest = std::max(largest, norm(a.position[i] - b.position[i]));
  return largest;
}

inline double total(const std::vector<double>& charge) {
  double sum = 0;
  for (const double q : charge) sum += q;
  return sum;
}

/// Charge imbalance (C), which should be zero at every instant; `initial` is the sum of all charges at the start.
inline double imbalance(const ConductorFrame& frame, double initial) {
  return std::abs(frame.charge_held + frame.charge_drained - frame.charge_fed - initial);
}

}  // namespace lichtenberg::steel_spheres
