#include "src/model/bodies.hpp"

#include <fmt/format.h>

#include <numbers>

#include "solvers/error.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

template <int d>
void wrap_all(Bodies& bodies) {
  const Box<d> box = spheres<d>(bodies).box;
  if (!box.any_periodic()) return;
  bodies.image.resize(bodies.position.size(), 0);
  for (int i = 0; i < bodies.size(); ++i) {
    Vec<d> p;
    bool inside = true;
    for (int k = 0; k < d; ++k) {
      p[k] = bodies.position[i * d + k];
      inside &= p[k] >= 0 && p[k] < box.lengths[k];
    }
    if (inside) continue;
    Image<d> image{};
    box.wrap(p, image);
    for (int k = 0; k < d; ++k) {
      bodies.position[i * d + k] = p[k];
      bodies.image[i * d + k] += image[k];
    }
  }
}

}  // namespace

void wrap(Bodies& bodies) { bodies.dimension == 3 ? wrap_all<3>(bodies) : wrap_all<2>(bodies); }

void check_dimension(const Bodies& bodies, int d) {
  if (bodies.dimension != d)
    throw InputError(
        fmt::format("the bodies have {} dimensions, but what they are asked for is for {} only", bodies.dimension, d));
}

namespace {

/// What is held has so much inertia that no force moves it by as much as a last digit.
constexpr double held_inertia = 0x1p100;

}  // namespace

Bodies make_bodies(const Scene& scene) {
  Bodies bodies{.dimension = scene.dimension(),
                .keep_height = scene.mechanics.keep_height && scene.dimension() == 3,
                .box = scene.domain.box()};
  for (const Conductor& conductor : scene.conductors) {
    const double r = conductor.radius;
    const double inertia = conductor.held ? held_inertia : 1;
    const double mass = inertia * (4.0 / 3.0 * std::numbers::pi * scene.material.density * r * r * r);
    for (int k = 0; k < bodies.dimension; ++k) {
      bodies.position.push_back(conductor.position[k]);
      bodies.momentum.push_back(mass * conductor.velocity[k]);
    }
    bodies.mass.push_back(mass);
    bodies.radius.push_back(r);
  }
  wrap(bodies);
  return bodies;
}

double kinetic_energy(const Bodies& bodies) {
  double energy = 0;
  for (int i = 0; i < bodies.size(); ++i)
    energy += norm2(vector_at(bodies.momentum, bodies.dimension, i)) / (2 * bodies.mass[i]);
  return energy;
}

std::vector<double> initial_charges(const Scene& scene) {
  std::vector<int> members(scene.groups.size(), 0);
  for (const Conductor& conductor : scene.conductors)
    if (conductor.group >= 0) ++members[conductor.group];
  std::vector<double> charge;
  for (const Conductor& conductor : scene.conductors)
    charge.push_back(conductor.group < 0 ? conductor.charge
                                         : scene.groups[conductor.group].charge / members[conductor.group]);
  return charge;
}

}  // namespace lichtenberg
