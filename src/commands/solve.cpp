#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/field_answer.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/python.hpp"
#include "src/commands/scratch_folder.hpp"
#include "src/commands/solve_grains.hpp"
#include "src/commands/start_from.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/model/bodies.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {
namespace {

struct SolveArguments {
  std::string scene, field, picture, device, from;
  std::vector<std::string> settings;
  std::optional<int> frame;
  bool capacitance = false, overwrite = false;
  JsonTarget json;
};

void print_conductors(const FieldAnswer& answer) {
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

void print_terminals(const FieldAnswer& answer) {
  const std::vector<TerminalAnswer> all = terminals(answer);
  if (all.empty()) return;
  fmt::print("\n{:>14} {:>13}  electrode\n", "potential (V)", "charge (C)");
  for (const auto& [name, potential, charge, group] : all)  // for sides that meet at an edge only the sum is known
    fmt::print("{:>14.7g} {:>13}  {}\n", potential, std::isnan(charge) ? "unknown" : fmt::format("{:.6g}", charge),
               name);
}

void print_curve_forces(const FieldAnswer& answer) {
  const std::vector<CurveForce> all = curve_forces(answer);
  if (all.empty()) return;
  fmt::print("\n{:>13} {:>13} {:>13}  on the electrode, about its centroid\n", "force x (N)", "force y (N)",
             "torque (N m)");
  for (const auto& [name, force, torque, centroid] : all)
    fmt::print("{:>13.6g} {:>13.6g} {:>13.6g}  \"{}\", [{:.6g}, {:.6g}] m\n", force.x, force.y, torque, name,
               centroid.x, centroid.y);
}

void print_capacitance(const FieldAnswer& answer) {
  const auto& [names, matrix] = answer.capacitance;
  fmt::print("\ncapacitance matrix (F): charge on the row's group when the column's is at 1 V, all others at 0 V\n");
  for (std::size_t row = 0; row < names.size(); ++row) {
    for (std::size_t column = 0; column < names.size(); ++column)
      fmt::print("{:>14.6e}", matrix[row * names.size() + column]);
    fmt::print("  {}: {}\n", row, names[row]);
  }
}

void print_table(const FieldAnswer& answer) {
  const laplace::LaplaceSolution& solution = answer.solution;
  if (answer.size() > 0) print_conductors(answer);
  print_terminals(answer);
  print_curve_forces(answer);
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

nlohmann::ordered_json conductor_json(const FieldAnswer& answer, int i) {
  const Conductor& conductor = answer.scene.conductors[i];
  return {{"position", components(conductor.position, answer.scene.dimension())},
          {"radius", conductor.radius},
          {"group", answer.field.group_of_body[i]},
          {"potential", answer.potential(i)},
          {"charge", answer.charge(i)},
          {"force", components(answer.force[i], answer.scene.dimension())}};
}

nlohmann::ordered_json json_of(const FieldAnswer& answer) {
  nlohmann::ordered_json json{{"conductors", nlohmann::ordered_json::array()}};
  for (int i = 0; i < answer.size(); ++i) json["conductors"].push_back(conductor_json(answer, i));
  json.update(summary_json(answer));
  return json;
}

/// Returns the frame that a run of the scene would record at its start.
ConductorFrame frame_of(const FieldAnswer& answer) {
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
void draw_solution(const FieldAnswer& answer, const std::string& picture) {
  const ScratchFolder folder;
  const std::string file = folder.file("solution.h5");
  {
    Recorder recorder = Recorder::start(file, answer.scene, make_bodies(answer.scene).mass, false);
    Frame frame = columns_of(frame_of(answer));
    // defines the quantity of the colours
    if (answer.size() == 0) frame.add_particles("potential", "V", std::vector<double>{});
    recorder.add(std::move(frame));
    Milestone milestone;
    milestone.field = answer.potential_field;
    milestone.warnings = warnings_of(answer);
    recorder.save(milestone);
  }
  draw("frames.draw_solution", {file, picture});
}

/// Throws InputError for options that need conductors or a grid.
void check_for_grains(const SolveArguments& request) {
  const auto refuse_it = [](const char* option) {
    throw InputError(fmt::format("option {} is for scenes of conductors: leave it out for charged grains", option));
  };
  if (request.capacitance) refuse_it("--capacitance");
  if (!request.field.empty()) refuse_it("--field");
  if (!request.picture.empty()) refuse_it("--out");
  if (request.device.starts_with(name_of(FieldDevice::cuda))) refuse_it("--device cuda");
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
    check_picture("--out", request.picture);
    check_output("--out", request.picture, request.overwrite);
  }
  if (request.field.empty()) return;
  check_not_read(request.field, {request.scene, request.from});
  check_output("--field", request.field, request.overwrite);
  if (is_result(request.field))
    throw InputError(request.field + " is a result and is not overwritten: give --field another name");
}

}  // namespace

Command solve_command() {
  auto request = std::make_shared<SolveArguments>();
  const std::vector<Argument> from = from_arguments(request->from, request->frame);
  return {
      "solve",
      "Solves the field of a scene's initial state once, for conductors or for charged grains",
      {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
       device_argument(request->device),
       set_argument(request->settings),
       from[0],
       from[1],
       {"--capacitance", &request->capacitance, "also compute the capacitance matrix: one more solve per group"},
       json_argument(request->json, "SI units; reduced units for grains"),
       {"--field", &request->field,
        "VTKHDF file to write, with potential and bodies; ParaView opens it if its name ends in .hdf"},
       {"--out", &request->picture, "picture to write, of potential and conductors: .png, .pdf or .svg"},
       overwrite_argument(request->overwrite)},
      [request] {
        const std::string json = request->json.file();
        check_overwrite(request->overwrite, {json, request->picture, request->field}, "--field, --out or --json=FILE");
        check_different({json, request->picture, request->field});
        check_files(*request);
        check_outputs({json, request->picture}, {request->scene, request->from}, request->overwrite);
        Scene scene = read_started(request->from, request->frame, [&](const std::vector<Conductor>& bodies) {
          return read_scene_for(request->scene, request->device, request->settings, {}, bodies);
        });
        if (scene.reference) {
          check_for_grains(*request);
          return solve_grains(scene, request->json);
        }
        if (scene.dimension() == 3 && !request->field.empty())
          throw InputError("--field is for scenes in two dimensions: the field of spheres in space is not on a grid");
        const bool needs_potential = scene.dimension() == 2 && (!request->field.empty() || !request->picture.empty());
        const FieldAnswer answer =
            solve_field(std::move(scene), {.capacitance = request->capacitance, .potential_field = needs_potential});
        if (!request->field.empty()) write_field_vtkhdf(request->field, *answer.potential_field, request->overwrite);
        if (!request->picture.empty()) draw_solution(answer, request->picture);
        if (!request->json.printed()) print_table(answer);
        request->json.put(json_of(answer), 2);
        print_warnings(warnings_of(answer));
      }};
}

}  // namespace lichtenberg
