#pragma once

#include <string>

#include <toml++/toml.h>

namespace lichtenberg {

/// The TOML of a scene. Throws InputError "path:line:column: ..." if it is none.
toml::table parse_document(const std::string& text, const std::string& path);

/// A value in the fewest digits that mean the same, as in [0.04, 0.02] or { potential = "18 kV" }.
std::string shown(const toml::node& node);

}  // namespace lichtenberg
