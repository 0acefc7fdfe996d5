#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "src/scene/vary.hpp"

/// Functions for the Python command ensemble (python/lichtenberg/commands/ensemble.py).
namespace lichtenberg::ensemble {

/// A key of the scene that an ensemble varies, with its values, each as a TOML text.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// One scene of an ensemble: the base scene with its own values of the varied keys.
struct Member {
  std::string name;               ///< base name of its files: "count-64_seed-1"
  std::vector<Setting> settings;  ///< in the order of the variations
  std::string text;               ///< scene file
  double cost = 1;                ///< expected cost in arbitrary units
  std::string sentence;           ///< reason why its scene is invalid; empty if it is valid
};

/// Makes the members of an ensemble: all combinations of the variations of a scene. The last variation varies fastest.
/// `folder`: folder of the members' files. A member whose scene is invalid only as a whole gets the reason as its
/// `sentence`. Throws InputError for invalid keys and values, too many members, and names that are too long or equal.
std::vector<Member> make_members(const Scene& scene, const std::vector<Variation>& variations,
                                 const std::string& folder);

/// Text at the end of the first line of a member's scene file, which marks it as written by an ensemble.
constexpr std::string_view member_mark = "as a member of an ensemble (`lichtenberg ensemble`)";

/// Determines the state of a member's result file: "waiting" (to be resumed), "finished" or "failed". A finished run
/// comes with "quantities" and "warnings". A failed one comes with a `sentence` (the reason): the file is damaged,
/// belongs to another scene or is past the present [stop]. `just_ended`: its run used the present [stop], even if the
/// file contains the [stop] of its start.
nlohmann::ordered_json inspect(const std::string& path, const Member& member, bool just_ended);

}  // namespace lichtenberg::ensemble
