#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "solvers/random.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/integrator.hpp"
#include "src/scene/scene.hpp"

/// Scenes of grains of mass 1 and diameter 1 in reduced units, and their runs.
namespace lichtenberg::grains {

inline constexpr std::array all_integrators = {Integrator::multirate, Integrator::verlet, Integrator::gear,
                                               Integrator::gear_printed, Integrator::cvode};

/// Periodic cube of the given edge without grains.
inline Scene cube(double edge, Integrator integrator = Integrator::multirate) {
  Scene scene;
  scene.path = "scene";
  scene.reference.emplace();
  scene.domain.size = {edge, edge, edge};
  for (DomainSide& side : scene.domain.sides) side.periodic = true;
  scene.material.density = 6 / std::numbers::pi;
  scene.mechanics.integrator = integrator;
  scene.mechanics.step = integrator == Integrator::multirate || integrator == Integrator::cvode ? 0.05 : 0.005;
  scene.mechanics.contact_steps = 45;  // The error is 1/8 of a gas's default.
  scene.mechanics.relative_tolerance = 1e-13;
  scene.mechanics.threads = 1;
  return scene;
}

inline Scene viscoelastic(double edge, Integrator integrator = Integrator::multirate) {
  Scene scene = cube(edge, integrator);
  scene.effects.add<effects::ViscoelasticContactOptions>();
  return scene;
}

/// Scene in which charges interact by the minimum image, and contacts exchange charge.
inline Scene charged(double edge, Integrator integrator, double strength = 1, double exchange = 0.25) {
  Scene scene = viscoelastic(edge, integrator);
  scene.effects.add(effects::CoulombOptions{.strength = strength, .sum = effects::CoulombSum::minimum_image});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = exchange});
  if (integrator == Integrator::gear || integrator == Integrator::gear_printed) scene.mechanics.step = 0.0025;
  return scene;
}

/// Scene in which charges polarize each other, with the mesh.
inline Scene polarized(double edge, double strength = 1, double exchange = 0.25) {
  Scene scene = viscoelastic(edge);
  scene.effects.add(effects::CoulombOptions{.strength = strength, .accuracy = 1e-2});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.075, .tolerance = 1e-4});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = exchange});
  return scene;
}

/// Two grains of charges 1 and -1 and radius d0 / 2 in the middle of a large box, with multipoles up to the degree.
inline Scene two_dielectric_grains(double distance, int degree) {
  Scene scene = viscoelastic(60);
  scene.conductors = {{.position = {30 - distance / 2, 30, 30}, .radius = 0.5, .charge = 1},
                      {.position = {30 + distance / 2, 30, 30}, .radius = 0.5, .charge = -1}};
  scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.075, .tolerance = 1e-6, .degree = degree});
  return scene;
}

inline void add(Scene& scene, Vec3 position, Vec3 velocity = {}, double charge = 0) {
  scene.conductors.push_back({.position = position, .velocity = velocity, .radius = 0.5, .charge = charge});
}

/// Adds grains at random positions, at least 1.05 apart, in the middle cube of edge `edge`. Velocities have the
/// variance `temperature` and mean 0.
inline void add_gas(Scene& scene, int count, double edge, double temperature, std::uint64_t seed = 1) {
  Random random({.seed = seed, .purpose = RandomPurpose::population});
  const Box<3> box = scene.domain.box();
  const double low = 0.5 * (scene.domain.size.x - edge);
  const auto clear = [&](Vec3 p) {
    return std::ranges::all_of(scene.conductors,
                               [&](const Conductor& c) { return norm(box.difference(p, c.position)) > 1.05; });
  };
  const std::size_t first = scene.conductors.size();
  while (scene.conductors.size() < first + count) {
    const Vec3 p = {random.uniform(low, low + edge), random.uniform(low, low + edge), random.uniform(low, low + edge)};
    if (clear(p)) add(scene, p);
  }
  Vec3 sum{};
  for (std::size_t i = first; i < scene.conductors.size(); ++i) {
    Vec3& v = scene.conductors[i].velocity;
    for (int k = 0; k < 3; ++k) v[k] = std::sqrt(temperature) * random.normal();
    sum += v;
  }
  for (std::size_t i = first; i < scene.conductors.size(); ++i) scene.conductors[i].velocity -= sum / count;
}

inline void charge_alternately(Scene& scene, double size) {
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 == 0 ? size : -size;
}

/// A gas and its integrator.
struct Run {
  explicit Run(const Scene& scene) : gas(scene), integrator(granular::make_integrator(scene.mechanics.integrator)) {}

  void step(double end) {
    end = std::min(end, gas.stage_end());
    const double left = end - gas.time(), count = std::ceil(left / longest_step());
    step_to(count <= 1 ? end : gas.time() + left / count);
    if (gas.time() < gas.stage_end()) return;
    now = gas.leave_stage(std::move(now));
    integrator->reset_history();
  }
  double longest_step() { return integrator->longest_step(gas, now); }
  void step_to(double end) { now = integrator->step(gas, std::move(now), end, granular::Want::forces); }
  void restore(const Checkpoint& checkpoint) {
    gas.restore(checkpoint);
    integrator->restore(checkpoint);
    now = gas.instant();
  }
  void to(double end) {
    while (gas.time() < end) step(end);
  }

  granular::Gas gas;
  std::unique_ptr<granular::GasIntegrator> integrator;
  granular::Instant now = gas.instant();
};

/// Adds two grains that approach each other along x at the given relative speed, with a gap between their surfaces, in
/// the middle of the box.
inline void add_pair(Scene& scene, double speed, double gap, double charge = 0) {
  const Vec3 middle = 0.5 * scene.domain.size, half = {0.5 * (1 + gap), 0, 0}, v = {0.5 * speed, 0, 0};
  add(scene, middle - half, v, charge);
  add(scene, middle + half, -1.0 * v, -charge);
}

/// Ratio of separation to approach speed in a head-on collision that begins after `phase` steps of the integrator.
inline double restitution(Scene scene, double speed, double phase) {
  add_pair(scene, speed, 1e-9 + phase * scene.mechanics.step * speed);
  Run run(scene);
  const double before = norm(velocity<3>(run.gas.bodies(), 1) - velocity<3>(run.gas.bodies(), 0));
  while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 1);
  return norm(velocity<3>(run.gas.bodies(), 1) - velocity<3>(run.gas.bodies(), 0)) / before;
}

inline double momentum(const Bodies& b) {
  Vec3 sum{};
  for (int i = 0; i < b.size(); ++i) sum += b.mass[i] * velocity<3>(b, i);
  return norm(sum);
}
/// Total momentum expected for random directions, for grains of mass 1.
inline double thermal_momentum(const granular::Gas& gas) {
  return std::sqrt(2 * gas.bodies().size() * std::max(gas.kinetic_energy(), 1e-300));
}

}  // namespace lichtenberg::grains
