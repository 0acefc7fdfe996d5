#include "src/commands/field_answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/geometry/closed_curve.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/groups.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg {
namespace {

/// Returns for each side the first electrode side that it meets at corners or edges, directly or through other sides.
/// The result is -1 if the side is no electrode. Joined sides have one potential.
std::vector<int> joined_sides(const Scene& scene) {
  const int sides = 2 * scene.dimension();
  std::vector<int> first(sides, -1);
  for (int s = 0; s < sides; ++s)
    if (scene.domain.sides[s].electrode) first[s] = s;
  for (int s = 0; s < sides; ++s)
    for (int other = s / 2 * 2 + 2; other < sides; ++other)
      if (first[s] >= 0 && first[other] >= 0) {
        const auto [one, larger] = std::minmax(first[s], first[other]);
        std::ranges::replace(first, int(larger), int(one));
      }
  return first;
}

std::string name_of_sides(const std::vector<int>& joined, int first) {
  std::vector<std::string> names;
  for (std::size_t s = 0; s < joined.size(); ++s)
    if (joined[s] == first) names.emplace_back(side_names[s]);
  return fmt::format("the {} side{} of the domain", fmt::join(names, ", "), names.size() > 1 ? "s" : "");
}

/// Returns the sides that are the first of their joined set.
std::vector<int> first_sides(const std::vector<int>& joined) {
  std::vector<int> sides;
  for (int s = 0; s < static_cast<int>(joined.size()); ++s)
    if (joined[s] == s) sides.push_back(s);
  return sides;
}

/// Solves the plane problem as requested and stores the solution and the choices. Returns the solver.
std::unique_ptr<laplace::LaplaceSolver> solve_disks(FieldAnswer& answer) {
  if (const FieldRequest* requested = answer.scene.field_request()) {
    laplace::AccurateSolution found =
        solve_to_accuracy(answer.field.problem, effects::accuracy_request(answer.scene, false));
    answer.scene.field_table = effects::field_chosen(*requested, found.choice);
    answer.solution = std::move(found.solution);
    return std::move(found.solver);
  }
  auto solver = effects::make_field_solver(answer.scene.field());
  answer.solution = solver->solve(answer.field.problem);
  return solver;
}

/// Solves the problem of spheres as requested and stores the choices. Returns the solver.
laplace::SphereSolver solve_spheres(FieldAnswer& answer, laplace::SphereSolution& solution) {
  if (answer.scene.field_accuracy()) {
    laplace::AccurateSpheres found = effects::solve_to_accuracy(answer.scene, answer.field.spheres);
    solution = std::move(found.solution);
    return std::move(found.solver);
  }
  laplace::SphereSolver solver = effects::make_sphere_solver(answer.scene.field(), answer.scene.conductors.size());
  solution = solver.solve(answer.field.spheres);
  return solver;
}

/// Returns the charges (F) when the sides joined with `one` are at 1 V and all else is at 0 V: those of the groups,
/// then of first_sides.
std::vector<double> charges_by_side(laplace::LaplaceSolver& solver, laplace::LaplaceProblem unit,
                                    const std::vector<int>& joined, int one, double depth) {
  std::vector<double> charges(unit.groups.size());
  std::ranges::fill(unit.groups, laplace::Group{.floating = false});
  unit.couplings.clear();
  for (int s = 0; s < 4; ++s) unit.sides[s].potential = joined[s] == one;
  const laplace::LaplaceSolution solution = solver.solve(unit);
  for (std::size_t b = 0; b < unit.bodies.size(); ++b) charges[unit.bodies[b].group] += depth * solution.body_charge[b];
  for (const int first : first_sides(joined)) {
    charges.push_back(0);
    for (int s = 0; s < 4; ++s)
      if (joined[s] == first) charges.back() += depth * solution.side_charge[s];
  }
  return charges;
}

/// Returns the same for spheres. If sides are joined, all of them are, with one charge.
std::vector<double> charges_by_side(laplace::SphereSolver& solver, laplace::SphereProblem unit,
                                    const std::vector<int>& joined, int one) {
  std::vector<double> charges(unit.groups.size());
  std::ranges::fill(unit.groups, laplace::Group{.floating = false});
  unit.couplings.clear();
  for (int s = 0; s < 6; ++s) unit.side_potential[s] = joined[s] == one;
  const laplace::SphereSolution solution = solver.solve(unit);
  for (std::size_t i = 0; i < unit.spheres.size(); ++i) charges[unit.spheres[i].group] += solution.sphere_charge[i];
  const std::vector<int> sides = first_sides(joined);
  for (const int first : sides)
    charges.push_back(sides.size() == 1 ? solution.electrode_charge : solution.side_charge[first]);
  return charges;
}

/// Extends the capacitance matrix by the electrode sides. By symmetry, the charge of a group due to a side's potential
/// equals that of the side due to the group's. `among_groups` (F): matrix without sides; by_side(side):
/// charges_by_side.
Capacitances with_sides(const FieldAnswer& answer, const std::vector<int>& joined,
                        const std::vector<double>& among_groups,
                        const std::function<std::vector<double>(int side)>& by_side) {
  Capacitances found{answer.field.group_names, {}};
  const std::vector<int> sides = first_sides(joined);
  for (const int first : sides) found.names.push_back(name_of_sides(joined, first));
  const std::size_t groups = answer.field.group_names.size(), n = found.names.size();
  found.matrix.assign(n * n, 0);
  for (std::size_t i = 0; i < groups; ++i)
    for (std::size_t j = 0; j < groups; ++j) found.matrix[i * n + j] = among_groups[i * groups + j];
  for (std::size_t k = 0; k < sides.size(); ++k) {
    const std::vector<double> column = by_side(sides[k]);
    for (std::size_t i = 0; i < n; ++i) found.matrix[i * n + groups + k] = column[i];
    for (std::size_t g = 0; g < groups; ++g) found.matrix[(groups + k) * n + g] = column[g];
  }
  return found;
}

Capacitances capacitances(laplace::LaplaceSolver& solver, const FieldAnswer& answer) {
  const laplace::LaplaceProblem& problem = answer.field.problem;
  const std::vector<int> joined = joined_sides(answer.scene);
  std::vector<double> among_groups = capacitance_matrix(solver, problem);
  for (double& value : among_groups) value *= answer.depth();
  return with_sides(answer, joined, among_groups,
                    [&](int side) { return charges_by_side(solver, problem, joined, side, answer.depth()); });
}

Capacitances capacitances(laplace::SphereSolver& solver, const FieldAnswer& answer) {
  const laplace::SphereProblem& problem = answer.field.spheres;
  const std::vector<int> joined = joined_sides(answer.scene);
  return with_sides(answer, joined, solver.capacitance_matrix(problem),
                    [&](int side) { return charges_by_side(solver, problem, joined, side); });
}

/// Throws Failure if the solution holds a non-finite number.
void check_finite(const FieldAnswer& answer) {
  const auto finite = [](double value) { return std::isfinite(value); };
  bool all = finite(answer.energy()) && std::ranges::all_of(answer.capacitance.matrix, finite);
  for (int i = 0; i < answer.size(); ++i)
    all = all && finite(answer.potential(i)) && finite(answer.charge(i)) && finite(norm(answer.force[i]));
  if (!all)
    throw Failure(
        fmt::format("{}: potentials, charges, forces or the energy are too large or too small for floating-point "
                    "numbers: potentials and charges nearer to 1 are needed",
                    answer.scene.path));
}

void solve_in_space(FieldAnswer& answer, RequestedParts requested) {
  if (requested.potential_field)
    throw InputError(answer.scene.path +
                     ": the field of spheres in space is not on a grid, so it has no potential_field");
  laplace::SphereSolution found;
  laplace::SphereSolver solver = solve_spheres(answer, found);
  answer.force = std::move(found.sphere_force);
  answer.side_charge = found.side_charge;
  if (std::ranges::any_of(found.side_charge, [](double charge) { return std::isnan(charge); }))
    answer.charge_of_joined_sides = found.electrode_charge;
  answer.solution = {.group_potential = std::move(found.group_potential),
                     .body_charge = std::move(found.sphere_charge),
                     .body_force = {},
                     .energy = found.energy,
                     .unknowns = found.unknowns,
                     .iterations = found.iterations,
                     .residual = found.residual,
                     .seconds = found.seconds};
  if (requested.capacitance) answer.capacitance = capacitances(solver, answer);
}

void solve_in_plane(FieldAnswer& answer, RequestedParts requested) {
  const auto solver = solve_disks(answer);
  for (const Vec2 force : answer.solution.body_force) answer.force.push_back(in_space(answer.depth() * force));
  std::ranges::copy(answer.solution.side_charge, answer.side_charge.begin());
  if (requested.potential_field) answer.potential_field = solver->field();
  if (requested.capacitance) answer.capacitance = capacitances(*solver, answer);
}

nlohmann::ordered_json capacitance_json(const FieldAnswer& answer) {
  const auto& [names, matrix] = answer.capacitance;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (auto row = matrix.begin(); row != matrix.end(); row += names.size())
    rows.push_back(std::vector<double>(row, row + names.size()));
  return {{"groups", names}, {"matrix", rows}};
}

}  // namespace

