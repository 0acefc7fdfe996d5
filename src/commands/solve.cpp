#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/output.hpp"
#include "src/effects/field_choice.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {
namespace {

struct SolveArguments {
  std::string scene, field, device;
  std::vector<std::string> settings;
  bool capacitance = false, json = false, overwrite = false;
};

/// The answer in SI units, the scene's depth multiplied in.
struct Answer {
  Scene scene;
  FieldProblem field;
  laplace::LaplaceSolution solution;  ///< per metre of depth
  std::vector<double> capacitance;    ///< F, groups x groups; empty if not asked for

  int size() const { return static_cast<int>(scene.conductors.size()); }
  double depth() const { return scene.medium.depth; }
  double potential(int i) const { return solution.group_potential[field.problem.bodies[i].group]; }
  double charge(int i) const { return depth() * solution.body_charge[i]; }
  Vec2 force(int i) const { return depth() * solution.body_force[i]; }
  double energy() const { return depth() * solution.energy; }
};

void print_conductors(const Answer& answer) {
  fmt::print("{:>9} {:>12} {:>12} {:>11} {:>6} {:>14} {:>13} {:>13} {:>13}\n", "conductor", "x (m)", "y (m)",
             "radius (m)", "group", "potential (V)", "charge (C)", "force x (N)", "force y (N)");
  for (int i = 0; i < answer.size(); ++i) {
    const Conductor& conductor = answer.scene.conductors[i];
    const Vec2 force = answer.force(i);
    fmt::print("{:>9} {:>12.6g} {:>12.6g} {:>11.4g} {:>6} {:>14.7g} {:>13.6g} {:>13.6g} {:>13.6g}\n", i,
               conductor.position.x, conductor.position.y, conductor.radius, answer.field.groups.id[i],
               answer.potential(i), answer.charge(i), force.x, force.y);
  }
}

void print_capacitance(const Answer& answer) {
  const std::vector<std::string>& names = answer.field.group_names;
  fmt::print("\ncapacitance matrix (F): charge on the row's group when the column's is at 1 V, all others at 0 V\n");
  for (std::size_t row = 0; row < names.size(); ++row) {
    for (std::size_t column = 0; column < names.size(); ++column)
      fmt::print("{:>14.6e}", answer.capacitance[row * names.size() + column]);
    fmt::print("  {}\n", names[row]);
  }
}

void print_table(const Answer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  print_conductors(answer);
  fmt::print("\nenergy      {:.7g} J\n", answer.energy());
  fmt::print("method      {}\n", method_in_words(answer.scene.field()));
  if (answer.scene.field().chosen_for) fmt::print("chosen      {}\n", choice_in_words(answer.scene.field()));
  fmt::print("unknowns    {}\n", solution.unknowns);
  fmt::print("iterations  {}\n", solution.iterations);
  if (solution.work > 0)
    fmt::print("work        {:.1f} evaluations of the residual on the whole grid\n", solution.work);
  fmt::print("residual    {:.2g}\n", solution.residual);
  fmt::print("seconds     {:.4f} setup, {:.4f} solve, {:.4f} forces\n", solution.seconds.setup, solution.seconds.solve,
             solution.seconds.forces);
  if (!answer.capacitance.empty()) print_capacitance(answer);
}

nlohmann::ordered_json conductor_json(const Answer& answer, int i) {
  const Conductor& conductor = answer.scene.conductors[i];
  const Vec2 force = answer.force(i);
  return {{"position", {conductor.position.x, conductor.position.y}},
          {"radius", conductor.radius},
          {"group", answer.field.groups.id[i]},
          {"potential", answer.potential(i)},
          {"charge", answer.charge(i)},
          {"force", {force.x, force.y}}};
}

nlohmann::ordered_json capacitance_json(const Answer& answer) {
  const std::size_t n = answer.field.group_names.size();
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (auto row = answer.capacitance.begin(); row != answer.capacitance.end(); row += n)
    rows.push_back(std::vector<double>(row, row + n));
  return {{"groups", answer.field.group_names}, {"matrix", rows}};
}

void print_json(const Answer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  const FieldOptions& field = answer.scene.field();
  nlohmann::ordered_json json;
  json["conductors"] = nlohmann::ordered_json::array();
  for (int i = 0; i < answer.size(); ++i) json["conductors"].push_back(conductor_json(answer, i));
  json["energy"] = answer.energy();
  json["method"] = name_of(field.method);
  if (field.chosen_for)
    json["accuracy"] = {{"asked", field.chosen_for->asked},
                        {"estimated_error", field.chosen_for->estimate},
                        {"cells", field.cells},
                        {"tolerance", field.tolerance}};
  json["unknowns"] = solution.unknowns;
  json["iterations"] = solution.iterations;
  if (solution.work > 0) json["work"] = solution.work;
  json["residual"] = solution.residual;
  json["seconds"] = {
      {"setup", solution.seconds.setup}, {"solve", solution.seconds.solve}, {"forces", solution.seconds.forces}};
  if (!answer.capacitance.empty()) json["capacitance"] = capacitance_json(answer);
  fmt::print("{}\n", json.dump(2));
}

/// Fills in the solution, and what was chosen for it. Returns its solver.
std::unique_ptr<laplace::LaplaceSolver> solve_as_asked(Answer& answer) {
  if (const FieldRequest* asked = answer.scene.field_request()) {
    laplace::AccurateSolution found =
        solve_to_accuracy(answer.field.problem, effects::accuracy_request(answer.scene, false));
    answer.scene.field_table = effects::field_chosen(*asked, found.choice);
    answer.solution = std::move(found.solution);
    return std::move(found.solver);
  }
  auto solver = effects::make_field_solver(answer.scene.field());
  answer.solution = solver->solve(answer.field.problem);
  return solver;
}

Answer solve(const SolveArguments& request) {
  Answer answer{.scene = read_scene_for(request.scene, request.device, request.settings),
                .field = {},
                .solution = {},
                .capacitance = {}};
  effects::check_processes(&answer.scene.field_table);
  answer.field = make_field_problem(answer.scene);
  const auto solver = solve_as_asked(answer);
  if (!request.field.empty()) write_field_vtkhdf(request.field, solver->field(), request.overwrite);
  if (request.capacitance) answer.capacitance = capacitance_matrix(*solver, answer.field.problem);
  for (double& entry : answer.capacitance) entry *= answer.depth();
  return answer;
}

}  // namespace

Command solve_command() {
  auto request = std::make_shared<SolveArguments>();
  return {"solve",
          "Solves the field of a scene's first instant once",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           device_argument(request->device),
           set_argument(request->settings),
           {"--capacitance", &request->capacitance, "the capacitance matrix as well: one more solve a group"},
           {"--json", &request->json, "print JSON (SI units) in place of a table"},
           {"--field", &request->field, "write potential and bodies to this file (VTKHDF, for ParaView)"},
           {"--overwrite", &request->overwrite, "replace FILE of --field if it exists"}},
          [request] {
            if (!request->field.empty()) check_output("--field", request->field, request->overwrite);
            const Answer answer = solve(*request);
            request->json ? print_json(answer) : print_table(answer);
          }};
}

}  // namespace lichtenberg
