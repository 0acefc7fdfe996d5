#include "src/effects/field_choice.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/cost_model.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/floating_spheres.hpp"
#include "src/field_methods/cut_cell.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg::effects {
namespace {

/// Returns the number of grid cells along the longer side for which a field solve fits into half of the machine's
/// memory. `size`: lengths of the domain (m).
int cells_in_memory(Vec2 size) {
  const double bytes = 0.5 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const double aspect = std::max(size.x, size.y) / std::min(size.x, size.y);
  return static_cast<int>(std::min<double>(most_cells, std::sqrt(aspect * bytes / laplace::cut_cell_cost.bytes)));
}

bool can_follow(Scene scene, const FieldMethodKind& method) {
  scene.field_table = FieldOptions{.method = &method};
  try {
    check_can_move(scene);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Returns the field method for a requested accuracy if the scene names a method or permits only one; otherwise empty.
/// Then the cheapest method is chosen.
std::optional<laplace::Method> only_choice(const Scene& scene, bool for_a_run) {
  const FieldRequest& field_request = *scene.field_request();
  if (field_request.method) return field_request.method->accuracy;
  std::vector<laplace::Method> possible;
  for (const FieldMethodKind* method : field_methods())
    if (method->accuracy && method->solves(2) && (field_request.device == FieldDevice::cpu || method->on_device) &&
        (!has_resistors(scene) || method->couplings) && (!for_a_run || can_follow(scene, *method)))
      possible.push_back(*method->accuracy);
  return possible.size() == 1 ? std::optional(possible.front()) : std::nullopt;
}

const FieldMethodKind& method_of(laplace::Method chosen) {
  return **std::ranges::find_if(field_methods(), [&](const auto* method) { return method->accuracy == chosen; });
}

/// Returns the charges of the conductors after the first output interval, with the injected charge, and the largest
/// potentials of sources that vary in time.
NodeCharges typical_charges(const Scene& scene) {
  NodeCharges charges{.charge = initial_charges(scene)};
  if (const auto* source = scene.effects.find<CurrentInjectionOptions>())
    for (double& charge : charges.charge) charge += source->current * scene.output.every;
  const std::vector<PotentialSource> supplies = potential_sources_of(scene);
  charges.supply_potential = potentials_at(supplies, 0, true);
  for (std::size_t k = 0; k < charges.supply_potential.size(); ++k)
    if (supplies[k].potential.varies()) charges.supply_potential[k] = supplies[k].potential.largest();
  return charges;
}

/// Returns the plane field problem for the initial positions and typical_charges().
laplace::LaplaceProblem typical_problem(const Scene& scene) {
  const Bodies bodies = make_bodies(scene);
  return make_laplace_problem(scene, bodies, groups_at_start(scene, bodies), typical_charges(scene));
}

/// Returns the field problem of spheres for the initial positions and typical_charges().
laplace::SphereProblem typical_sphere_problem(const Scene& scene) {
  const Bodies bodies = make_bodies(scene);
  laplace::SphereProblem problem =
      make_sphere_problem(scene, bodies, groups_at_start(scene, bodies), typical_charges(scene));
  if (!problem.couplings.empty() && !problem.has_ground()) neutralize(problem.groups);
  return problem;
}

/// Returns true if a field problem of spheres is valid. If not, the run reports the reason in the scene's terms.
bool can_be_solved(const laplace::SphereProblem& problem) {
  try {
    problem.check();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

ElectricalGroups groups_at_start(const Scene& scene, const Bodies& bodies) {
  if (!scene.effects.has<ContactDischargeOptions>()) return electrical_groups(scene, {});
  std::vector<Contact> contacts;
  ContactDischarge(scene).update(bodies, contacts);
  return electrical_groups(scene, contacts);
}

laplace::AccuracyRequest accuracy_request(const Scene& scene, bool for_a_run) {
  const FieldRequest& field_request = *scene.field_request();
  if (for_a_run)
    check_device(scene);
  else
    check_device(field_request.device, field_request.method);
  // Errors relative to the largest current values vary while a scene moves, up to three times those at the start.
  const double reserve = for_a_run ? 3 : 1;
  laplace::AccuracyRequest request{.accuracy = field_request.accuracy / reserve,
                                   .reserve = reserve,
                                   .most_cells = cells_in_memory(plane(scene.domain.size)),
                                   .cut_cell = cut_cell_options({.device = field_request.device,
                                                                 .threads = field_request.threads,
                                                                 .linear_solver = field_request.linear_solver})};
  request.method = only_choice(scene, for_a_run);
  if (const auto* discharge = scene.effects.find<ContactDischargeOptions>(); for_a_run && discharge)
    request.least_gap = discharge->contact_distance;
  return request;
}

double usual_moving_tolerance(const Scene& scene) {
  // Measured: position tolerance, in radii, at which `most` applies
  constexpr double least = 1e-5, most = 1e-4, measured = 1e-3;
  const MechanicsOptions& mechanics = scene.mechanics;
  const bool has_tolerance = mechanics.kind().reads("position_tolerance");
  if (!has_tolerance || scene.conductors.empty() || has_circuit(scene)) return least;
  const double radius = scene.smallest_radius();
  const double relative_tolerance = mechanics.position_tolerance / radius / measured;
  return std::clamp(most * relative_tolerance * relative_tolerance, least, most);
}

FieldOptions field_chosen(const FieldRequest& field_request, const laplace::Choice& choice) {
  return {.method = &method_of(choice.method),
          .cells = choice.cells,
          .tolerance = choice.tolerance,
          .moving_tolerance = choice.tolerance,
          .device = field_request.device,
          .cuda_devices = field_request.cuda_devices,
          .threads = field_request.threads,
          .linear_solver = field_request.linear_solver,
          .chosen_for = FieldAccuracy{field_request.accuracy, choice.estimate}};
}

laplace::AccurateSpheres solve_to_accuracy(Scene& scene, const laplace::SphereProblem& problem) {
  FieldOptions& field = scene.field();
  laplace::AccurateSpheres found =
      laplace::solve_to_accuracy(problem, field.chosen_for->requested, [&](double tolerance) {
        FieldOptions options = field;
        options.tolerance = tolerance;
        return make_sphere_solver(options, problem.spheres.size());
      });
  field.tolerance = field.moving_tolerance = found.tolerance;
  field.chosen_for->estimate = found.estimate;
  return found;
}

Scene with_field_chosen(Scene scene) {
  if (scene.dimension() == 3 && scene.field_accuracy()) {
    const laplace::SphereProblem problem = typical_sphere_problem(scene);
    if (can_be_solved(problem)) solve_to_accuracy(scene, problem);
    return scene;
  }
  const FieldRequest* field_request = scene.field_request();
  if (!field_request || !scene.effects.has<FloatingConductorsOptions>()) return scene;
  const laplace::LaplaceProblem problem = typical_problem(scene);
  scene.field_table = field_chosen(*field_request, solve_to_accuracy(problem, accuracy_request(scene, true)).choice);
  return scene;
}

std::string unresolved_bodies(const Scene& scene) {
  if (!scene.effects.has<FloatingConductorsOptions>() || scene.dimension() != 2) return "";
  const FieldOptions& field = scene.field();
  if (!field.method->on_grid || field.chosen_for) return "";
  const double cell = std::max(scene.domain.size.x, scene.domain.size.y) / field.cells;
  double smallest = cell;
  int number = 0;
  const auto look = [&](double radius) {
    smallest = std::min(smallest, radius);
    number += radius < cell;
  };
  for (const Conductor& conductor : scene.conductors) look(conductor.radius);
  for (const Electrode& electrode : scene.electrodes)
    if (const Disk* disk = std::get_if<Disk>(&electrode.shape)) look(disk->radius);
  if (number == 0) return "";
  return fmt::format(
      "disks below a cell: {} of them, the smallest of radius {:.3g} m where a cell is {:.3g} m, so that their forces "
      "and charges are hardly resolved; use more field.cells or set field.accuracy instead",
      number, smallest, cell);
}

double estimated_error(const FieldOptions& field, const laplace::LaplaceProblem& problem) {
  const laplace::Choice choice{
      .method = *field.method->accuracy, .cells = field.cells, .tolerance = field.moving_tolerance};
  return laplace::estimated_error(problem, choice, cut_cell_options(field));
}

}  // namespace lichtenberg::effects
