#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/cost.hpp"
#include "src/commands/device.hpp"
#include "src/commands/explain_grains.hpp"
#include "src/commands/explanation.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/start_from.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/circuits.hpp"

namespace lichtenberg {
namespace {

using Summaries = std::vector<effects::EffectSummary>;

void explain_scene(Explanation& out, const Scene& scene) {
  out.json = {{"scene", scene.path}, {"title", scene.title}, {"effects", nlohmann::ordered_json::array()}};
  out.add("particles", scene.conductors.size(), "1");
  out.print("{}{}{}\n", printable(scene.path), scene.title.empty() ? "" : ": ", printable(scene.title));
  const std::string unit = scene.units().length;
  out.print("  domain               {:g} {} x {:g} {}{}\n", scene.domain.size.x, unit, scene.domain.size.y, unit,
            (scene.dimension() == 3 ? fmt::format(" x {:g} {}", scene.domain.size.z, unit) : "") +
                (scene.domain.open ? " of free space" : ""));
  if (const Vec3 e = scene.domain.uniform_field; norm2(e) > 0)
    out.print("  uniform field        [{:g}, {:g}, {:g}] V/m\n", e.x, e.y, e.z);
  if (scene.reference) return out.print("  grains               {}\n", scene.conductors.size());
  out.print("  conductors           {}\n", scene.conductors.size());
  std::vector<std::string> electrodes;
  for (const effects::Terminal& terminal : effects::terminals_of(scene))
    electrodes.push_back(terminal.series_resistance > 0
                             ? fmt::format("{} behind {:g} ohm from {}", terminal.name, terminal.series_resistance,
                                           in_words(terminal.potential))
                         : terminal.node >= 0 ? fmt::format("{} in a circuit", terminal.name)
                                              : fmt::format("{} at {}", terminal.name, in_words(terminal.potential)));
  constexpr std::size_t most = 12;  // a torus has many
  if (electrodes.size() > most) {
    const std::string last = electrodes.back();
    electrodes.resize(most - 2);
    electrodes.insert(electrodes.end(), {"...", last});
  }
  out.print("  electrodes           {}\n", electrodes.empty() ? "none" : fmt::to_string(fmt::join(electrodes, ", ")));
}

void explain_effect(Explanation& out, const effects::EffectSummary& effect) {
  out.print("  {:<20} {}\n", effect.name, effect.description);
  for (const ExplanationLine& line : effect.explanation) out.print("    {:<18} {}\n", line.label, line.text);
}

void explain_effects(Explanation& out, const Summaries& effects) {
  for (const effects::EffectSummary& effect : effects)
    if (effect.in_scene) out.json["effects"].push_back(effect.name);
  for (const bool in_scene : {true, false}) {
    out.print("\n{}\n",
              in_scene ? "effects in the run" : "effects not computed, because the scene has no table for them");
    for (const effects::EffectSummary& effect : effects)
      if (effect.in_scene == in_scene) explain_effect(out, effect);
    if (std::none_of(effects.begin(), effects.end(), [&](const auto& effect) { return effect.in_scene == in_scene; }))
      out.print("  none\n");
  }
}

void explain_needs(Explanation& out, const Summaries& effects) {
  std::vector<std::string> present, absent;
  const auto sort_in = [&](const std::string& what, auto needed) {
    (std::any_of(effects.begin(), effects.end(), needed) ? present : absent).push_back(what);
  };
  sort_in("charges", [](const auto& effect) { return effect.needs.charges; });
  sort_in("field", [](const auto& effect) { return effect.needs.field; });
  sort_in("neighbour list", [](const auto& effect) { return effect.needs.neighbour_range.has_value(); });
  const auto list = [](const auto& words) {
    return words.empty() ? "nothing" : fmt::to_string(fmt::join(words, ", "));
  };
  out.print("\nquantities for these effects\n");
  out.print("  computed             {}\n", list(present));
  out.print("  not needed           {}\n", list(absent));
}

/// Describes the sources of a circuit.
std::string in_words(const Circuit& circuit) {
  std::string text = circuit.resistance > 0
                         ? fmt::format("{} behind {:g} ohm", in_words(circuit.potential), circuit.resistance)
                     : circuit.current ? ""
                                       : fmt::format("floats with {:g} C at the start", circuit.charge);
  if (circuit.current)
    text += fmt::format("{}{:g} A{}", text.empty() ? "" : ", ", circuit.current->value,
                        circuit.current->varies() ? " at the start, varying in time" : "");
  if (circuit.capacitance > 0) text += fmt::format(", {:g} F to 0 V", circuit.capacitance);
  return text;
}

/// Prints how terminals with resistors are treated and which circuit quantities are recorded.
void explain_circuit(Explanation& out, const Scene& scene) {
  if (!effects::has_circuit(scene)) return;
  out.print("\ncircuit\n");
  for (const effects::Terminal& terminal : effects::terminals_of(scene))
    if (terminal.series_resistance > 0)
      out.print("  {:<20} charged through its resistor, coupled to the field; the error limits the steps\n",
                terminal.name);
  for (const Circuit& circuit : scene.circuits) out.print("  {:<20} {}\n", circuit.name, in_words(circuit));
  out.print("  recorded             current and potential by terminal, structure resistance, power and entropy\n");
}

struct ExplainedGrid {
  int nx, ny;
  double h;  ///< m
  /// Number of grid cells in the fluid. Empty on large grids, where counting would need a considerable part of the
  /// memory to be reported.
  std::optional<std::int64_t> fluid_cells;

