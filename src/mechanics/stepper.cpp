#include "src/mechanics/stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::mechanics {

namespace {

using Maker = std::unique_ptr<Stepper> (*)(const StepperContext&);

constexpr std::pair<const IntegratorKind*, Maker> built_in[] = {
    {&integrators::cvode, make_split}, {&integrators::monolithic, make_monolithic}, {&integrators::euler, make_euler}};
static_assert(integrators::have_all(built_in, &IntegratorKind::moves_conductors));

std::map<const IntegratorKind*, Maker>& makers() {
  static std::map<const IntegratorKind*, Maker> all(std::begin(built_in), std::end(built_in));
  return all;
}

}  // namespace

void add_integrator(const IntegratorKind& kind, Maker make) {
  if (!kind.moves_conductors)
    throw InputError(fmt::format("the integrator \"{}\" must set moves_conductors = true", kind.name));
  list_integrator(kind);
  makers()[&kind] = make;
}

std::unique_ptr<Stepper> make_stepper(const StepperContext& context) {
  const IntegratorKind& kind = context.scene.mechanics.kind();
  if (context.electrics && !kind.carries_resistors && effects::has_resistors(context.scene))
    throw InputError(fmt::format(
        "{}: mechanics.integrator = \"{}\" with coupling = \"{}\" cannot move the charge that resistors and contacts "
        "carry at a finite rate: take \"cvode\" with coupling = \"split\"",
        context.scene.path, kind.name, kind.solves_field_inside ? "monolithic" : "split"));
  const auto found = makers().find(&kind);
  if (found != makers().end()) return found->second(context);
  throw InputError(fmt::format("{}: mechanics.integrator = \"{}\" does not move conductors: the integrators {} do",
                               context.scene.path, kind.name, names_of(&IntegratorKind::moves_conductors)));
}

Cvode make_cvode(const Scene& scene, Model& model) {
  const Bodies& bodies = model.bodies;
  const double smallest = *std::ranges::min_element(bodies.radius);
  Accuracy accuracy{.relative = scene.mechanics.relative_tolerance,
                    .position = scene.mechanics.relative_tolerance * smallest,
                    .momentum = {}};
  const std::span<const double> drag = model.drag.linear();
  for (int i = 0; i < bodies.size(); ++i)
    accuracy.momentum.push_back(std::max(drag[i], bodies.mass[i] / scene.mechanics.largest_step) * accuracy.position);
  return Cvode(model, accuracy);
}

namespace {

/// Returns the heat (J) of Effect::dissipated_power in a step of length dt (s) to the present state, by Simpson's rule
/// on eight parts. States within the step are on the cubic through positions (m) and momenta (kg m/s) at both ends.
/// The elastic energy that remains at the end of a damped force is lost while the overlap falls to 0, often within one
/// step. For a power that falls linearly to 0 within the step, the error is at most 1/48 of its first value times the
/// step; with one part it would be 1/6.
double heat_of_losses(Model& model, double dt, const std::vector<double>& position,
                      const std::vector<double>& momentum) {
  Bodies& bodies = model.bodies;
  const std::vector<double> last_position = bodies.position, last_momentum = bodies.momentum;
  const double after = model.dissipated_power(0);
  const auto power_at = [&](double s) {
    for (std::size_t c = 0; c < position.size(); ++c) {
      const double mass = bodies.mass[c / bodies.dimension], mean = (last_position[c] - position[c]) / dt;
      const double v0 = momentum[c] / mass, v1 = last_momentum[c] / mass;
      const double square = 3 * mean - 2 * v0 - v1, cube = v0 + v1 - 2 * mean;
      bodies.position[c] = position[c] + s * dt * (v0 + s * (square + s * cube));
      bodies.momentum[c] = mass * (v0 + s * (2 * square + s * 3 * cube));
    }
    return model.dissipated_power(0);
  };
  const double before = power_at(0);
  constexpr int parts = 8;
  double sum = before + 2 * power_at(0.5) + after;
  for (int k = 1; k < 2 * parts && sum > 0; ++k)
    if (k != parts) sum += (k % 2 == 0 ? 2 : 4) * power_at(k / (2.0 * parts));
  bodies.position = last_position, bodies.momentum = last_momentum;
  return dt / (6 * parts) * sum;
}

}  // namespace

void record_drag(const StepperContext& context, Cvode& cvode) {
  EnergyBudget* energy = context.electrics ? context.electrics->energy() : nullptr;
  const auto is_zero = [](double d) { return d == 0; };
  const bool losses = context.model.dissipates();
  const bool no_drag = context.model.drag.is_linear() && std::ranges::all_of(context.model.drag.linear(), is_zero);
  if (!energy || (no_drag && !losses)) return;
  cvode.after_step = [energy, losses, &model = context.model, &bodies = context.model.bodies,
                      &drag = context.model.drag](double dt, const std::vector<double>& position,
                                                  const std::vector<double>& momentum) {
    double work = losses ? heat_of_losses(model, dt, position, momentum) : 0;
    for (int i = 0; i < bodies.size(); ++i) {
      Vec3 velocity[3], point[3];  // at the start, in the middle and at the end
      for (int k = 0, c = i * bodies.dimension; k < bodies.dimension; ++k, ++c) {
        const double before = momentum[c] / bodies.mass[i], after = bodies.momentum[c] / bodies.mass[i];
        const double middle = 1.5 * (bodies.position[c] - position[c]) / dt - 0.25 * (before + after);
        work += drag.linear()[i] * dt / 6 * (before * before + 4 * middle * middle + after * after);
        velocity[0][k] = before, velocity[1][k] = middle, velocity[2][k] = after;
        point[0][k] = position[c], point[2][k] = bodies.position[c];
        point[1][k] = 0.5 * (position[c] + bodies.position[c]) + dt / 8 * (before - after);
      }
      if (drag.is_linear(i)) continue;
      const auto power = [&](int k) { return drag.nonlinear_power(i, point[k], velocity[k]); };
      work += dt / 6 * (power(0) + 4 * power(1) + power(2));
    }
    energy->add_drag(work);
  };
}

}  // namespace lichtenberg::mechanics
