#include "src/granular/active_grains.hpp"

#include <algorithm>

#include "src/granular/rough_motion.hpp"

namespace lichtenberg::granular {

void ActiveGrains::begin(const Bodies& bodies, std::span<const double> slow_force, double h,
                         std::span<const int> grains, std::span<const int> slots) {
  bodies_ = &bodies, slow_force_ = slow_force, h_ = h, grains_ = grains, slots_ = slots;
  index_.assign(bodies.size(), -1);
  active_.clear();
  flight_.resize(bodies.size());
  constexpr int ahead = 16;
  const int n = bodies.size(), d = bodies.dimension;
  for (int s = 0; s < n; ++s) {
    const int later = grains[std::min(s + ahead, n - 1)], i = grains[s];
    __builtin_prefetch(&bodies.position[later * d]);
    __builtin_prefetch(&bodies.momentum[later * d]);
    const double per_mass = 1 / bodies.mass[i];
    flight_[s].position = position_in_space(bodies, i);
    flight_[s].velocity = per_mass * vector_at(bodies.momentum, d, i);
    flight_[s].acceleration = slow_force.empty() ? Vec3{} : per_mass * vector_at(slow_force, d, i);
    flight_[s].radius = bodies.radius[i];
  }
}

int ActiveGrains::activate(int slot, int n) {
  const Flight& flight = flight_[slot];
  const int grain = grains_[slot];
  ActiveGrain& one = active_.emplace_back();
  one.grain = grain, one.slot = slot, one.per_mass = 1 / bodies_->mass[grain], one.radius = flight.radius;
  one.position = position(slot, n);
  one.velocity = flight.velocity + n * h_ * flight.acceleration;
  one.start = flight.velocity, one.slow = flight.acceleration;
  if (!bodies_->inertia.empty()) one.per_inertia = 1 / bodies_->inertia[grain], one.spin = spin_of(*bodies_, grain);
  return index_[slot] = static_cast<int>(active_.size()) - 1;
}

double ActiveGrains::finish(Bodies& bodies, int n) {
  double work = 0;
  const double t = n * h_;
  const int d = bodies.dimension;
  for (int i = 0; i < bodies.size(); ++i) {
    const int index = index_[slots_[i]];
    const ActiveGrain* one = index >= 0 ? &active_[index] : nullptr;
    const double per_mass = 1 / bodies.mass[i];
    const Vec3 a = slow_force_.empty() ? Vec3{} : per_mass * vector_at(slow_force_, d, i);
    const Vec3 before = position_in_space(bodies, i), v = per_mass * vector_at(bodies.momentum, d, i);
    const Vec3 after = one ? one->position : before + t * (v + 0.5 * t * a);
    work += bodies.mass[i] * dot(a, after - before);
    for (int k = 0; k < d; ++k) {
      bodies.position[i * d + k] = after[k];
      double& momentum = bodies.momentum[i * d + k];
      if (one)
        momentum = bodies.mass[i] * one->velocity[k];
      else if (!slow_force_.empty())
        momentum += t * slow_force_[i * d + k];
    }
    if (!one || bodies.inertia.empty()) continue;
    for (int k = 0; k < 3 && d == 3; ++k) bodies.angular_velocity[3 * i + k] = one->spin[k];
    if (d == 2) bodies.angular_velocity[i] = one->spin.z;
  }
  return work;
}

}  // namespace lichtenberg::granular
