#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/python.hpp"
#include "src/commands/scratch_folder.hpp"
#include "src/commands/solve_grains.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/groups.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/model/bodies.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {
namespace {

struct SolveArguments {
  std::string scene, field, picture, device;
  std::vector<std::string> settings;
  bool capacitance = false, overwrite = false;
  JsonTarget json;
};

/// Potential and charge of an electrode or of an electrode side.
struct TerminalAnswer {
  std::string name;
  double potential = 0, charge = 0;  ///< V, C
  int group = 0;                     ///< row of the capacitance matrix
};

/// Capacitance matrix: charge on each group when one is at 1 V and all others are at 0 V.
struct Capacitances {
  std::vector<std::string> names;
  std::vector<double> matrix;  ///< F, names x names
};

/// Solution in SI units, multiplied by the scene's depth.
struct Answer {
  Scene scene;
  FieldProblem field{};
  laplace::LaplaceSolution solution{};             ///< per metre of depth; in three dimensions without forces
  std::vector<Vec3> force{};                       ///< N
  std::array<double, 6> side_charge{};             ///< C, of electrode sides; in a plane per metre of depth
  std::optional<double> charge_of_joined_sides{};  ///< C, in three dimensions where electrode sides meet
  Capacitances capacitance{};                      ///< empty if not requested

  int size() const { return static_cast<int>(scene.conductors.size()); }
  bool in_space() const { return scene.dimension() == 3; }
  double depth() const { return in_space() ? 1 : scene.medium.depth; }
  double potential(int i) const { return solution.group_potential[field.group_of_body[i]]; }
  double charge(int i) const { return depth() * solution.body_charge[i]; }
  double energy() const { return depth() * solution.energy; }
};

void print_conductors(const Answer& answer) {
  const bool z = answer.in_space();
  const int dimension = answer.scene.dimension();
  fmt::print("{:>9} {:>12} {:>12}{} {:>11} {:>6} {:>14} {:>13} {:>13} {:>13}{}\n", "conductor", "x (m)", "y (m)",
             z ? fmt::format(" {:>12}", "z (m)") : "", "radius (m)", "group", "potential (V)", "charge (C)",
             "force x (N)", "force y (N)", z ? fmt::format(" {:>13}", "force z (N)") : "");
  for (int i = 0; i < answer.size(); ++i) {
    const Conductor& conductor = answer.scene.conductors[i];
    fmt::print("{:>9}{} {:>11.4g} {:>6} {:>14.7g} {:>13.6g}{}\n", i,
               columns_of(components(conductor.position, dimension), " {:>12.6g}"), conductor.radius,
               answer.field.group_of_body[i], answer.potential(i), answer.charge(i),
               columns_of(components(answer.force[i], dimension), " {:>13.6g}"));
  }
}

/// Returns for each side the first electrode side that it meets directly or through others, at corners or edges; -1 if
/// the side is no electrode. Joined sides have one potential.
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

/// Returns the terminals in the order of effects::terminals_of: electrodes, then electrode sides. In space, for sides
/// that meet at edges only the sum of the charges is known; it comes last.
std::vector<TerminalAnswer> terminals(const Answer& answer) {
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
    found.push_back({terminal.name, terminal.potential, answer.depth() * answer.side_charge[side], row_of_side(side)});
    ++side;
  }
  if (answer.charge_of_joined_sides) {
    const int all = first.front();
    found.push_back({name_of_sides(joined, all), answer.scene.domain.sides[all].potential,
                     *answer.charge_of_joined_sides, row_of_side(all)});
  }
  return found;
}

void print_terminals(const Answer& answer) {
  const std::vector<TerminalAnswer> all = terminals(answer);
  if (all.empty()) return;
  fmt::print("\n{:>14} {:>13}  electrode\n", "potential (V)", "charge (C)");
  for (const auto& [name, potential, charge, group] : all)  // for sides that meet at an edge only the sum is known
    fmt::print("{:>14.7g} {:>13}  {}\n", potential, std::isnan(charge) ? "unknown" : fmt::format("{:.6g}", charge),
               name);
}

void print_capacitance(const Answer& answer) {
  const auto& [names, matrix] = answer.capacitance;
  fmt::print("\ncapacitance matrix (F): charge on the row's group when the column's is at 1 V, all others at 0 V\n");
  for (std::size_t row = 0; row < names.size(); ++row) {
    for (std::size_t column = 0; column < names.size(); ++column)
      fmt::print("{:>14.6e}", matrix[row * names.size() + column]);
    fmt::print("  {}: {}\n", row, names[row]);
  }
}

