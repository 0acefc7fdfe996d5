#include "src/effects/floating_spheres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "src/effects/floating_conductors.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg::effects {
namespace {

/// Returns the index of a fixed group with this potential (V), and appends a new group if there is none.
int group_at(double potential, std::vector<laplace::Group>& groups) {
  const auto found = std::ranges::find_if(
      groups, [&](const laplace::Group& group) { return !group.floating && group.potential == potential; });
  if (found != groups.end()) return static_cast<int>(found - groups.begin());
  groups.push_back({.floating = false, .potential = potential});
  return static_cast<int>(groups.size()) - 1;
}

/// Returns the centre of a sphere, moved to a gap of at least 0.1 % of its radius from some electrode sides. These are
/// the sides s for which is_one(s) is true: those that have the sphere's potential, or all electrode sides if a
/// resistive contact joins it to one.
Vec3 clear_of_sides(Vec3 centre, double radius, const Domain& domain, const auto& is_one) {
  const double least = (1 + 1e-3) * radius;
  for (int k = 0; k < 3; ++k) {
    if (is_one(2 * k)) centre[k] = std::max(centre[k], least);
    if (is_one(2 * k + 1)) centre[k] = std::min(centre[k], domain.size[k] - least);
  }
  return centre;
}

/// Returns the index of the sphere at the other end of a resistive contact; -1 for a side of the domain.
int sphere_beyond(const Scene& scene, const Resistor& resistor) {
  const int conductors = static_cast<int>(scene.conductors.size());
  const int electrodes = static_cast<int>(scene.electrodes.size());
  return resistor.partner < conductors + electrodes ? resistor.partner : -1;
}

/// Returns for each conductor 1 if a resistive contact connects it to a side of the domain, otherwise 0.
std::vector<char> joined_to_sides(const Scene& scene, const NodeCharges& charges) {
  std::vector<char> joined(scene.conductors.size());
  for (const Resistor& resistor : charges.resistors)
    if (!resistor.series && sphere_beyond(scene, resistor) < 0) joined[resistor.a] = 1;
  return joined;
}

/// Shrinks spheres joined by a resistive contact, so that they have a gap. Such spheres are in two groups and may
/// touch, with potentials that are equal within the accuracy of the field (otherwise
/// ResistorCurrents::unequal_contact_message ends the run). The gap is `accuracy` times the smaller radius, but at
/// least 1e-5 of it, so that it keeps its digits. Each sphere shrinks by half of the missing gap. The relative errors
/// of charge and force there are of the order of `accuracy`. A potential difference dV contributes about pi eps dV^2 /
/// accuracy to the force.
void keep_contacts_apart(const Scene& scene, const std::vector<Resistor>& resistors, double accuracy,
                         std::vector<laplace::Sphere>& spheres) {
  std::vector<double> shrink(spheres.size());
  for (const Resistor& resistor : resistors) {
    const int other = resistor.series ? -1 : sphere_beyond(scene, resistor);
    if (other < 0 || spheres[resistor.a].group == spheres[other].group) continue;
    const laplace::Sphere &a = spheres[resistor.a], &b = spheres[other];
    const double least = std::max(accuracy, 1e-5) * std::min(a.radius, b.radius);
    const double gap = norm(a.centre - b.centre) - a.radius - b.radius;
    for (const int one : {resistor.a, other}) shrink[one] = std::max(shrink[one], 0.5 * (least - gap));
  }
  for (std::size_t i = 0; i < spheres.size(); ++i) spheres[i].radius -= shrink[i];
}

}  // namespace

