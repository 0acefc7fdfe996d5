#pragma once

#include <string>
#include <vector>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Parses a setting "key=value" of a command line. A value that is no TOML value is a text without its quotes, or a
/// number without digits on one side of the point. Throws InputError if the equals sign or the key is missing.
Setting setting_of(const std::string& written);

/// Splits a list of TOML values, as in "0.4e-3, 0.775e-3", and returns each as text. Floating-point numbers have the
/// fewest digits that give the same number. Throws InputError unless the list has at least one TOML value.
std::vector<std::string> listed_values(const std::string& list);

/// Returns the text of a scene with these keys set: a complete scene, without the comments of `text`. The index of a
/// repeated table may be left out if the scene has one element. Missing tables are added, except for repeated tables
/// and for effects, whose tables decide which effects are computed. Throws InputError for an unknown key, and for a key
/// of an effect or a repeated table that the scene lacks. Values are checked later, by parse_scene. `path`: file of the
/// text, for messages. `kinds`: effects that scenes may have.
std::string with_settings(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                          const EffectKinds& kinds);

/// Throws InputError unless each key of the scene `text`, with these keys set, is known and has the right type and
/// range. Conditions on several keys are left to parse_scene.
void check_values(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                  const EffectKinds& kinds);

}  // namespace lichtenberg
