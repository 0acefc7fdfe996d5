#include "src/granular/active_grains.hpp"

namespace lichtenberg::granular {

void ActiveGrains::begin(const Bodies& bodies, std::span<const double> slow_force, double h) {
  bodies_ = &bodies, slow_force_ = slow_force, h_ = h, d_ = bodies.dimension;
  index_.assign(bodies.size(), -1);
  active_.clear();
}

Vec3 ActiveGrains::acceleration(int grain) const {
  return slow_force_.empty() ? Vec3{} : vector_at(slow_force_, d_, grain) / bodies_->mass[grain];
}

Vec3 ActiveGrains::position(int grain, int n) const {
  if (index_[grain] >= 0) return active_[index_[grain]].position;
  const double t = n * h_;
  return position_in_space(*bodies_, grain) + t * (velocity(grain) + 0.5 * t * acceleration(grain));
}

int ActiveGrains::activate(int grain, int n) {
  ActiveGrain one{.grain = grain, .per_mass = 1 / bodies_->mass[grain], .radius = bodies_->radius[grain]};
  one.position = position(grain, n);
  one.slow = acceleration(grain);
  one.velocity = velocity(grain) + n * h_ * one.slow;
  if (!bodies_->inertia.empty()) {
    one.per_inertia = 1 / bodies_->inertia[grain];
    one.spin = d_ == 3 ? vector_at(bodies_->angular_velocity, 3, grain) : Vec3{0, 0, bodies_->angular_velocity[grain]};
  }
  index_[grain] = static_cast<int>(active_.size());
  active_.push_back(one);
  return index_[grain];
}

double ActiveGrains::finish(Bodies& bodies, int n) {
  double work = 0;
  const double t = n * h_;
  for (int i = 0; i < bodies.size(); ++i) {
    const ActiveGrain* one = index_[i] >= 0 ? &active_[index_[i]] : nullptr;
    const Vec3 before = position_in_space(bodies, i), after = position(i, n);
    work += bodies.mass[i] * dot(one ? one->slow : acceleration(i), after - before);
    for (int k = 0; k < d_; ++k) {
      bodies.position[i * d_ + k] = after[k];
      double& momentum = bodies.momentum[i * d_ + k];
      if (one)
        momentum = bodies.mass[i] * one->velocity[k];
      else if (!slow_force_.empty())
        momentum += t * slow_force_[i * d_ + k];
    }
    if (!one || bodies.inertia.empty()) continue;
    for (int k = 0; k < 3 && d_ == 3; ++k) bodies.angular_velocity[3 * i + k] = one->spin[k];
    if (d_ == 2) bodies.angular_velocity[i] = one->spin.z;
  }
  return work;
}

}  // namespace lichtenberg::granular
