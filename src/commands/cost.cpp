#include "src/commands/cost.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/laplace/accuracy/price.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"

namespace lichtenberg {

bool runs_on_device(const FieldOptions& options) {
  return options.device == FieldDevice::cuda && options.method == FieldMethod::cut_cell &&
         options.linear_solver == FieldLinearSolver::multigrid;
}

namespace {

laplace::Price price_of(const FieldOptions& options) {
  // Sweeps of an over-relaxed lattice grow with its side (D 6.9), and with them the time of an iteration.
  if (options.method == FieldMethod::relaxation) return {16, 0, 3.5e-10 * options.cells, 60};
  if (options.method == FieldMethod::multipole) return laplace::multipole_price;
  if (options.method == FieldMethod::spheres) return laplace::spheres_price;
  if (runs_on_device(options)) return laplace::cut_cell_price_on_device;
  return options.linear_solver == FieldLinearSolver::assembled ? laplace::assembled_price : laplace::cut_cell_price;
}

/// Of the first instant: what is in contact then has no way to go.
double floating_groups(const Scene& scene) {
  const effects::ElectricalGroups groups = effects::groups_at_start(scene, make_bodies(scene));
  double floating = 0;
  for (std::size_t i = 0; i < groups.id.size(); ++i)
    if (groups.id[i] == static_cast<int>(i) && !groups.potential[i]) ++floating;
  return floating;
}

/// The conductors' share of the domain.
double share_of_area(const Scene& scene) {
  double area = 0;
  for (const Conductor& conductor : scene.conductors) area += std::numbers::pi * conductor.radius * conductor.radius;
  return area / (scene.domain.size.x * scene.domain.size.y);
}

bool is_fed_dragged_and_discharged(const Scene& scene) {
  Model model = effects::make_model_without_field(scene);
  std::vector<double> current(model.bodies.size());
  model.currents(0, current);
  return current.front() != 0 && model.drag_coefficient(scene.conductors.front().radius) > 0 &&
         number_in(scene, &EffectKind::contact_gap);
}

/// From runs of 324, 2500 and 20000 conductors (README.md of this folder). `ways`: groups that float over the
/// conductors' share of the domain. Of many, more and more mergers share a solve.
FieldSolves solves_in_plane(const Scene& scene, double ways) {
  constexpr double half_shared = 3e4;
  const double radius = std::ranges::min(scene.conductors, {}, &Conductor::radius).radius;
  const double tolerance = scene.mechanics.position_tolerance / radius / 1e-3;  // over the default
  const double predictions = 13 * ways / (1 + ways / half_shared) * std::pow(tolerance, -0.4);
  // Of a field whose grid follows from an accuracy it is not known here whether it is fine enough to predict on.
  if (scene.field_request() || effects::predictor_cells(scene) == 0) return {.whole = 0.6 * predictions};
  return {.whole = 0.085 / std::sqrt(tolerance) * predictions, .predictions = predictions};
}

constexpr double bytes_at_start = 40e6;  // PETSc and the other libraries
constexpr double share_in_motion = 0.8;  // of the iterations: earlier solutions are a good first guess

}  // namespace

FieldCost estimate_field_cost(const FieldOptions& options, double size) {
  const laplace::Price price = price_of(options);
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
  if (scene.mechanics.integrator == Integrator::euler)
    return FieldSolves{.whole = scene.stop.time / scene.mechanics.euler_field_step};
  if (!is_fed_dragged_and_discharged(scene)) return std::nullopt;
  const double ways = floating_groups(scene) / share_of_area(scene);
  if (scene.dimension() == 2) return solves_in_plane(scene, ways);
  return scene.mechanics.keep_height ? std::optional(FieldSolves{.whole = 0.6 * std::pow(ways, 1.5)}) : std::nullopt;
}

}  // namespace lichtenberg
