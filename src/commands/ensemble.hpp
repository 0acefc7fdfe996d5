#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "src/scene/vary.hpp"

/// What the Python command ensemble (python/lichtenberg/commands/ensemble.py) asks the program for.
namespace lichtenberg::ensemble {

/// A key of the scene, and the values that it takes over the ensemble, each as a scene file has it.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// One scene of the ensemble.
struct Member {
  std::string name;               ///< of its files, without the suffix: "count-64_seed-1"
  std::vector<Setting> settings;  ///< in the order of the variations
  std::string text;               ///< the scene
  double cost = 1;                ///< time that it is expected to take, in a unit of the ensemble's own
  std::string sentence;           ///< why its scene is impossible, if it is
};

/// The product of the variations of a scene with some keys `set`, the last varying fastest. Throws InputError for keys
/// and values that no scene has.
std::vector<Member> make_members(const std::string& scene_path, const std::vector<Setting>& set,
                                 const std::vector<Variation>& variations, const std::string& folder);

/// What the first line of a member's scene file ends with.
constexpr std::string_view member_mark = "as a member of an ensemble (`lichtenberg ensemble`)";

/// What the member's result file holds: its "state" is waiting (to be resumed), finished, with "quantities" and
/// "warnings", or failed, because it is of another scene or damaged, with a "sentence". `just_ended`: its run was given
/// the [stop] of now, even if its file still has that of its start.
nlohmann::ordered_json inspect(const std::string& path, const Member& member, bool just_ended);

}  // namespace lichtenberg::ensemble
