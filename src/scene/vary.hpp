#pragma once

#include <string>
#include <vector>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// A setting as a command line has it, "key=value"; a value that TOML does not know is a text without its quotes.
/// Throws InputError.
Setting setting_of(const std::string& written);

/// The values of a list, as in "0.4e-3, 0.775e-3": each in the fewest digits that mean the same. Throws InputError
/// unless it is at least one value of TOML.
std::vector<std::string> listed_values(const std::string& list);

/// The scene `text` with these keys set: a whole scene, without the comments. The index of a repeated table may be left
/// out where the scene has one. Tables are added where they are missing, but for effects: their tables decide what is
/// computed. Throws InputError for a key that no scene has or that this one has no place for; what the value may be is
/// left to parse_scene. `path` is used in messages about the text, `kinds` are the effects that scenes may have.
std::string with_settings(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                          const EffectKinds& kinds);

/// Throws InputError unless each key of the scene `text`, with these keys set, is of its type and in its range. What
/// depends on several keys is left to parse_scene.
void check_values(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                  const EffectKinds& kinds);

}  // namespace lichtenberg
