#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include "solvers/laplace/cutcell/level.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/cost.hpp"
#include "src/commands/field_problem.hpp"
#include "src/effects/effects.hpp"

namespace lichtenberg {
namespace {

using Summaries = std::vector<effects::EffectSummary>;

void explain_scene(const Scene& scene) {
  fmt::print("{}{}{}\n", scene.path, scene.title.empty() ? "" : ": ", scene.title);
  fmt::print("  domain               {:g} m x {:g} m\n", scene.domain.size.x, scene.domain.size.y);
  fmt::print("  conductors           {}\n", scene.conductors.size());
  std::vector<std::string> electrodes;
  for (const effects::Terminal& terminal : effects::terminals_of(scene))
    electrodes.push_back(fmt::format("{} at {:g} V", terminal.name, terminal.potential));
  fmt::print("  electrodes           {}\n", electrodes.empty() ? "none" : fmt::to_string(fmt::join(electrodes, ", ")));
}

void explain_effects(const Summaries& effects) {
  for (const bool in_scene : {true, false}) {
    fmt::print("\n{}\n", in_scene ? "effects in the run" : "effects left out, since the scene has no table for them");
    for (const effects::EffectSummary& effect : effects)
      if (effect.in_scene == in_scene) fmt::print("  {:<20} {}\n", effect.name, effect.description);
    if (std::none_of(effects.begin(), effects.end(), [&](const auto& effect) { return effect.in_scene == in_scene; }))
      fmt::print("  none\n");
  }
}

void explain_needs(const Summaries& effects) {
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
  fmt::print("\nthey need\n");
  fmt::print("  computed             {}\n", list(present));
  fmt::print("  not touched          {}\n", list(absent));
}

std::string method_in_words(const FieldOptions& field) {
  if (field.method == "relaxation")
    return "relaxation (D 6.3-6.5): over-relaxed lattice, gradient descent on the floating potentials";
  return fmt::format("cut-cell finite volumes, {} links; conjugate gradients, {}", field.links,
                     field.linear_solver == "multigrid" ? "matrix-free with geometric multigrid"
                                                        : "assembled matrix with a preconditioner of PETSc's");
}

struct Grid {
  int nx, ny;
  double h;  ///< m
  /// Not counted on a grid so large that counting would take a share of the memory that is to be explained.
  std::optional<std::int64_t> fluid_cells;

  double cells() const { return static_cast<double>(nx) * ny; }
};

Grid make_grid(const Scene& scene, const laplace::LaplaceProblem& problem) {
  constexpr double most_to_count = 1 << 24;
  const double h = std::max(problem.size.x, problem.size.y) / scene.field.cells;
  Grid grid{
      static_cast<int>(std::lround(problem.size.x / h)), static_cast<int>(std::lround(problem.size.y / h)), h, {}};
  if (grid.cells() > most_to_count) return grid;
  laplace::Level level(problem, grid.nx, grid.ny);
  level.build(problem, laplace::LinkFormula::log_fitted);
  grid.fluid_cells = level.fluid_cells;
  return grid;
}

void explain_unknowns(const Grid& grid, std::int64_t floating) {
  if (grid.fluid_cells)
    fmt::print(
        "  unknowns             {}: the potentials of {} cells in the fluid and of {} floating group(s) of "
        "conductors\n",
        *grid.fluid_cells + floating, *grid.fluid_cells, floating);
  else
    fmt::print("  unknowns             at most {:.0f}, one a cell, and the potentials of {} floating group(s)\n",
               grid.cells(), floating);
}

void explain_field(const Scene& scene, const laplace::LaplaceProblem& problem, const Grid& grid) {
  const auto floating = std::count_if(problem.groups.begin(), problem.groups.end(),
                                      [](const laplace::Group& group) { return group.floating; });
  fmt::print("\nfield\n");
  fmt::print("  method               {}\n", method_in_words(scene.field));
  fmt::print("  tolerance            {:g} of a single solve, {:g} in a moving scene\n", scene.field.tolerance,
             scene.field.moving_tolerance);
  const double radius = std::ranges::min(scene.conductors, {}, &Conductor::radius).radius;
  fmt::print("  grid                 {} x {} cells of {:.4g} m; the smallest radius is {:.3g} cells{}\n", grid.nx,
             grid.ny, grid.h, radius / grid.h, radius < grid.h ? ", less than one: unresolved" : "");
  explain_unknowns(grid, floating);
}

void explain_cost(const Scene& scene, double cells) {
  const FieldCost cost = estimate_field_cost(scene.field, cells);
  fmt::print("\ncost: an estimate, from figures measured on one core\n");
  fmt::print("  memory               {:.0f} MiB\n", cost.bytes / (1 << 20));
  fmt::print("  a field solve        {:.2g} s on its own, {:.2g} s in a moving scene\n", cost.single_seconds,
             cost.moving_seconds);
  if (const std::optional<double> solves = estimate_field_solves(scene))
    fmt::print("  a run                {:.2g} s: some {:.2g} field solves\n", *solves * cost.moving_seconds, *solves);
  else
    fmt::print("  a run                unknown: figures exist for conductors that are fed, dragged and discharged\n");
}

void explain(const Scene& scene) {
  const Summaries effects = effects::summarize_effects(scene);
  explain_scene(scene);
  explain_effects(effects);
  explain_needs(effects);
  if (!scene.effects.floating_conductors) return;
  const FieldProblem field = make_field_problem(scene);
  field.problem.check();
  const Grid grid = make_grid(scene, field.problem);
  explain_field(scene, field.problem, grid);
  explain_cost(scene, grid.cells());
}

}  // namespace

void add_explain(CLI::App& program) {
  CLI::App* command = program.add_subcommand("explain", "Says what a scene will compute, what not, and what it costs");
  auto scene = std::make_shared<std::string>();
  command->add_option("SCENE", *scene, "scene file (.toml)")->required();
  command->callback([scene] { explain(read_scene(*scene)); });
}

}  // namespace lichtenberg
