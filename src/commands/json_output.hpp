#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace lichtenberg {

/// Throws InputError if this file to write is one of those that are read, by whatever name. Empty ones are none.
void check_not_read(const std::string& file, const std::vector<std::string>& read);

/// Throws InputError if one of these files (those without a name are not asked for) cannot be written, is another one
/// of them or one of those that are read, or would take the place of a result or of what is no plain file, or of any
/// other file unless these may be overwritten.
void check_outputs(const std::vector<std::string>& written, const std::vector<std::string>& read, bool overwrite);

/// Whole or not at all. Throws Failure if the disk does not take it.
void write_json(const std::string& path, const nlohmann::ordered_json& json);

/// Has a script of this folder draw what the JSON holds into a picture, and says so. Throws Failure if it does not: all
/// else that was asked for is to be done before.
void draw_json(const std::string& script, const nlohmann::ordered_json& json, const std::string& picture);

}  // namespace lichtenberg
