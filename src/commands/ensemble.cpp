#include "src/commands/ensemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "src/analysis/statistics.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/device/device.hpp"
#include "src/scene/old_names.hpp"
#include "src/scene/schema.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

using ensemble::Member;
using ensemble::Variation;
using Json = nlohmann::ordered_json;

struct EnsembleArguments {
  std::string scene, folder, device, conductors;
  std::vector<std::string> vary, settings;
  int seeds = 1;
};

/// Reads a variation. Warns if the key is written with a former name.
Variation read_variation(const std::string& written, const Schema& schema) {
  const std::size_t equals = written.find('=');
  if (equals == std::string::npos)
    throw InputError(
        fmt::format("--vary {} is not valid: it must be KEY=VALUE,VALUE,..., as in --vary "
                    "effects.contact_discharge.contact_distance=0.4e-3,0.775e-3",
                    written));
  std::string key = written.substr(0, equals);
  while (key.ends_with(' ')) key.pop_back();
  const std::string name = without_old_names(key, schema);
  if (name != key) fmt::print(stderr, "lichtenberg: {}\n", printable(old_name_warning(key, name)));
  return {name, listed_values(written.substr(equals + 1))};
}

/// Returns `count` consecutive seeds, beginning with the scene's own.
Variation seeds_from(std::uint64_t first, int count) {
  constexpr int most = 100'000;
  if (count > most)
    throw InputError(fmt::format("--seeds {} is not allowed: at most {} seeds are allowed", count, most));
  Variation seeds{"seed", {}};
  for (int k = 0; k < count; ++k) seeds.values.push_back(std::to_string(first + static_cast<std::uint64_t>(k)));
  return seeds;
}

/// Returns the key without the index 0, which may be left out if a repeated table has one element.
std::string without_first_index(std::string key) {
  if (const std::size_t index = key.find("[0]"); index != std::string::npos) key.erase(index, 3);
  return key;
}

std::vector<Variation> variations_of(const EnsembleArguments& request, const Scene& scene) {
  const Schema schema(effects::all_kinds());
  std::vector<Variation> variations;
  if (!request.conductors.empty()) variations.push_back({"population.count", listed_values(request.conductors)});
  for (const std::string& written : request.vary) variations.push_back(read_variation(written, schema));
  if (request.seeds != 1) variations.push_back(seeds_from(scene.seed, request.seeds));
  const auto key_of = [](const Variation& variation) { return without_first_index(variation.key); };
  for (const Variation& variation : variations)
    if (std::ranges::count(variations, key_of(variation), key_of) > 1)
      throw InputError(fmt::format("key {} is varied twice: list all its values in one place", key_of(variation)));
  return variations;
}

/// Returns the values of --device for members that run side by side, one for each CUDA device of a list; none without
/// a list. Throws InputError for a list and a field, whose members share no device.
std::vector<std::string> devices_of(const Scene& scene) {
  std::vector<std::string> devices;
  if (scene.cuda_devices.empty()) return devices;
  if (!scene.reference)
    throw InputError(
        fmt::format("{}: an ensemble of fields needs --device cuda, without a list of devices", scene.path));
  for (const int number : granular::device::chosen_devices(scene)) devices.push_back(fmt::format("cuda:{}", number));
  return devices;
}

/// Returns [key, TOML text, JSON value]. Numbers, texts and arrays are valid JSON; other values become texts.
Json to_json(const Setting& setting) {
  const Json value = Json::parse(setting.value, nullptr, false);
  return {setting.key, setting.value, value.is_discarded() ? Json(setting.value) : value};
}

Json to_json(const Member& member) {
  Json settings = Json::array();
  for (const Setting& setting : member.settings) settings.push_back(to_json(setting));
  return {{"name", member.name},
          {"settings", settings},
          {"text", member.text},
          {"cost", member.cost},
          {"sentence", member.sentence}};
}

Json to_json(const analysis::Estimate& estimate) {
  Json json{{"value", estimate.value}};
  if (estimate.half_width) json["half_width"] = *estimate.half_width;
  json["deviation"] = estimate.deviation;
  json["sample"] = estimate.sample;
  return json;
}

/// Answers a request: {"inspect": number of a member, "just_ended": true}, {"mean": values} or {"slope": [x, y]}.
Json answer(const Json& question, const std::vector<Member>& members, const std::string& folder) {
  using Values = std::vector<double>;
  if (question.contains("mean")) return to_json(analysis::mean(question["mean"].get<Values>()));
  if (question.contains("slope"))
    return to_json(analysis::slope(question["slope"][0].get<Values>(), question["slope"][1].get<Values>()));
  const Member& member = members.at(question.at("inspect").get<std::size_t>());
  const std::string path = (std::filesystem::path(folder) / (member.name + ".h5")).string();
  return ensemble::inspect(path, member, question.at("just_ended"));
}

/// Writes a line with the ensemble's properties and one line per member, then answers one request per line.
void serve_ensemble(const EnsembleArguments& request) {
  const Scene scene = read_scene_for(request.scene, request.device, request.settings);
  const std::vector<Member> members = ensemble::make_members(scene, variations_of(request, scene), request.folder);
  const Version version = lichtenberg_version();
  print_json_line({{"version", version.number},
                   {"commit", version.commit},
                   {"mark", ensemble::member_mark},
                   {"devices", devices_of(scene)},
                   {"members", members.size()}});
  for (const Member& member : members) print_json_line(to_json(member));
  answer_questions([&](const Json& question) { return answer(question, members, request.folder); });
}

}  // namespace

Command ensemble_members_command() {
  auto request = std::make_shared<EnsembleArguments>();
  return {"ensemble-members",
          "Makes the members of an ensemble, inspects their results and takes means (commands/ensemble.py)",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           {"--conductors", &request->conductors, "as of ensemble"},
           {"--seeds", &request->seeds, "as of ensemble"},
           {"--vary", &request->vary, "as of ensemble", {.repeated = true}},
           set_argument(request->settings),
           {"--device", &request->device, "as of ensemble"},
           {"--out", &request->folder, "as of ensemble", {.required = true}}},
          [request] { serve_ensemble(*request); }};
}

}  // namespace lichtenberg
