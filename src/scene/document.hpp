#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "src/scene/vary.hpp"

namespace lichtenberg {

class Schema;

/// Parses the text of a scene file as TOML. Throws InputError "path:line:column: ..." for invalid TOML.
toml::table parse_document(const std::string& text, const std::string& path);

/// Converts a TOML value to text, as in [0.04, 0.02] or { potential = "18 kV" }. Numbers have the fewest digits that
/// give the same number.
std::string shown(const toml::node& node);

/// Sets keys of a TOML document to the values of `settings`, as with_settings (vary.hpp) does. All other values keep
/// their line numbers. Throws InputError for a key that the schema does not have or whose table the document lacks.
void apply(const std::vector<Setting>& settings, const Schema& schema, toml::table& document);

/// Converts a TOML document to the text of a scene file, without comments.
std::string text_of(const toml::table& document);

}  // namespace lichtenberg