FieldAnswer solve_field(Scene scene, RequestedParts requested) {
  FieldAnswer answer{.scene = std::move(scene)};
  effects::check_processes(&answer.scene.field_table);
  check_side_potentials(answer.scene);
  answer.field = make_field_problem(answer.scene);
  answer.in_space() ? solve_in_space(answer, requested) : solve_in_plane(answer, requested);
  check_finite(answer);
  return answer;
}

std::vector<TerminalAnswer> terminals(const FieldAnswer& answer) {
  std::vector<TerminalAnswer> found;
  const laplace::LaplaceSolution& solution = answer.solution;
  const std::vector<int>& group = answer.field.group_of_body;
  const std::vector<int> joined = joined_sides(answer.scene), first = first_sides(joined);
  const auto row_of_side = [&](std::size_t s) {
    return static_cast<int>(answer.field.group_names.size() + (std::ranges::find(first, joined[s]) - first.begin()));
  };
  std::size_t body = answer.scene.conductors.size(), side = 0;
  for (const effects::Terminal& terminal : effects::terminals_of(answer.scene)) {
    if (body < group.size()) {
      found.push_back({terminal.name, solution.group_potential[group[body]],
                       answer.depth() * solution.body_charge[body], group[body]});
      ++body;
      continue;
    }
    while (!answer.scene.domain.sides[side].electrode) ++side;
    found.push_back(
        {terminal.name, terminal.potential.value, answer.depth() * answer.side_charge[side], row_of_side(side)});
    ++side;
  }
  if (answer.charge_of_joined_sides) {
    const int all = first.front();
    found.push_back({name_of_sides(joined, all), answer.scene.domain.sides[all].potential.value,
                     *answer.charge_of_joined_sides, row_of_side(all)});
  }
  return found;
}

