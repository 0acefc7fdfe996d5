#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "src/scene/vary.hpp"

/// Functions for the Python command ensemble (python/lichtenberg/commands/ensemble.py).
namespace lichtenberg::ensemble {

/// Key of the scene with its values over the ensemble, each as a TOML text.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// One scene of the ensemble.
struct Member {
  std::string name;               ///< base name of its files: "count-64_seed-1"
  std::vector<Setting> settings;  ///< in the order of the variations
  std::string text;               ///< scene file
  double cost = 1;                ///< expected cost in arbitrary units
  std::string sentence;           ///< reason why its scene is invalid; empty if it is valid
};

/// Returns the product of the variations of a scene; the last variation varies fastest. Throws InputError for invalid
/// keys and values.
std::vector<Member> make_members(const Scene& scene, const std::vector<Variation>& variations,
                                 const std::string& folder);

/// End of the first line of a member's scene file.
constexpr std::string_view member_mark = "as a member of an ensemble (`lichtenberg ensemble`)";

/// Returns the state of the member's result file: "waiting" (to be resumed), "finished" or "failed". The second comes
/// with "quantities" and "warnings". The last comes with a `sentence` (its reason), if the file is damaged or belongs
/// to another scene. `just_ended`: its run used the present [stop], even if the file holds that of its start.
nlohmann::ordered_json inspect(const std::string& path, const Member& member, bool just_ended);

}  // namespace lichtenberg::ensemble
