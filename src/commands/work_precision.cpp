#include "src/commands/work_precision.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string scene, picture;
  JsonTarget json;
  std::vector<std::string> settings;
  bool time = false, overwrite = false;
  work_precision::Request request;
};

void check(const Arguments& arguments) {
  if (parallel::process_count() > 1)
    throw InputError("work-precision compares methods on one process: leave mpirun out");
  if (arguments.time && !arguments.request.sizes.empty())
    throw InputError("--sizes goes with the field, not with --time: there the scene's field.cells holds");
  if (!(arguments.request.seconds > 0)) throw InputError("--seconds must be positive");
  check_picture("--out", arguments.picture);
  check_output("--out", arguments.picture, arguments.overwrite);
  check_outputs({arguments.picture}, {arguments.scene}, arguments.overwrite);
  const std::string json = arguments.json.file();
  if (json.empty()) return;
  check_output("--json", json, arguments.overwrite);
  if (fs::absolute(json).lexically_normal() == fs::absolute(arguments.picture).lexically_normal())
    throw InputError(fmt::format("--json {0}: the picture is written to {0}; give one of them another name", json));
  check_outputs({json}, {arguments.scene}, arguments.overwrite);
}

std::string default_picture(const Arguments& arguments) {
  return fs::path(arguments.scene).stem().string() + (arguments.time ? "-time-precision.png" : "-work-precision.png");
}

/// Which candidate is being measured, on standard error: one line rewritten in place on a terminal, elsewhere a line a
/// method.
void show_progress(int place, int all, const std::string& method, const work_precision::Settings& settings) {
  static std::string last;
  const std::string where = place == 0 ? "" : fmt::format("{} of {}: ", place, all);
  if (isatty(STDERR_FILENO)) {
    const std::string line = where + method + (settings.empty() ? "" : ", " + work_precision::to_string(settings));
    fmt::print(stderr, "\r\033[K{}", place < all || all == 0 ? line : "");  // \033[K clears the rest of a longer line
  } else if (method != last) {
    fmt::print(stderr, "{}{}\n", where, method);
  }
  last = method;
}

auto sweep_for(const Scene& scene, bool time) {
  if (scene.reference) return time ? work_precision::sweep_grains : work_precision::sweep_charges;
  if (time) return work_precision::sweep_time;
  return scene.dimension() == 3 && scene.effects.has(&EffectKind::field) ? work_precision::sweep_spheres
                                                                         : work_precision::sweep_field;
}

void sweep(Arguments arguments) {
  if (arguments.picture.empty()) arguments.picture = default_picture(arguments);
  check(arguments);
  arguments.request.progress = show_progress;
  const Scene scene = read_scene(arguments.scene, settings_of(arguments.settings));
  const work_precision::Circumstances circumstances = work_precision::circumstances(scene);
  const work_precision::Diagram diagram = sweep_for(scene, arguments.time)(scene, arguments.request);
  if (!arguments.json.printed()) work_precision::print(diagram, circumstances);
  const nlohmann::ordered_json json = work_precision::to_json(diagram, circumstances);
  arguments.json.put(json, 1);
  if (!diagram.points.empty()) draw_json("work_precision.draw_file", json, arguments.picture, arguments.json.printed());
}

}  // namespace

Command work_precision_command() {
  auto arguments = std::make_shared<Arguments>();
  work_precision::Request& request = arguments->request;
  return {"work-precision",
          "Sweeps the accuracy of every method that can solve a scene: error against time, as a table and as a picture",
          {{"SCENE", &arguments->scene, "scene file (.toml)", {.required = true}},
           set_argument(arguments->settings),
           {"--time", &arguments->time,
            "integrators over the scene's motion until stop.time, in place of field solvers at its first instant"},
           {"--methods",
            &request.methods,
            "only these, as in cut-cell,multipole (default: all)",
            {.comma_separated = true}},
           {"--sizes",
            &request.sizes,
            "cells along the longer side (default: 128,256,512,1024,2048)",
            {.comma_separated = true}},
           {"--seconds", &request.seconds, "leave out what is expected to take longer", {.default_shown = true}},
           json_argument(arguments->json, "all figures", true),
           {"--out", &arguments->picture,
            "picture to write: .png, .pdf or .svg (default: the scene's name with -work-precision.png, or "
            "-time-precision.png)"},
           {"--overwrite", &arguments->overwrite, "replace files that exist"}},
          [arguments] { sweep(*arguments); }};
}

}  // namespace lichtenberg
