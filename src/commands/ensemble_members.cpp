#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "solvers/error.hpp"
#include "src/commands/cost.hpp"
#include "src/commands/ensemble.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::ensemble {
namespace {

std::string last_part(const std::string& key) { return key.substr(key.rfind('.') + 1); }

/// Replaces characters that are not allowed in file names: each sequence becomes one underscore.
std::string plain(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool allowed = std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+';
    if (allowed)
      result += c;
    else if (!result.empty() && result.back() != '_')
      result += '_';
  }
  if (result.ends_with('_')) result.pop_back();
  return result;
}

/// Returns a name such as "count-64_seed-1". A key appears by its last part if that is unique.
std::string name_of(const std::vector<Setting>& settings, const std::string& scene_path) {
  std::string name;
  for (const auto& [key, value] : settings) {
    const auto same = std::ranges::count(settings, last_part(key), [](const Setting& s) { return last_part(s.key); });
    name += fmt::format("{}{}-{}", name.empty() ? "" : "_", plain(same > 1 ? key : last_part(key)), plain(value));
  }
  return name.empty() ? std::filesystem::path(scene_path).stem().string() : name;
}

void check_count(const std::vector<Variation>& variations) {
  constexpr double most = 100'000;
  double count = 1;
  for (const Variation& variation : variations) count *= static_cast<double>(variation.values.size());
  if (count > most)
    throw InputError(fmt::format("the ensemble has {:g} members: at most {:g} are allowed", count, most));
}

std::vector<std::vector<Setting>> product(const std::vector<Variation>& variations) {
  std::vector<std::vector<Setting>> all{{}};
  for (const auto& [key, values] : variations) {
    std::vector<std::vector<Setting>> longer;
    for (const std::vector<Setting>& settings : all)
      for (const std::string& value : values) {
        longer.push_back(settings);
        longer.back().push_back({key, value});
      }
    all = std::move(longer);
  }
  return all;
}

/// Adds settings for members. Each field solver uses one thread because members run concurrently; pictures are off.
std::vector<Setting> settings_of_a_member(const Scene& scene, const std::vector<Setting>& varied) {
  std::vector<Setting> settings{{"output.picture", "false"}};
  if (scene.effects.has(&EffectKind::field)) settings.push_back({"field.threads", "1"});
  settings.insert(settings.end(), varied.begin(), varied.end());
  return settings;
}

/// Returns the cost in arbitrary units: field solves times cells.
double cost_of(const Scene& scene) {
  const double cells = scene.field_request() ? 1 : scene.field().cells;
  const FieldSolves unknown{.whole = static_cast<double>(scene.conductors.size())};
  const FieldSolves solves = estimate_field_solves(scene).value_or(unknown);
  return (solves.whole + solves.predictions) * cells * cells;
}

std::string header(const std::string& scene_path, const std::vector<Setting>& varied) {
  std::string text = fmt::format("# {} with", printable(scene_path));  // comments have no control characters
  for (const auto& [key, value] : varied) text += fmt::format(" {} = {},", key, value);
  std::ranges::replace(text, '\n', ' ');
  return fmt::format("{} {}\n", text, member_mark);
}

void check_names(const std::vector<Member>& members) {
  constexpr std::size_t longest = 200;  // below the 255 of file systems, to leave space for suffixes
  std::set<std::string> names;
  for (const Member& member : members)
    if (member.name.size() > longest)
      throw InputError(fmt::format(
          "the file name {}... of a member of the ensemble would have {} characters: at most {} are allowed",
          member.name.substr(0, 40), member.name.size(), longest));
  for (const Member& member : members)
    if (!names.insert(member.name).second)
      throw InputError(
          fmt::format("two members of the ensemble would both have the name {}: leave out values that are given twice",
                      member.name));
}

}  // namespace

std::vector<Member> make_members(const Scene& scene, const std::vector<Variation>& variations,
                                 const std::string& folder) {
  check_count(variations);
  // An invalid value of a key is an error of the command. A member that is invalid only as a whole fails alone.
  for (const auto& [key, values] : variations)
    for (const std::string& value : values) check_values(scene.text, scene.path, {{key, value}});
  std::vector<Member> members;
  for (const std::vector<Setting>& settings : product(variations)) {
    Member member{.name = name_of(settings, scene.path), .settings = settings};
    member.text =
        header(scene.path, settings) + with_settings(scene.text, scene.path, settings_of_a_member(scene, settings));
    try {
      member.cost =
          cost_of(parse_scene(member.text, (std::filesystem::path(folder) / (member.name + ".toml")).string()));
    } catch (const InputError& error) {
      member.sentence = error.what();
    }
    members.push_back(std::move(member));
  }
  check_names(members);
  return members;
}

}  // namespace lichtenberg::ensemble
