#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "src/scene/vary.hpp"

namespace lichtenberg {

class Schema;

/// Parses the TOML of a scene. Throws InputError "path:line:column: ..." for invalid TOML.
toml::table parse_document(const std::string& text, const std::string& path);

/// Returns a value as TOML with the fewest digits that give the same number, as in [0.04, 0.02] or { potential = "18
/// kV" }.
std::string shown(const toml::node& node);

/// Sets keys of a document, as with_settings (vary.hpp) does. All other values keep their lines.
void apply(const std::vector<Setting>& settings, const Schema& schema, toml::table& document);

/// Returns a document as the text of a scene file, without comments.
std::string text_of(const toml::table& document);

}  // namespace lichtenberg
