#include "src/commands/work_precision.hpp"

#include <fmt/format.h>
#include <petscsys.h>
#include <sundials/sundials_version.h>

#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/json_output.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

using namespace work_precision;
using Json = nlohmann::ordered_json;

struct SweepArguments {
  std::string scene;
  std::vector<std::string> settings;
  bool time = false;
  Request request;
};

/// Sweep for a kind of scene, and the kind's name for methods of other programs.
struct Kind {
  std::string name;
  void (*sweep)(const Scene&, const Request&);
};

Kind kind_of(const Scene& scene, bool time) {
  if (scene.reference)
    return time ? Kind{"grains", sweep_grains}
                : Kind{scene.effects.has("induced_dipoles") ? "dipoles" : "charges", sweep_charges};
  if (time) return {"motion", sweep_time};
  return scene.dimension() == 3 && scene.effects.has(&EffectKind::field) ? Kind{"spheres", sweep_spheres}
                                                                         : Kind{"field", sweep_field};
}

/// Returns the names of this kind among "KIND/NAME".
std::vector<std::string> names_of_kind(const std::string& kind, const std::vector<std::string>& methods) {
  std::vector<std::string> names;
  for (const std::string& method : methods)
    if (method.starts_with(kind + "/")) names.push_back(method.substr(kind.size() + 1));
  return names;
}

std::string versions() {
  const Version own = lichtenberg_version();
  std::array<char, 32> sundials{};
  SUNDIALSGetVersion(sundials.data(), static_cast<int>(sundials.size()));
  return fmt::format("lichtenberg {} ({}), PETSc {}.{}.{}, SUNDIALS {}, {}", own.number, own.commit,
                     PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, sundials.data(), own.compiler);
}

/// Returns the load average of the last minute.
double load_average() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

Json to_json(const Method& method) {
  Json json{{"name", method.name}, {"description", method.description}, {"candidates", Json::array()}};
  for (const Candidate& candidate : method.candidates) {
    Json settings = Json::array();
    for (const auto& [name, value] : candidate.settings) settings.push_back(Json::array({name, value}));
    json["candidates"].push_back(Json::array({settings, candidate.cost}));
  }
  return json;
}

Json to_json(const Diagram& diagram, double load, const std::string& scene) {
  const Provenance here = provenance();
  return {{"scene", scene},
          {"title", diagram.title},
          {"processor", here.processor},
          {"cores", here.cores},
          {"load", load},
          {"versions", versions()},
          {"errors", diagram.measure},
          {"reference", diagram.reference},
          {"work", diagram.work},
          {"time", diagram.clock},
          {"quantities", diagram.quantities},
          {"reference_errors", diagram.reference_errors}};
}

Json measurement_json(const Candidate& candidate) {
  try {
    const Point point = measure(candidate);
    Json json{{"errors", point.errors}, {"seconds", point.seconds}, {"cores", point.cores}, {"work", point.work}};
    if (point.evaluations > 0) json["evaluations"] = point.evaluations;
    if (point.mebibytes) json["mebibytes"] = *point.mebibytes;
    return json;
  } catch (const InputError& error) {
    return {{"refused", error.what()}};
  } catch (const Failure& error) {
    return {{"failed", error.what()}};
  }
}

/// Returns the errors of the answer of another program's method, or why that answer cannot be compared.
Json errors_of(const Diagram& diagram, const Json& answer) {
  try {
    return {{"errors", diagram.errors(answer)}};
  } catch (const InputError& error) {
    return {{"failed", error.what()}};
  } catch (const std::exception& error) {  // of json for a wrong type, of at() for too few values
    return {{"failed",
             fmt::format("its answer does not have the form that methods/__init__.py describes ({})", error.what())}};
  }
}

/// Reports the start of the reference computation, then the subject and its methods, then measures as requested.
void serve_sweep(SweepArguments arguments) {
  const Scene scene = read_scene_for(arguments.scene, "", arguments.settings);
  const double load = load_average();
  const Kind kind = kind_of(scene, arguments.time);
  arguments.request.others = names_of_kind(kind.name, arguments.request.others);
  arguments.request.begin = [] { print_json_line({{"reference", "begun"}}); };
  arguments.request.serve = [&](const Diagram& diagram, const std::vector<Method>& methods) {
    Json json = to_json(diagram, load, scene.path);
    json["kind"] = kind.name;
    if (diagram.subject) json["subject"] = diagram.subject();
    json["methods"] = Json::array();
    for (const Method& method : methods) json["methods"].push_back(to_json(method));
    print_json_line(json);
    answer_questions([&](const Json& question) -> Json {
      if (question.contains("errors")) return errors_of(diagram, question["errors"]);
      return measurement_json(methods.at(question.at("method")).candidates.at(question.at("candidate")));
    });
  };
  kind.sweep(scene, arguments.request);
}

}  // namespace

Command work_precision_methods_command() {
  auto arguments = std::make_shared<SweepArguments>();
  Request& request = arguments->request;
  return {"work-precision-methods",
          "Lists and measures methods that can solve a scene (commands/work_precision.py)",
          {{"SCENE", &arguments->scene, "scene file (.toml)", {.required = true}},
           set_argument(arguments->settings),
           {"--time", &arguments->time, "as of work-precision"},
           {"--methods", &request.methods, "as of work-precision", {.repeated = true}},
           {"--others", &request.others, "KIND/NAME of methods that the package has", {.repeated = true}},
           {"--sizes", &request.sizes, "as of work-precision", {.repeated = true}}},
          [arguments] { serve_sweep(*arguments); }};
}

}  // namespace lichtenberg
