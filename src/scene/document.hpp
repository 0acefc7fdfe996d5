#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "src/scene/vary.hpp"

namespace lichtenberg {

class Schema;

/// Parses the text of a scene file as TOML. Throws InputError that begins with "path:line:" for invalid TOML, and for a
/// key of more than 1000 parts.
toml::table parse_document(const std::string& text, const std::string& path);

/// Converts a TOML value to text, as in [0.04, 0.02] or { potential = "18 kV" }. Floating-point numbers have the fewest
/// digits that give the same number.
std::string shown(const toml::node& node);

/// Sets keys of a TOML document to the values of `settings`, as with_settings (vary.hpp) does. All other values keep
/// their line numbers. Missing tables are added, except for effects and repeated tables. Throws InputError for a key
/// that the schema does not have. Also throws for a key of an effect or a repeated table that the document lacks.
void apply(const std::vector<Setting>& settings, const Schema& schema, toml::table& document);

/// Replaces each file of points, table = "file.csv" in a potential or a current, by its points, so that a scene's text
/// is complete. Names are relative to the folder of the scene's file, `path`. Returns true if it has replaced any.
/// Throws the exceptions of read_points() (signal.hpp), with the line in the scene's file.
bool insert_tables(toml::table& document, const std::string& path);

/// Converts a TOML document to the text of a scene file, without comments.
std::string text_of(const toml::table& document);

}  // namespace lichtenberg
