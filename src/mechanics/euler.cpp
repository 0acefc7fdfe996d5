#include <cmath>

#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {
namespace {

/// Returns the number of equal steps of at most `step` in an interval, with a tolerance for the rounding of times.
int steps_in(double interval, double step) { return std::max(1, static_cast<int>(std::ceil(interval / step - 1e-6))); }

/// Explicit Euler scheme with a fixed step (D 6.42, whose second line lacks a plus sign). Field and contacts are
/// updated once in a field step, and the electric force is constant until the next update. It has no error control and
/// is a reference for the other integrators.
class Euler : public Stepper {
 public:
  explicit Euler(const StepperContext& context) : context_(context), force_(context_.model.bodies.position.size()) {}
  void begin(double) override {}
  void advance(double time, double end) override;

 private:
  void mechanical_steps(double time, double end);

  StepperContext context_;
  std::vector<double> force_;  ///< N
};

void Euler::advance(double time, double end) {
  const double start = time;
  const int intervals = steps_in(end - start, context_.scene.mechanics.euler_field_step);
  for (int k = 1; k <= intervals; ++k) {
    const double next = k == intervals ? end : start + (end - start) * k / intervals;
    if (context_.electrics) {
      const std::vector<Vec3>& force = context_.electrics->now().field.force;
      context_.electrics->set_extrapolation(
          {.time = time, .force = force, .force_rate = std::vector<Vec3>(force.size())});
    }
    mechanical_steps(time, next);
    ++context_.counters.steps;
    if (context_.electrics) {
      context_.electrics->accept(context_.electrics->solve(next));
      context_.electrics->reconnect(next);
    }
    context_.commit(next, next - time);
    time = next;
  }
}

void Euler::mechanical_steps(double time, double end) {
  const Stopwatch watch(context_.counters.mechanics_seconds);
  Bodies& bodies = context_.model.bodies;
  const int steps = steps_in(end - time, context_.scene.mechanics.euler_step);
  const double dt = (end - time) / steps;
  const Drag& drag = context_.model.drag;
  double drag_work = 0;
  const bool losses = context_.electrics && context_.electrics->energy() && context_.model.dissipates();
  for (int k = 0; k < steps; ++k) {
    context_.between_steps();
    context_.model.forces(time + k * dt, force_);
    if (losses) drag_work += context_.model.dissipated_power(time + k * dt) * dt;
    for (int i = 0; !drag.is_linear() && i < bodies.size(); ++i)
      drag_work += drag.nonlinear_power(i, position_in_space(bodies, i), velocity_in_space(bodies, i)) * dt;
    for (std::size_t c = 0; c < force_.size(); ++c) {
      drag_work += drag.linear()[c / bodies.dimension] *
                   std::pow(bodies.momentum[c] / bodies.mass[c / bodies.dimension], 2) * dt;
      bodies.position[c] += bodies.momentum[c] / bodies.mass[c / bodies.dimension] * dt;
      bodies.momentum[c] += force_[c] * dt;
    }
  }
  if (context_.electrics && context_.electrics->energy()) context_.electrics->energy()->add_drag(drag_work);
}

}  // namespace

std::unique_ptr<Stepper> make_euler(const StepperContext& context) { return std::make_unique<Euler>(context); }

}  // namespace lichtenberg::mechanics
