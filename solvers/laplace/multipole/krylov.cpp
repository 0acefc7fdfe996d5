#include "solvers/laplace/multipole/krylov.hpp"

#include <algorithm>

#include "solvers/laplace/multipole/system.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace::multipole {

Gmres::Gmres(const System& system, Eigen::VectorXd x)
    : system_(&system),
      right_(system.precondition(system.right_hand_side())),
      x_(std::move(x)),
      scale_(right_.norm()),
      projected_{0.0} {
  if (scale_ == 0)
    x_.setZero();
  else
    start();
}

/// Sets the first direction: the residual of x_.
void Gmres::start() {
  Eigen::VectorXd left = right_;
  if (!x_.isZero(0)) left -= system_->precondition(*system_ * x_);
  const double norm = left.norm();
  directions_.assign(1, left / norm);
  columns_.clear();
  rotations_.clear();
  projected_.assign(1, norm);
}

void Gmres::step() {
  stop_if_requested();
  Eigen::VectorXd next = system_->precondition(*system_ * directions_.back());
  const std::size_t size = directions_.size();
  Eigen::VectorXd column(size);
  for (std::size_t k = 0; k < size; ++k) {
    column[k] = directions_[k].dot(next);
    next -= column[k] * directions_[k];
  }
  const double norm = next.norm();
  for (std::size_t k = 0; k + 1 < size; ++k) column.applyOnTheLeft(k, k + 1, rotations_[k].adjoint());
  Eigen::JacobiRotation<double> rotation;
  double& diagonal = column[size - 1];
  rotation.makeGivens(diagonal, norm, &diagonal);
  rotations_.push_back(rotation);
  columns_.push_back(std::move(column));
  projected_.push_back(rotation.s() * projected_.back());
  projected_[size - 1] *= rotation.c();
  directions_.emplace_back(next / norm);
  ++iterations_;
}

bool Gmres::reduce_to(double tolerance) {
  constexpr int most_iterations = 1000;
  constexpr std::size_t most_numbers = 1 << 26;  // 512 MiB of directions
  const std::size_t restart = std::clamp<std::size_t>(most_numbers / std::max(1, system_->size()), 20, 200);
  while (residual() > tolerance && iterations_ < most_iterations) {
    if (columns_.size() == restart) {
      x_ = solution();
      start();
    }
    step();
  }
  return residual() <= tolerance;
}

Eigen::VectorXd Gmres::solution() const {
  Eigen::VectorXd x = x_;
  std::vector<double> left = projected_;
  for (std::size_t k = columns_.size(); k-- > 0;) {
    const double amount = left[k] / columns_[k][k];
    for (std::size_t row = 0; row < k; ++row) left[row] -= amount * columns_[k][row];
    x += amount * directions_[k];
  }
  return x;
}

}  // namespace lichtenberg::laplace::multipole