void print_table(const Answer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  if (answer.size() > 0) print_conductors(answer);
  print_terminals(answer);
  fmt::print("\nenergy      {:.7g} J\n", answer.energy());
  if (!answer.in_space())
    fmt::print("depth       {:g} m: charges, forces and energy are those of a slab of this depth\n", answer.depth());
  fmt::print("method      {}\n", method_in_words(answer.scene.field()));
  if (answer.scene.field().chosen_for) fmt::print("chosen      {}\n", choice_in_words(answer.scene.field()));
  fmt::print("unknowns    {}\n", solution.unknowns);
  fmt::print("iterations  {}\n", solution.iterations);
  if (solution.work > 0)
    fmt::print("work        {:.1f} evaluations of the residual on the whole grid\n", solution.work);
  fmt::print("residual    {:.2g}\n", solution.residual);
  fmt::print("seconds     {:.4f} setup, {:.4f} solve, {:.4f} forces\n", solution.seconds.setup, solution.seconds.solve,
             solution.seconds.forces);
  if (!answer.capacitance.names.empty()) print_capacitance(answer);
}

/// Returns reasons why the solution may be unsafe to use (Summary::warnings).
std::vector<std::string> warnings_of(const Answer& answer) {
  const std::string unresolved = effects::unresolved_bodies(answer.scene);
  return unresolved.empty() ? std::vector<std::string>{} : std::vector{unresolved};
}

nlohmann::ordered_json conductor_json(const Answer& answer, int i) {
  const Conductor& conductor = answer.scene.conductors[i];
  return {{"position", components(conductor.position, answer.scene.dimension())},
          {"radius", conductor.radius},
          {"group", answer.field.group_of_body[i]},
          {"potential", answer.potential(i)},
          {"charge", answer.charge(i)},
          {"force", components(answer.force[i], answer.scene.dimension())}};
}

nlohmann::ordered_json capacitance_json(const Answer& answer) {
  const auto& [names, matrix] = answer.capacitance;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (auto row = matrix.begin(); row != matrix.end(); row += names.size())
    rows.push_back(std::vector<double>(row, row + names.size()));
  return {{"groups", names}, {"matrix", rows}};
}

