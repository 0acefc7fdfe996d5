#include "src/mechanics/step_check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::mechanics {

StepCheck::StepCheck(const Model& model, std::string integrator, bool checks_moves)
    : model_(model),
      integrator_(std::move(integrator)),
      largest_move_(checks_moves ? model.largest_move() : INFINITY) {}

void StepCheck::begin() {
  committed_ = 0;
  if (std::isfinite(largest_move_)) position_ = model_.bodies.position;
}

void StepCheck::between_steps() {
  if (position_.empty()) return;
  const Bodies& bodies = model_.bodies;
  for (int i = 0; i < bodies.size(); ++i) {
    const Vec3 before = vector_at(position_, bodies.dimension, i);
    const double move = norm(bodies.box.difference(position_in_space(bodies, i), before));
    if (!(move <= largest_move_))
      throw Failure(fmt::format(
          "mechanics.integrator = \"{}\" moved conductor {} by {:.3g} m in one step, but the effects allow {:.3g} m: "
          "shorter steps are needed",
          integrator_, i, move, largest_move_));
  }
  position_ = bodies.position;
}

void StepCheck::end(double begin, double end) {
  between_steps();
  constexpr double rounding = 1e-6;
  if (!(std::abs(committed_ - (end - begin)) <= rounding * (end - begin)))
    throw Failure(
        fmt::format("mechanics.integrator = \"{}\" advanced from {:g} s to {:g} s, but committed steps of {:g} s: an "
                    "integrator must "
                    "call StepperContext::commit once after each step",
                    integrator_, begin, end, committed_));
}

}  // namespace lichtenberg::mechanics
