#include "src/granular/active_grains.hpp"

#include "src/granular/rough_motion.hpp"

namespace lichtenberg::granular {

void ActiveGrains::begin(const Bodies& bodies, std::span<const double> slow_force, double h) {
  bodies_ = &bodies, slow_force_ = slow_force, h_ = h;
  index_.assign(bodies.size(), -1);
  active_.clear();
  flight_.resize(bodies.size());
  for (int i = 0; i < bodies.size(); ++i) {
    const double per_mass = 1 / bodies.mass[i];
    flight_[i].position = position_in_space(bodies, i);
    flight_[i].velocity = per_mass * vector_at(bodies.momentum, bodies.dimension, i);
    flight_[i].acceleration = slow_force.empty() ? Vec3{} : per_mass * vector_at(slow_force, bodies.dimension, i);
  }
}

int ActiveGrains::activate(int grain, int n) {
  const Flight& flight = flight_[grain];
  ActiveGrain one{.grain = grain, .per_mass = 1 / bodies_->mass[grain], .radius = bodies_->radius[grain]};
  one.position = position(grain, n);
  one.velocity = flight.velocity + n * h_ * flight.acceleration;
  one.slow = flight.acceleration;
  if (!bodies_->inertia.empty()) one.per_inertia = 1 / bodies_->inertia[grain], one.spin = spin_of(*bodies_, grain);
  index_[grain] = static_cast<int>(active_.size());
  active_.push_back(one);
  return index_[grain];
}

double ActiveGrains::finish(Bodies& bodies, int n) {
  double work = 0;
  const double t = n * h_;
  const int d = bodies.dimension;
  for (int i = 0; i < bodies.size(); ++i) {
    const ActiveGrain* one = index_[i] >= 0 ? &active_[index_[i]] : nullptr;
    const Vec3 after = position(i, n);
    work += bodies.mass[i] * dot(flight_[i].acceleration, after - flight_[i].position);
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