std::vector<CurveForce> curve_forces(const FieldAnswer& answer) {
  constexpr double most_rotation = 0.5;  // rad within four cells: a radius of eight
  std::vector<CurveForce> found;
  const laplace::LaplaceSolution& solution = answer.solution;
  for (std::size_t k = 0; k < answer.scene.electrodes.size() && !solution.body_torque.empty(); ++k) {
    const Electrode& electrode = answer.scene.electrodes[k];
    const double cell = std::max(answer.scene.domain.size.x, answer.scene.domain.size.y) / answer.scene.field().cells;
    if (!electrode.curve || electrode.curve->largest_rotation(4 * cell) > most_rotation) continue;
    const std::size_t body = answer.scene.conductors.size() + k;
    found.push_back({electrode.name, answer.depth() * solution.body_force[body],
                     answer.depth() * solution.body_torque[body], electrode.curve->centroid()});
  }
  return found;
}

std::vector<std::string> warnings_of(const FieldAnswer& answer) {
  const std::string unresolved = effects::unresolved_bodies(answer.scene);
  return unresolved.empty() ? std::vector<std::string>{} : std::vector{unresolved};
}

nlohmann::ordered_json summary_json(const FieldAnswer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  const FieldOptions& field = answer.scene.field();
  nlohmann::ordered_json json;
  json["electrodes"] = nlohmann::ordered_json::array();
  for (const auto& [name, potential, charge, group] : terminals(answer))
    json["electrodes"].push_back({{"name", name}, {"potential", potential}, {"charge", charge}, {"group", group}});
  for (const auto& [name, force, torque, centroid] : curve_forces(answer))
    json["electrode_forces"].push_back(
        {{"name", name}, {"force", {force.x, force.y}}, {"torque", torque}, {"centroid", {centroid.x, centroid.y}}});
  json["energy"] = answer.energy();
  if (!answer.in_space()) json["depth"] = answer.depth();
  json["units"] = {{"position", "m"}, {"radius", "m"}, {"potential", "V"}, {"charge", "C"},
                   {"force", "N"},    {"energy", "J"}, {"depth", "m"},     {"capacitance", "F"}};
  if (json.contains("electrode_forces")) json["units"]["torque"] = "N m";
  json["method"] = field.method->name;
  if (field.chosen_for) {
    json["accuracy"] = {{"asked", field.chosen_for->requested}, {"estimated_error", field.chosen_for->estimate}};
    if (!answer.in_space()) json["accuracy"]["cells"] = field.cells;
    json["accuracy"]["tolerance"] = field.tolerance;
  }
  json["unknowns"] = solution.unknowns;
  json["iterations"] = solution.iterations;
  if (solution.work > 0) json["work"] = solution.work;
  json["residual"] = solution.residual;
  json["seconds"] = {
      {"setup", solution.seconds.setup}, {"solve", solution.seconds.solve}, {"forces", solution.seconds.forces}};
  if (!answer.capacitance.names.empty()) json["capacitance"] = capacitance_json(answer);
  json["warnings"] = warnings_of(answer);
  return json;
}

}  // namespace lichtenberg
