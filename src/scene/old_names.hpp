#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace lichtenberg {

class Schema;

/// Replaces former names of tables and keys in a document (Table::old_path, Key::old_name) by the present names.
/// Returns one warning for each name. Throws InputError if a table or a key is given under both names. `path`: the
/// file, for messages.
std::vector<std::string> replace_old_names(toml::table& document, const Schema& schema, const std::string& path);

/// Converts the path of a table or key to its present names. In `path`, tables and key may have former names, and
/// elements of repeated tables an index, as in electrode[0].radius.
std::string without_old_names(const std::string& path, const Schema& schema);

/// Returns the warning that a table or key has a new name.
std::string old_name_warning(const std::string& old_path, const std::string& new_path);

}  // namespace lichtenberg
