#include "src/model/bodies.hpp"

#include <numbers>

#include "src/scene/scene.hpp"

namespace lichtenberg {

Bodies make_bodies(const Scene& scene) {
  Bodies bodies{.dimension = scene.dimension()};
  for (const Conductor& conductor : scene.conductors) {
    const double r = conductor.radius;
    const double mass = 4.0 / 3.0 * std::numbers::pi * scene.material.density * r * r * r;
    bodies.position.insert(bodies.position.end(), {conductor.position.x, conductor.position.y});
    bodies.momentum.insert(bodies.momentum.end(), {mass * conductor.velocity.x, mass * conductor.velocity.y});
    if (bodies.dimension == 3) bodies.position.push_back(conductor.z), bodies.momentum.push_back(0);
    bodies.mass.push_back(mass);
    bodies.radius.push_back(r);
  }
  return bodies;
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
