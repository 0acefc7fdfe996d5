#include "src/effects/contact_losses.hpp"

#include <algorithm>
#include <cmath>

#include "src/model/linear_spring.hpp"

namespace lichtenberg::effects {

ContactLoss::ContactLoss(const ContactLosses& losses)
    : losses_(losses),
      // A linear contact of unit stiffness and mass has the damping 2 z.
      damping_ratio_(losses.restitution < 1 ? 0.5 * linear_damping(1, losses.restitution, 1) : 0) {}

LossForce ContactLoss::operator()(const HertzForce& elastic, double effective_mass, Vec3 normal, Vec3 velocity) const {
  const double dashpot = damping_ratio_ * std::sqrt(10.0 / 3.0 * effective_mass * elastic.stiffness);
  const double closing = -dot(velocity, normal);
  const double total = std::max(elastic.force + dashpot * closing, 0.0), damping = total > 0 ? dashpot : 0;
  const Vec3 sliding = velocity + closing * normal;
  const double speed = std::sqrt(norm2(sliding) + losses_.friction_speed * losses_.friction_speed);
  const Vec3 direction = sliding / speed;  // shorter than 1 at small speeds
  const double friction = losses_.friction * total;
  LossForce loss{.force = (total - elastic.force) * normal - friction * direction,
                 .power = (total - elastic.force) * closing + friction * dot(direction, sliding)};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const double across = (row == column) - normal[row] * normal[column] - direction[row] * direction[column];
      loss.slope[row][column] = -damping * normal[row] * normal[column] - friction / speed * across +
                                losses_.friction * damping * direction[row] * normal[column];
    }
  return loss;
}

void add_loss(const LossForce& loss, int i, int j, const Bodies& bodies, ForceJacobian& jacobian) {
  const int d = bodies.dimension;
  const auto add = [&](int row_body, int column_body, double sign) {
    for (int row = 0; row < d; ++row)
      for (int column = 0; column < d; ++column)
        jacobian.by_momentum.push_back(
            {row_body * d + row, column_body * d + column, sign * loss.slope[row][column] / bodies.mass[column_body]});
  };
  add(i, i, 1);
  if (j < 0) return;
  add(i, j, -1);
  add(j, i, -1);
  add(j, j, 1);
}

}  // namespace lichtenberg::effects
