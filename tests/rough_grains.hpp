#pragma once

#include <cmath>

#include "src/effects/adhesion.hpp"
#include "src/effects/flat_walls.hpp"
#include "src/effects/friction.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/uniform_force.hpp"
#include "tests/grains.hpp"

/// Scenes of grains with friction, adhesion or walls, of mass 1 and diameter 1 in reduced units.
namespace lichtenberg::grains {

/// Periodic cube with the linear contact and friction.
inline Scene frictional(double edge, const effects::LinearContactOptions& contact,
                        const effects::FrictionOptions& friction) {
  Scene scene = cube(edge);
  scene.effects.add(contact);
  scene.effects.add(friction);
  return scene;
}

/// Makes all sides of the scene walls along these axes.
inline void add_walls(Scene& scene, std::initializer_list<int> axes, const effects::FlatWallsOptions& walls = {}) {
  for (const int k : axes) scene.domain.sides[2 * k].periodic = scene.domain.sides[2 * k + 1].periodic = false;
  scene.effects.add(walls);
}

/// Total momentum, and angular momentum about the origin with rotation. No grain may have crossed a side.
struct Momenta {
  Vec3 linear{}, angular{};
};
inline Momenta momenta(const Bodies& b) {
  Momenta sum;
  for (int i = 0; i < b.size(); ++i) {
    const Vec3 p = vector_at(b.momentum, b.dimension, i);
    sum.linear += p;
    sum.angular += cross(position_in_space(b, i), p);
    if (!b.inertia.empty()) sum.angular += b.inertia[i] * granular::spin_of(b, i);
  }
  return sum;
}

/// Runs until a contact has begun and ended.
inline void run_collision(Run& run) {
  while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 0.05);
}

}  // namespace lichtenberg::grains
