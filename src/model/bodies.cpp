#include "src/model/bodies.hpp"

#include <algorithm>
#include <numbers>

#include "src/scene/scene.hpp"

namespace lichtenberg {

Bodies make_bodies(const Scene& scene) {
  Bodies bodies;
  for (const Conductor& conductor : scene.conductors) {
    const double r = conductor.radius;
    const double mass = 4.0 / 3.0 * std::numbers::pi * scene.material.density * r * r * r;
    bodies.position.insert(bodies.position.end(), {conductor.position.x, conductor.position.y});
    bodies.momentum.insert(bodies.momentum.end(), {mass * conductor.velocity.x, mass * conductor.velocity.y});
    bodies.mass.push_back(mass);
    bodies.radius.push_back(r);
  }
  return bodies;
}

std::vector<double> initial_charges(const Scene& scene) {
  std::vector<double> charge;
  for (const Conductor& conductor : scene.conductors) {
    charge.push_back(conductor.charge);
    if (conductor.group < 0) continue;
    const auto members = std::ranges::count(scene.conductors, conductor.group, &Conductor::group);
    charge.back() = scene.groups[conductor.group].charge / static_cast<double>(members);
  }
  return charge;
}

}  // namespace lichtenberg