  double cells() const { return static_cast<double>(nx) * ny; }
};

ExplainedGrid make_grid(const Scene& scene, const laplace::LaplaceProblem& problem) {
  constexpr double most_to_count = 1 << 24;
  const double h = std::max(problem.size.x, problem.size.y) / scene.field().cells;
  ExplainedGrid grid{
      static_cast<int>(std::lround(problem.size.x / h)), static_cast<int>(std::lround(problem.size.y / h)), h, {}};
  if (grid.cells() > most_to_count) return grid;
  laplace::Level level(problem, grid.nx, grid.ny);
  laplace::LevelBuilder().build(problem, laplace::LinkFormula::log_fitted, level);
  grid.fluid_cells = level.fluid_cells;
  return grid;
}

void explain_cells(Explanation& out, const ExplainedGrid& grid, std::int64_t floating) {
  if (grid.fluid_cells) out.add("unknowns", *grid.fluid_cells + floating, "1");
  if (grid.fluid_cells)
    out.print(
        "  unknowns             {}: the potentials of {} cells in the fluid and of {} floating group(s) of "
        "conductors\n",
        *grid.fluid_cells + floating, *grid.fluid_cells, floating);
  else
    out.print("  unknowns             at most {:.0f}, one per cell, and the potentials of {} floating group(s)\n",
              grid.cells(), floating);
}

std::string resolution_in_words(const Scene& scene, double h) {
  if (scene.conductors.empty()) return "";
  const double radius = scene.smallest_radius();
  return fmt::format("; the smallest radius is {:.3g} cells{}", radius / h,
                     radius < h ? ", less than one: unresolved" : "");
}

/// Prints the grid of a method. Returns its number of cells.
double explain_grid(Explanation& out, const Scene& scene, const laplace::LaplaceProblem& problem) {
  const ExplainedGrid grid = make_grid(scene, problem);
  out.print("  grid                 {} x {} cells of {:.4g} m{}\n", grid.nx, grid.ny, grid.h,
            resolution_in_words(scene, grid.h));
  out.add("cells", grid.cells(), "1");
  explain_cells(out, grid, std::ranges::count(problem.groups, true, &laplace::Group::floating));
  return grid.cells();
}

/// Prints the unknowns of a method without a grid. Returns their number.
double explain_unknowns(Explanation& out, const Scene& scene, const laplace::LaplaceProblem& problem) {
  const FieldOptions& field = scene.field();
  const long bodies = static_cast<long>(problem.bodies.size());
  const long unknowns = field.method->unknowns ? field.method->unknowns(problem, field) : bodies;
  out.add("unknowns", unknowns, "1");
  out.print("  grid                 none\n");
  out.print("  unknowns             {}: about {} per disk, more in narrow gaps\n", unknowns,
            unknowns / std::max(bodies, 1L));
  return static_cast<double>(unknowns);
}

/// Prints the expected choice for an accuracy, without a solve.
void explain_accuracy(Explanation& out, const Scene& scene) {
  if (!scene.field_accuracy()) return;
  out.print(
      "  accuracy             {:g}: {} should suffice; `solve` and `run` measure the error and refine if necessary\n",
      scene.field_accuracy()->requested,
      scene.field().method->on_grid ? fmt::format("some {} cells", scene.field().cells) : "this tolerance");
}

/// Prints the field method. Returns the size that determines the cost: cells or unknowns.
double explain_field(Explanation& out, const Scene& scene, const laplace::LaplaceProblem& problem) {
  out.print("\nfield\n");
  out.print("  method               {}\n", method_in_words(scene.field()));
  explain_accuracy(out, scene);
  out.print("  tolerance            {:g} of a single solve, {:g} in a moving scene\n", scene.field().tolerance,
            scene.field().moving_tolerance);
  return scene.field().method->on_grid ? explain_grid(out, scene, problem) : explain_unknowns(out, scene, problem);
}

/// Returns why the scene's own method cannot be used in a run; empty if it can, or if a run would choose a method.
std::string refusal_of_run(const Scene& scene) {
  try {
    effects::check_device(scene);
    effects::check_can_move(scene);
    return "";
  } catch (const InputError& refusal) {
    return refusal.what();
  }
}

/// Prints the number of field solves and their time. `size`: number of cells of the field's grid.
void explain_solves(Explanation& out, const Scene& scene, double size, const FieldCost& cost,
                    const FieldSolves& solves) {
  const double around =
      field_method_cost(scene.field()).seconds_a_conductor * static_cast<double>(scene.conductors.size());
  double seconds = solves.whole * cost.moving_seconds + (solves.whole + solves.predictions) * around;
  std::string predictions;
  if (solves.predictions > 0) {
    const int cells = effects::predictor_cells(scene);
    const double coarsening = static_cast<double>(scene.field().cells) / cells;
    seconds += solves.predictions * estimate_field_cost(scene.field(), size / (coarsening * coarsening)).moving_seconds;
    predictions = fmt::format(", and {:.2g} predictions on {} cells between them", solves.predictions, cells);
  }
  out.add("field_solves", solves.whole, "1");
  out.add("run_time", seconds, "s");
  out.print("  a run                {}, without recording and pictures: about {:.2g} field solves{}\n",
            duration(seconds), solves.whole, predictions);
}

bool is_for_a_run(const Scene& scene) {
  return std::ranges::any_of(scene.effects, [](const Effects::Entry& entry) { return !entry.kind->field; });
}

/// Prints the cost of a run from a trial of two seconds. There is no trial with PETSc options, because it would start
/// PETSc with the options meant for the run.
void explain_trial(Explanation& out, const Scene& scene) {
  if (!parallel::unused_petsc_options().empty())
    return out.print(
        "  a run                no estimate: options after --petsc apply to the run only, so that no trial is made\n");
  const std::optional<TrialRun> trial = run_trial(scene);
  if (!trial)
    return out.print(
        "  a run                no estimate: a trial of two seconds reaches less than 0.5 % of it, or fails\n");
  out.add("run_time", trial->seconds, "s");
  if (trial->over)
    return out.print(
        "  a run                {}, without recording and pictures: measured here up to its end at {:.3g} s\n",
        duration(trial->seconds), trial->reached);
  out.print(
      "  a run                {}{}, without recording and pictures: extrapolated from the first {:.3g} of {:.3g} s, "
      "measured here\n",
      scene.stop.stationary ? "at most " : "", duration(trial->seconds), trial->reached, scene.stop.time);
}

/// The number of solves is known only for conductors that are charged, dragged and discharged. Other scenes are tried
/// if a single solve takes a small part of the trial's time.
void explain_unknown_solves(Explanation& out, const Scene& scene, const FieldCost& cost) {
  constexpr double longest_solve = 0.1;  // s
  if (cost.single_seconds <= longest_solve && !runs_on_device(scene.field()) &&
      scene.field().linear_solver != FieldLinearSolver::assembled)  // PETSc has not been started
    return explain_trial(out, scene);
  out.print(
      "  a run                no estimate: the number of field solves is known only for conductors with a current "
      "source, drag and contact discharge\n");
}

/// Prints the cost of conductors that move without a field.
void explain_motion_cost(Explanation& out, const Scene& scene, const std::string& refusal) {
  if (scene.conductors.empty()) return;
  out.print("\ncost: an estimate, from a trial on this machine\n");
  if (!refusal.empty()) return out.refuse(refusal);
  explain_trial(out, scene);
}

void explain_run(Explanation& out, const Scene& scene, double size, const FieldCost& cost, const std::string& refusal) {
  if (scene.conductors.empty())
    out.print("  a run                none: without conductors nothing moves\n");
  else if (!refusal.empty())
    out.refuse(refusal);
  else if (const std::optional<FieldSolves> solves = estimate_field_solves(scene))
    explain_solves(out, scene, size, cost, *solves);
  else
    explain_unknown_solves(out, scene, cost);
}

void explain_cost(Explanation& out, const Scene& scene, double size, const FieldCost& cost,
                  const std::string& refusal_of_run) {
  out.print("\ncost: an estimate, from figures measured on {}\n",
            runs_on_device(scene.field()) ? "an H200" : "one core");
  out.add("memory", cost.bytes, "B");
  out.add("solve_time", cost.single_seconds, "s");
  out.add("moving_solve_time", cost.moving_seconds, "s");
  out.print("  memory               {:.0f} MiB\n", cost.bytes / (1 << 20));
  out.print("  a field solve        {} on its own, {} in a moving scene\n", duration(cost.single_seconds),
            duration(cost.moving_seconds));
  explain_run(out, scene, size, cost, refusal_of_run);
}

void explain_packing_cost(Explanation& out, const Scene& scene) {
  out.print("\ncost: an estimate, from figures measured on one core\n");
  if (scene.compression.loads() > 0)
    return out.print(
        "  a run                no estimate: it minimizes once for each step of compression.step in the packing "
        "fraction\n");
  const std::optional<PackingCost> cost = estimate_packing_cost(scene);
  if (!cost)
    return out.print(
        "  a run                no estimate: gradient descent takes about a thousand times as long as the default\n");
  out.add("filling", cost->filling, "1");
  out.add("iterations", cost->iterations, "1");
  out.add("run_time", cost->seconds, "s");
  out.print("  filling              {:.4g} of the domain, overlaps counted twice\n", cost->filling);
  out.print(
      "  a run                {}, without recording and pictures: about {:.2g} iterations, within a factor of three\n",
      duration(cost->seconds), cost->iterations);
}

/// Prints the time for the picture at the end of a run (docs/measurements/explain.json).
void explain_pictures(Explanation& out, const Scene& scene) {
  if (!scene.output.picture || scene.conductors.empty()) return;
  const double series = scene.reference ? 1 : 0;
  const double seconds = 1 + series + 1e-5 * static_cast<double>(scene.conductors.size());
  out.add("picture_time", seconds, "s");
  out.print("  its picture{}         {} more\n", scene.reference ? "s" : " ", duration(seconds));
}

void explain_plane_cost(Explanation& out, const Scene& scene, double size, const std::string& refusal_of_run) {
  explain_cost(out, scene, size, estimate_field_cost(scene.field(), size), refusal_of_run);
}

/// Returns the expected degrees and unknowns of spheres at this tolerance.
laplace::SphereForecast forecast(const Scene& scene, const laplace::SphereProblem& problem, double tolerance) {
  FieldOptions field = scene.field();
  field.tolerance = tolerance;
  return effects::make_sphere_solver(field, problem.spheres.size()).forecast(problem);
}

std::string in_words(const laplace::SphereForecast& forecast) {
  return fmt::format(
      "degree {}{}, {} unknowns",
      forecast.least_degree < forecast.largest_degree ? fmt::format("{} to ", forecast.least_degree) : "",
      forecast.largest_degree, forecast.unknowns);
}

void explain_spheres(Explanation& out, const Scene& scene, const laplace::SphereProblem& problem,
                     const std::string& refusal_of_run) {
  const FieldOptions& field = scene.field();
  const auto single = forecast(scene, problem, field.tolerance),
             moving = forecast(scene, problem, field.moving_tolerance);
  out.print("\nfield\n");
  out.print("  method               {}\n", method_in_words(field));
  explain_accuracy(out, scene);
  out.print("  tolerance            {:g} of a single solve, {:g} in a moving scene{}\n", field.tolerance,
            field.moving_tolerance,
            scene.field_accuracy() ? "" : "; relative to the largest value, without an error estimate");
  out.print("  spheres              {}, with {} floating group(s)\n", problem.spheres.size(),
            std::ranges::count(problem.groups, true, &laplace::Group::floating));
  out.add("unknowns", single.unknowns, "1");
  out.print("  harmonics            {} of a single solve\n", in_words(single));
  out.print("                       {} in a moving scene, as it starts\n", in_words(moving));
  const FieldCost cost =
      estimate_sphere_cost(field, static_cast<double>(single.unknowns), static_cast<double>(moving.unknowns));
  explain_cost(out, scene, static_cast<double>(moving.unknowns), cost, refusal_of_run);
}

/// Returns the expected choice of method: for a run if the scene contains more than a field, otherwise for `solve`.
FieldOptions predicted_field_options(const Scene& scene, const laplace::LaplaceProblem& problem) {
  return effects::field_chosen(*scene.field_request(),
                               laplace::predict_choice(problem, effects::accuracy_request(scene, is_for_a_run(scene))));
}

void explain(Explanation& out, Scene scene) {
  // Errors come first: charge without a neutralizing electrode, an unattainable accuracy, a missing device.
  std::optional<FieldProblem> field;
  const std::string refusal = refusal_of_run(scene);  // before the choice of a method, which may suit `solve` only
  if (scene.effects.has(&EffectKind::field)) {
    field = make_field_problem(scene);
    scene.dimension() == 3 ? field->spheres.check() : field->problem.check();
    if (scene.field_request()) scene.field_table = predicted_field_options(scene, field->problem);
    if (scene.dimension() == 2) effects::make_field_solver(scene.field());
  }
  const Summaries effects = effects::summarize_effects(scene);
  explain_scene(out, scene);
  explain_effects(out, effects);
  explain_needs(out, effects);
  explain_circuit(out, scene);
  if (scene.reference) explain_grains(out, scene);
  if (field && scene.dimension() == 3) explain_spheres(out, scene, field->spheres, refusal);
  if (field && scene.dimension() == 2)
    explain_plane_cost(out, scene, explain_field(out, scene, field->problem), refusal);
  if (scene.effects.has(&EffectKind::packing)) explain_packing_cost(out, scene);
  if (!field && !scene.reference && !scene.effects.has(&EffectKind::packing)) explain_motion_cost(out, scene, refusal);
  if (refusal.empty()) explain_pictures(out, scene);
}

}  // namespace

Command explain_command() {
  struct Arguments {
    std::string scene, device, from;
    std::optional<int> frame;
    std::vector<std::string> settings;
    JsonTarget json;
    bool overwrite = false;
  };
  auto request = std::make_shared<Arguments>();
  const std::vector<Argument> from = from_arguments(request->from, request->frame);
  return {"explain",
          "Prints what a run of a scene computes and neglects, and its cost",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           device_argument(request->device),
           set_argument(request->settings),
           from[0],
           from[1],
           json_argument(request->json, "sizes, and estimates of memory and time"),
           overwrite_argument(request->overwrite)},
          [request] {
            const std::string file = request->json.file();
            check_overwrite(request->overwrite, {file}, "--json=FILE");
            check_outputs({file}, {request->scene, request->from}, request->overwrite);
            Explanation out;
            explain(out, read_started(request->from, request->frame, [&](const std::vector<Conductor>& bodies) {
                      return read_scene_for(request->scene, request->device, request->settings, {}, bodies);
                    }));
            if (!request->json.printed()) fmt::print("{}", out.text);
            request->json.put(out.json, 1);
          }};
}

}  // namespace lichtenberg