laplace::SphereProblem make_sphere_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                           const NodeCharges& charges) {
  laplace::SphereProblem problem{.box = scene.domain.box(),
                                 .free_space = scene.domain.open,
                                 .uniform_field = scene.domain.uniform_field,
                                 .permittivity = scene.medium.permittivity};
  problem.side_potential = side_potentials(scene, charges);
  NodeGroups nodes = groups_of_nodes(groups, charges, 1);
  problem.groups = std::move(nodes.groups);
  const std::vector<char> at_side = joined_to_sides(scene, charges);
  const int first_circuit = node_count(scene) - static_cast<int>(scene.circuits.size());
  for (int i = 0; i < bodies.size(); ++i) {
    const laplace::Group& own = problem.groups[nodes.group_of_node[i]];
    const auto is_one = [&](int s) {
      const DomainSide& side = scene.domain.sides[s];
      const bool same = side.circuit >= 0 ? nodes.group_of_node[first_circuit + side.circuit] == nodes.group_of_node[i]
                                          : !own.floating && own.potential == problem.side_potential[s];
      return side.electrode && (at_side[i] || same);
    };
    problem.spheres.push_back({clear_of_sides(position_in_space(bodies, i), bodies.radius[i], scene.domain, is_one),
                               bodies.radius[i], nodes.group_of_node[i]});
  }
  problem.movable = bodies.size();
  int node = bodies.size(), supply = 0;
  for (const Electrode& electrode : scene.electrodes) {
    const double potential = charges.potential_of(supply++, electrode.potential.value);
    const int group = electrode.circuit >= 0            ? nodes.group_of_node[first_circuit + electrode.circuit]
                      : electrode.series_resistance > 0 ? nodes.group_of_node[node++]
                                                        : group_at(potential, problem.groups);
    problem.spheres.push_back({electrode.centre(), std::get<Disk>(electrode.shape).radius, group});
  }
  const FieldAccuracy* accuracy = scene.field_accuracy();
  keep_contacts_apart(scene, charges.resistors, accuracy ? accuracy->requested : scene.field().moving_tolerance,
                      problem.spheres);
  add_couplings(groups, charges, nodes.group_of_node, 1, problem.groups, problem.couplings);
  return problem;
}

Electrostatics electrostatics_of(const Scene& scene, const laplace::SphereProblem& problem,
                                 const laplace::SphereSolution& solution) {
  Electrostatics result{.energy = solution.energy};
  const std::size_t conductors = scene.conductors.size();
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const double potential = solution.group_potential[problem.spheres[i].group];
    (i < conductors ? result.charge : result.terminal_charge).push_back(solution.sphere_charge[i]);
    (i < conductors ? result.potential : result.terminal_potential).push_back(potential);
    if (i < conductors) result.force.push_back(solution.sphere_force[i]);
  }
  for (std::size_t s = 0; s < problem.side_potential.size(); ++s) {
    if (problem.box.sides[s] != Boundary::electrode) continue;
    result.terminal_charge.push_back(solution.side_charge[s]);
    result.terminal_potential.push_back(problem.side_potential[s]);
  }
  return result;
}

void check_spheres(const Draft& draft) {
  const auto refuse_it = [&](const std::string& key, const std::string& message) {
    refuse(draft.scene.path, draft.line(key), message);
  };
  for (const std::string key : {"medium.depth", "field.cells", "field.boundary_stencil", "field.linear_solver"})
    if (draft.line(key) > 0)
      refuse_it(key, key + " is not allowed in three dimensions, whose field has none: leave it out");
  if (draft.field.accuracy)
    for (const std::string key : {"field.tolerance", "field.moving_tolerance"})
      if (draft.line(key) > 0) refuse_it(key, key + " is chosen for field.accuracy: leave one of the two out");
  if (draft.field.options.device != FieldDevice::cpu)
    refuse_it("field.device", fmt::format("field.device = \"{}\" is not allowed in three dimensions: it must be \"{}\"",
                                          name_of(draft.field.options.device), name_of(FieldDevice::cpu)));
}

laplace::SphereSolver make_sphere_solver(const FieldOptions& options, std::size_t spheres) {
  check_device(options.device, options.method);
  return options.method->make_in_space(options, spheres);
}

}  // namespace lichtenberg::effects
