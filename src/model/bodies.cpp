#include "src/model/bodies.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "solvers/error.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

/// Number of successive bodies that Inside::all() tests together. Few bodies leave a box within a step, so that most of
/// these tests find nothing to wrap.
constexpr int bodies_at_once = 16;

/// Tests if bodies are inside a periodic box, in a loop over components without branches.
template <int d>
class Inside {
 public:
  explicit Inside(const Box<d>& box) {
    for (int c = 0; c < components; ++c)
      if (box.periodic(c % d)) low_[c] = 0, high_[c] = box.lengths[c % d];
  }
  /// Returns true if bodies_at_once contiguous positions are all inside.
  bool all(const double* position) const {
    std::int64_t outside = 0;
    for (int c = 0; c < components; ++c) outside |= !(position[c] >= low_[c]) | !(position[c] < high_[c]);
    return outside == 0;
  }

 private:
  static constexpr int components = d * bodies_at_once;
  std::array<double, components> low_ = filled(-INFINITY), high_ = filled(INFINITY);

  static std::array<double, components> filled(double value) {
    std::array<double, components> all;
    all.fill(value);
    return all;
  }
};

template <int d>
void wrap_one(Bodies& bodies, const Box<d>& box, int i) {
  Vec<d> p;
  for (int k = 0; k < d; ++k) p[k] = bodies.position[i * d + k];
  Image<d> image{};
  box.wrap(p, image);
  for (int k = 0; k < d; ++k) {
    bodies.position[i * d + k] = p[k];
    bodies.image[i * d + k] += image[k];
  }
}

template <int d>
void wrap_all(Bodies& bodies) {
  const Box<d> box = spheres<d>(bodies).box;
  if (!box.any_periodic()) return;
  const Inside<d> inside(box);
  bodies.image.resize(bodies.position.size(), 0);
  for (int first = 0; first < bodies.size(); first += bodies_at_once) {
    const int last = std::min(bodies.size(), first + bodies_at_once);
    if (last - first == bodies_at_once && inside.all(&bodies.position[first * d])) continue;
    for (int i = first; i < last; ++i) wrap_one(bodies, box, i);
  }
}

/// Factor of the mass of fixed bodies, so large that no force changes their positions in the last digit.
constexpr double fixed_inertia = 0x1p100;

}  // namespace

void wrap(Bodies& bodies) { bodies.dimension == 3 ? wrap_all<3>(bodies) : wrap_all<2>(bodies); }

void check_dimension(const Bodies& bodies, int d) {
  if (bodies.dimension != d)
    throw InputError(
        fmt::format("the bodies have {} dimensions, but this function is for {} only", bodies.dimension, d));
}

Bodies make_bodies(const Scene& scene) {
  Bodies bodies{.dimension = scene.dimension(),
                .fix_z = scene.mechanics.fix_z && scene.dimension() == 3,
                .box = scene.domain.box()};
  for (const Conductor& conductor : scene.conductors) {
    const double r = conductor.radius;
    const double inertia = conductor.fixed ? fixed_inertia : 1;
    const double mass =
        inertia * (4.0 / 3.0 * std::numbers::pi * (scene.material.density * conductor.material.density) * r * r * r);
    for (int k = 0; k < bodies.dimension; ++k) {
      bodies.position.push_back(conductor.position[k]);
      bodies.momentum.push_back(mass * conductor.velocity[k]);
    }
    bodies.mass.push_back(mass);
    bodies.radius.push_back(r);
  }
  if (scene.reference) bodies.image.resize(bodies.position.size(), 0);  // grains record images along all axes
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
