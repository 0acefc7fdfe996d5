#include "src/commands/field_problem.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/error.hpp"
#include "src/effects/field_choice.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/circuits.hpp"

namespace lichtenberg {
namespace {

std::string name_of_group(const Scene& scene, const std::vector<int>& members) {
  for (const int i : members)
    if (const int wire = scene.conductors[i].group; wire >= 0) return scene.groups[wire].name;
  return fmt::format("conductor{} {}", members.size() > 1 ? "s" : "", fmt::join(members, ", "));
}

std::vector<std::string> name_groups(const Scene& scene, const std::vector<int>& group_of_body, std::size_t groups) {
  std::vector<std::vector<int>> members(groups);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) members[group_of_body[i]].push_back(static_cast<int>(i));
  std::vector<std::string> names(groups);
  for (std::size_t g = 0; g < names.size(); ++g)
    if (!members[g].empty()) names[g] = name_of_group(scene, members[g]);
  for (std::size_t e = 0; e < scene.electrodes.size(); ++e) {
    std::string& name = names[group_of_body[scene.conductors.size() + e]];
    name += (name.empty() ? "" : ", ") + scene.electrodes[e].name;
  }
  return names;
}

/// Sets the groups of sides in circuits to a given potential of 0. Only a run computes their potentials, and solvers
/// take no floating sides.
void fix_sides(const Scene& scene, const effects::ElectricalGroups& groups, const effects::NodeCharges& charges,
               std::vector<laplace::Group>& in_problem) {
  const std::vector<int> group_of_node = effects::groups_of_nodes(groups, charges, 1).group_of_node;
  for (const effects::FloatingSides& sides : effects::floating_sides(scene, group_of_node))
    if (in_problem[sides.group].floating) in_problem[sides.group] = {.floating = false, .potential = 0};
}

}  // namespace

std::string method_in_words(const FieldOptions& field) {
  return field.method->describe ? field.method->describe(field) : field.method->name + ": " + field.method->help;
}

std::string choice_in_words(const FieldOptions& field) {
  const std::string grid = field.method->on_grid ? fmt::format("{} cells, ", field.cells) : "";
  const double estimate = field.chosen_for->estimate;
  return fmt::format("{}, {}tolerance {:.2g}: an estimated error {}, where {:g} is allowed", field.method->name, grid,
                     field.tolerance, estimate > 0 ? fmt::format("of {:.1e}", estimate) : "below rounding",
                     field.chosen_for->requested);
}

void check_side_potentials(const Scene& scene) {
  if (has_side_in_circuit(scene))
    throw InputError(
        fmt::format("{}: a side of the domain is in a circuit, whose potential only a run computes: "
                    "`lichtenberg run` with a short stop.time has the field at the start",
                    scene.path));
}

FieldProblem make_field_problem(const Scene& scene) {
  if (!scene.effects.has(&EffectKind::field))
    throw InputError(
        fmt::format("{} has no table [effects.floating_conductors], so there is no field to solve", scene.path));
  const Bodies bodies = make_bodies(scene);
  FieldProblem field;
  field.groups = effects::groups_at_start(scene, bodies);
  effects::NodeCharges charges{.charge = effects::initial_node_charges(scene)};
  for (const effects::CircuitNode& node : effects::circuit_nodes(scene))
    charges.capacitance.push_back(node.circuit.capacitance);
  if (scene.dimension() == 3) {
    field.spheres = effects::make_sphere_problem(scene, bodies, field.groups, charges);
    fix_sides(scene, field.groups, charges, field.spheres.groups);
    for (const laplace::Sphere& sphere : field.spheres.spheres) field.group_of_body.push_back(sphere.group);
    field.group_names = name_groups(scene, field.group_of_body, field.spheres.groups.size());
    return field;
  }
  field.problem = effects::make_laplace_problem(scene, bodies, field.groups, charges);
  fix_sides(scene, field.groups, charges, field.problem.groups);
  for (const laplace::Body& body : field.problem.bodies) field.group_of_body.push_back(body.group);
  field.group_names = name_groups(scene, field.group_of_body, field.problem.groups.size());
  return field;
}

}  // namespace lichtenberg
