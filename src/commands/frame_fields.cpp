#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <system_error>

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/grids.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/groups.hpp"
#include "src/model/bodies.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {
namespace {

constexpr int fewest_image_cells = 256, most_image_cells = 1024;
constexpr double cells_in_a_radius = 3;
constexpr double picture_tolerance = 1e-4;  // sufficient because a colour map has 256 levels

/// Returns a number of cells that resolves the smallest conductor; equal for all frames.
int cells_for(const Scene& scene) {
  const Vec2 size = plane(scene.domain.size);
  const double radius = scene.smallest_radius();
  const double wanted = cells_in_a_radius * std::max(size.x, size.y) / radius;
  return laplace::Grids(size).at_least(
      static_cast<int>(std::clamp<double>(wanted, fewest_image_cells, most_image_cells)));
}

/// Returns the electrical groups with the frame's potentials. Conductors fixed by electrodes form one group per
/// potential.
effects::ElectricalGroups groups_of(const Scene& scene, const ConductorFrame& frame) {
  effects::ElectricalGroups groups;
  std::map<std::pair<int, double>, int> first;
  const int conductors = static_cast<int>(frame.position.size());
  for (int i = 0; i < conductors; ++i) {
    groups.id.push_back(first.try_emplace({frame.group[i], frame.potential[i]}, i).first->second);
    groups.potential.push_back(frame.potential[i]);
  }
  const std::vector<effects::Terminal> terminals = effects::terminals_of(scene);
  for (const effects::CircuitNode& circuit : effects::circuit_nodes(scene)) {
    const auto terminal = std::ranges::find(terminals, circuit.node, &effects::Terminal::node);
    const std::size_t k = terminal == terminals.end() ? circuit.supply : terminal->supply;
    groups.id.push_back(static_cast<int>(groups.id.size()));
    groups.potential.push_back(k < frame.terminals.size() ? frame.terminals[k].surface_potential
                                                          : circuit.circuit.potential.value);
  }
  return groups;
}

/// Sets the potentials of electrodes and sides that vary in time, or are in circuits, to those of the frame.
void set_varying_potentials(Scene& scene, const ConductorFrame& frame) {
  const std::vector<effects::Terminal> terminals = effects::terminals_of(scene);
  std::size_t k = 0;
  const auto set = [&](auto& terminal) {
    if (k < frame.terminals.size() && (terminal.potential.varies() || terminal.circuit >= 0))
      terminal.potential = frame.terminals[k].surface_potential;
    ++k;
  };
  for (Electrode& electrode : scene.electrodes) set(electrode);
  for (DomainSide& side : scene.domain.sides)
    if (side.electrode) set(side);
}

laplace::LaplaceProblem problem_of(const Scene& scene, Bodies& bodies, const ConductorFrame& frame) {
  for (std::size_t i = 0; i < frame.position.size(); ++i) {
    for (int k = 0; k < bodies.dimension; ++k) bodies.position[i * bodies.dimension + k] = frame.position[i][k];
  }
  Scene then = scene;
  set_varying_potentials(then, frame);
  return effects::make_laplace_problem(then, bodies, groups_of(scene, frame));
}

/// Writes bytes to standard output. Throws Failure if that fails. Output format: nx and ny as 32-bit integers, then
/// 32-bit floats [frames][ny][nx] (V), NaN for a frame without a solution.
void write_all(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (written < 0)
      throw Failure(
          fmt::format("there is no memory for the fields of the frames ({}): choose fewer of them by --frames",
                      std::generic_category().message(errno)));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

/// Returns the values of the solved field. If the solve fails, prints a message and returns NaN.
std::vector<float> potential_values(laplace::LaplaceSolver& solver, const laplace::LaplaceProblem& problem, int index,
                                    std::size_t count) {
  try {
    solver.solve(problem);
  } catch (const std::exception& error) {
    fmt::print(stderr, "lichtenberg: the field of frame {} is not drawn: {}\n", index, printable(error.what()));
    return std::vector<float>(count, std::numeric_limits<float>::quiet_NaN());
  }
  const laplace::Field field = solver.field();
  return {field.value.begin(), field.value.end()};
}

/// Returns true if the run has a field that can be solved for its frames.
bool has_field(const Result& result) {
  if (result.conductor_frame(0).potential.empty()) return false;
  try {
    const Scene scene = result.scene();
    if (!scene.effects.has(&EffectKind::field) || scene.dimension() == 3) return false;
    laplace::Grids(plane(scene.domain.size));
    return true;
  } catch (const InputError& error) {  // a scene of another version, or a box without square cells
    fmt::print(stderr, "lichtenberg: no field is drawn: {}\n", printable(error.what()));
    return false;
  }
}

struct FieldsRequest {
  std::string file;
  bool quiet = false;
};

/// Reads frame indices, separated by white space, from standard input. `count`: number of frames. Throws InputError.
std::vector<int> chosen_frames(int count) {
  std::vector<int> frames{std::istream_iterator<int>(std::cin), std::istream_iterator<int>()};
  const auto is_there = [&](int frame) { return frame >= 0 && frame < count; };
  if (!std::cin.eof() || !std::ranges::all_of(frames, is_there))
    throw InputError(
        fmt::format("standard input must contain indices of frames from 0 to {}, separated by white space", count - 1));
  return frames;
}

void write_fields(const FieldsRequest& request) {
  const Result result(request.file);
  if (!has_field(result)) return;
  const Scene scene = result.scene();
  const int cells = cells_for(scene);
  const Vec2 size = plane(scene.domain.size);
  const double h = std::max(size.x, size.y) / cells;
  const std::int32_t shape[] = {static_cast<std::int32_t>(std::lround(size.x / h)),
                                static_cast<std::int32_t>(std::lround(size.y / h))};
  write_all(std::as_bytes(std::span(shape)));
  laplace::CutCellSolver solver({.cells = cells, .tolerance = picture_tolerance});
  Bodies bodies = make_bodies(scene);
  const std::vector<int> frames = chosen_frames(result.frames());
  const int count = static_cast<int>(frames.size());
  Progress progress(0, count, request.quiet);
  for (int k = 0; k < count; ++k) {
    const laplace::LaplaceProblem problem = problem_of(scene, bodies, result.conductor_frame(frames[k]));
    const std::vector<float> values =
        potential_values(solver, problem, frames[k], static_cast<std::size_t>(shape[0]) * shape[1]);
    write_all(std::as_bytes(std::span(values)));
    if (progress.due()) progress.show(fmt::format("field of frame {} of {} solved", k + 1, count), k + 1);
  }
}

}  // namespace

Command frame_fields_command() {
  auto request = std::make_shared<FieldsRequest>();
  return {
      "frame-fields",
      "Solves the potential again in the frames that standard input lists, and writes it to standard output "
      "(pictures/fields.py)",
      {{"RESULT", &request->file, "result file of a run (.h5)", {.required = true}}, quiet_argument(request->quiet)},
      [request] { write_fields(*request); }};
}

}  // namespace lichtenberg