nlohmann::ordered_json json_of(const Answer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  const FieldOptions& field = answer.scene.field();
  nlohmann::ordered_json json;
  json["conductors"] = nlohmann::ordered_json::array();
  for (int i = 0; i < answer.size(); ++i) json["conductors"].push_back(conductor_json(answer, i));
  json["electrodes"] = nlohmann::ordered_json::array();
  for (const auto& [name, potential, charge, group] : terminals(answer))
    json["electrodes"].push_back({{"name", name}, {"potential", potential}, {"charge", charge}, {"group", group}});
  json["energy"] = answer.energy();
  if (!answer.in_space()) json["depth"] = answer.depth();
  json["units"] = {{"position", "m"}, {"radius", "m"}, {"potential", "V"}, {"charge", "C"},
                   {"force", "N"},    {"energy", "J"}, {"depth", "m"},     {"capacitance", "F"}};
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

/// Solves the plane problem as requested and stores the solution and the choices. Returns the solver.
std::unique_ptr<laplace::LaplaceSolver> solve_disks(Answer& answer) {
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
laplace::SphereSolver solve_spheres(Answer& answer, laplace::SphereSolution& solution) {
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
Capacitances with_sides(const Answer& answer, const std::vector<int>& joined, const std::vector<double>& among_groups,
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

Capacitances capacitances(laplace::LaplaceSolver& solver, const Answer& answer) {
  const laplace::LaplaceProblem& problem = answer.field.problem;
  const std::vector<int> joined = joined_sides(answer.scene);
  std::vector<double> among_groups = capacitance_matrix(solver, problem);
  for (double& value : among_groups) value *= answer.depth();
  return with_sides(answer, joined, among_groups,
                    [&](int side) { return charges_by_side(solver, problem, joined, side, answer.depth()); });
}

Capacitances capacitances(laplace::SphereSolver& solver, const Answer& answer) {
  const laplace::SphereProblem& problem = answer.field.spheres;
  const std::vector<int> joined = joined_sides(answer.scene);
  return with_sides(answer, joined, solver.capacitance_matrix(problem),
                    [&](int side) { return charges_by_side(solver, problem, joined, side); });
}

/// Returns the frame that a run of the scene would record at its start.
ConductorFrame frame_of(const Answer& answer) {
  ConductorFrame frame;
  for (int i = 0; i < answer.size(); ++i) {
    frame.position.push_back(answer.scene.conductors[i].position);
    frame.force.push_back(answer.force[i]);
    frame.charge.push_back(answer.charge(i));
    frame.potential.push_back(answer.potential(i));
    frame.group.push_back(answer.field.groups.connected[i]);
  }
  frame.velocity.assign(answer.scene.conductors.size(), {});
  frame.energy = answer.energy();
  return frame;
}

/// Draws the solution as a frame of a run, from a temporary result file.
void draw_solution(const Answer& answer, std::optional<laplace::Field> field, const std::string& picture) {
  const ScratchFolder folder;
  const std::string file = folder.file("solution.h5");
  {
    Recorder recorder = Recorder::start(file, answer.scene, make_bodies(answer.scene).mass, false);
    Frame frame = columns_of(frame_of(answer));
    // defines the quantity of the colours
    if (answer.size() == 0) frame.add_particles("potential", "V", std::vector<double>{});
    recorder.add(std::move(frame));
    Milestone milestone;
    milestone.field = std::move(field);
    milestone.warnings = warnings_of(answer);
    recorder.save(milestone);
  }
  draw("frames.draw_solution", {file, picture});
}

/// Throws Failure if the solution holds a non-finite number. Call it before output.
void check_finite(const Answer& answer) {
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

void solve_in_space(Answer& answer, const SolveArguments& request) {
  if (!request.field.empty())
    throw InputError("--field is for scenes in two dimensions: the field of spheres in space is not on a grid");
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
  check_finite(answer);
  if (!request.picture.empty()) draw_solution(answer, std::nullopt, request.picture);
  if (request.capacitance) answer.capacitance = capacitances(solver, answer);
}

void solve_in_plane(Answer& answer, const SolveArguments& request) {
  const auto solver = solve_disks(answer);
  for (const Vec2 force : answer.solution.body_force) answer.force.push_back(in_space(answer.depth() * force));
  std::ranges::copy(answer.solution.side_charge, answer.side_charge.begin());
  check_finite(answer);
  if (!request.field.empty()) write_field_vtkhdf(request.field, solver->field(), request.overwrite);
  if (!request.picture.empty()) draw_solution(answer, solver->field(), request.picture);
  if (request.capacitance) answer.capacitance = capacitances(*solver, answer);
}

/// Throws InputError for options that need conductors or a grid.
void check_for_grains(const SolveArguments& request) {
  const auto refuse_it = [](const char* option) {
    throw InputError(fmt::format("option {} is for scenes of conductors: leave it out for charged grains", option));
  };
  if (request.capacitance) refuse_it("--capacitance");
  if (!request.field.empty()) refuse_it("--field");
  if (!request.picture.empty()) refuse_it("--picture");
  if (request.device == name_of(FieldDevice::cuda)) refuse_it("--device cuda");
}

bool is_result(const std::string& path) {
  try {
    const Result result(path);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// Throws InputError if output files cannot be written or would replace an input or a result. Call it before the work.
void check_files(const SolveArguments& request) {
  if (!request.picture.empty()) {
    check_picture("--picture", request.picture);
    check_output("--picture", request.picture, request.overwrite);
  }
  if (request.field.empty()) return;
  check_not_read(request.field, {request.scene});
  check_output("--field", request.field, request.overwrite);
  if (is_result(request.field))
    throw InputError(request.field + " is a result and is not overwritten: give --field another name");
}

Answer solve(const SolveArguments& request, Scene scene) {
  Answer answer{.scene = std::move(scene)};
  effects::check_processes(&answer.scene.field_table);
  answer.field = make_field_problem(answer.scene);
  answer.in_space() ? solve_in_space(answer, request) : solve_in_plane(answer, request);
  check_finite(answer);  // includes the capacitances
  return answer;
}

}  // namespace

Command solve_command() {
  auto request = std::make_shared<SolveArguments>();
  return {"solve",
          "Solves the field of a scene's initial state once, for conductors or for charged grains",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           device_argument(request->device),
           set_argument(request->settings),
           {"--capacitance", &request->capacitance, "also compute the capacitance matrix: one more solve per group"},
           json_argument(request->json, "SI units; reduced units for grains"),
           {"--field", &request->field,
            "write potential and bodies to this file (VTKHDF; ParaView opens it if its name ends in .hdf)"},
           {"--picture", &request->picture, "draw potential and conductors into this file: .png, .pdf or .svg"},
           {"--overwrite", &request->overwrite, "replace the files of --field, --picture and --json if they exist"}},
          [request] {
            const std::string json = request->json.file();
            check_overwrite(request->overwrite, {json, request->picture, request->field},
                            "--field, --picture or --json=FILE");
            check_different({json, request->picture, request->field});
            check_files(*request);
            check_outputs({json, request->picture}, {request->scene}, request->overwrite);
            Scene scene = read_scene_for(request->scene, request->device, request->settings);
            if (scene.reference) {
              check_for_grains(*request);
              return solve_grains(scene, request->json);
            }
            const Answer answer = solve(*request, std::move(scene));
            if (!request->json.printed()) print_table(answer);
            request->json.put(json_of(answer), 2);
            print_warnings(warnings_of(answer));
          }};
}

}  // namespace lichtenberg
