#include "src/commands/cost.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <new>
#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/mechanics/simulation.hpp"

namespace lichtenberg {

namespace {

/// Returns the number of floating groups at the start. Conductors already in contact then form one group.
double floating_groups(const Scene& scene) {
  const effects::ElectricalGroups groups = effects::groups_at_start(scene, make_bodies(scene));
  double floating = 0;
  for (std::size_t i = 0; i < groups.id.size(); ++i)
    if (groups.id[i] == static_cast<int>(i) && !groups.potential[i]) ++floating;
  return floating;
}

/// Returns the area fraction of the conductors.
double share_of_area(const Scene& scene) {
  double area = 0;
  for (const Conductor& conductor : scene.conductors) area += std::numbers::pi * conductor.radius * conductor.radius;
  return area / (scene.domain.size.x * scene.domain.size.y);
}

bool has_injection_drag_and_discharge(const Scene& scene) {
  Model model = effects::make_model_without_field(scene);
  std::vector<double> current(model.bodies.size());
  model.currents(0, current);
  return current.front() != 0 && model.drag.is_linear() && model.drag.linear().front() > 0 &&
         number_in(scene, &EffectKind::contact_gap);
}

/// Estimates the field solves of a plane scene from runs of 324, 2500 and 20000 conductors (docs/numerics/coupling.md).
/// `groups_by_filling`: floating groups divided by the conductors' area fraction. With many groups, more group merges
/// share one solve.
FieldSolves solves_in_plane(const Scene& scene, double groups_by_filling) {
  constexpr double half_shared = 3e4;
  const double radius = scene.smallest_radius();
  const double tolerance = scene.mechanics.position_tolerance / radius / 1e-3;  // over the default
  const double predictions = 13 * groups_by_filling / (1 + groups_by_filling / half_shared) * std::pow(tolerance, -0.4);
  // If the grid follows from an accuracy, its size is not given here, so predictions on a coarser grid are not counted.
  if (scene.field_request() || effects::predictor_cells(scene) == 0) return {.whole = 0.6 * predictions};
  return {.whole = 0.085 / std::sqrt(tolerance) * predictions, .predictions = predictions};
}

constexpr double bytes_at_start = 40e6;  // memory of PETSc and other libraries

/// Returns the fraction of the domain that the conductors fill; overlaps count twice.
double filling(const Scene& scene) {
  const bool in_space = scene.dimension() == 3;
  double content = 0;
  for (const Conductor& c : scene.conductors)
    content += in_space ? 4.0 / 3 * std::pow(c.radius, 3) : std::pow(c.radius, 2);
  const Vec3 size = scene.domain.size;
  return std::numbers::pi * content / (size.x * size.y * (in_space ? size.z : 1));
}

/// Returns the iterations of lbfgs-newton as a function of the distance to the jamming density
/// (docs/measurements/packing_speed.json).
double iterations_to_rest(double filling, double particles, bool in_space) {
  const double above = filling - (in_space ? 0.63 : 0.842), far = 22 * std::sqrt(particles);
  if (above >= 0) return far * (1 + 0.02 / (above + 0.003));
  return std::max(500.0, far * (1 + 0.02 / 0.003) * std::exp(above / 0.012));
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

FieldCost estimate_field_cost(const FieldOptions& options, double size) {
  const auto [price, around, share_in_motion] = field_method_cost(options);
  return {.bytes = bytes_at_start + price.bytes * size,
          .single_seconds = price.seconds(size, options.tolerance),
          .moving_seconds = price.seconds(size, options.moving_tolerance, share_in_motion)};
}

FieldCost estimate_sphere_cost(const FieldOptions& options, double single_unknowns, double moving_unknowns) {
  FieldCost cost = estimate_field_cost(options, std::max(single_unknowns, moving_unknowns));
  cost.single_seconds = estimate_field_cost(options, single_unknowns).single_seconds;
  cost.moving_seconds = estimate_field_cost(options, moving_unknowns).moving_seconds;
  return cost;
}

std::optional<FieldSolves> estimate_field_solves(const Scene& scene) {
  if (const auto step = scene.mechanics.kind().field_step)
    return FieldSolves{.whole = scene.stop.time / (scene.mechanics.*step)};
  if (!has_injection_drag_and_discharge(scene)) return std::nullopt;
  const double groups_by_filling = floating_groups(scene) / share_of_area(scene);
  if (scene.dimension() == 2) return solves_in_plane(scene, groups_by_filling);
  return scene.mechanics.fix_z ? std::optional(FieldSolves{.whole = 0.93 * std::pow(groups_by_filling, 1.2)})
                               : std::nullopt;
}

std::optional<PackingCost> estimate_packing_cost(const Scene& scene) {
  struct Method {
    double iterations, seconds;  // relative to lbfgs-newton
  };
  const auto method = [&]() -> std::optional<Method> {
    switch (scene.minimize.method) {
      case MinimizeMethod::lbfgs_newton:
        return Method{1, 1};
      case MinimizeMethod::lbfgs:
        return Method{1.2, 1.1};
      case MinimizeMethod::newton_cg:
        return Method{1.2, 4};
      case MinimizeMethod::fire:
        return Method{8, 5};
      case MinimizeMethod::gradient_descent:
        break;
    }
    return std::nullopt;
  }();
  if (!method) return std::nullopt;
  const bool in_space = scene.dimension() == 3;
  const double seconds_a_particle = in_space ? 9e-8 : 6e-8;  // per iteration
  const double particles = static_cast<double>(scene.conductors.size());
  PackingCost cost{.filling = filling(scene)};
  const double iterations = iterations_to_rest(cost.filling, particles, in_space);
  cost.iterations = std::min(method->iterations * iterations, static_cast<double>(scene.minimize.max_iterations));
  cost.seconds = method->seconds / method->iterations * cost.iterations * particles * seconds_a_particle;
  return cost;
}

std::optional<TrialRun> run_trial(const Scene& scene) {
  constexpr double most_seconds = 2, least_share = 0.005;
  const double began = processor_seconds();
  const auto pause = [&] { return processor_seconds() - began > most_seconds; };
  try {
    Simulation motion(scene);
    const double ready = processor_seconds();
    try {
      while (!motion.finished() && !pause()) motion.advance_to(motion.next_frame(), pause);
    } catch (const Paused&) {
    }
    const double spent = processor_seconds() - ready, share = motion.time() / motion.end_time();
    const bool over = motion.finished();
    if (over) return TrialRun{motion.time(), over, spent};
    if (!(share >= least_share)) return std::nullopt;
    return TrialRun{motion.time(), over, spent / share};
  } catch (const Failure&) {
  } catch (const InputError&) {
  } catch (const std::bad_alloc&) {
  }
  return std::nullopt;
}

}  // namespace lichtenberg
