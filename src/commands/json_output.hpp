#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// Throws InputError if this file to write is one of those that are read, by whatever name. Empty ones are none.
void check_not_read(const std::string& file, const std::vector<std::string>& read);

/// Throws InputError if two of the files are one, by whatever paths; empty names are left out.
void check_different(const std::vector<std::string>& written);

/// Throws InputError if one of these files (those without a name are not asked for) cannot be written, is another one
/// of them or one of those that are read, or would take the place of a result or of what is no plain file, or of any
/// other file unless these may be overwritten.
void check_outputs(const std::vector<std::string>& written, const std::vector<std::string>& read, bool overwrite);

/// Throws InputError if files may be overwritten and none of these is to be written. `options`: those that write some,
/// in words.
void check_overwrite(bool overwrite, const std::vector<std::string>& written, const std::string& options);

/// Target of `--json[=FILE]`: JSON on standard output in place of a table, or in a file beside the table.
struct JsonTarget {
  std::string word;  ///< empty: no JSON, "true": printed, else the file

  bool printed() const { return word == "true"; }
  std::string file() const { return printed() ? "" : word; }
  /// Writes the JSON, if any was asked for. Throws Failure if it cannot be written.
  void put(const nlohmann::ordered_json& json, int indent) const;
};

/// The option itself; `what` it holds. `file_follows`: the next word is the FILE even if it does not end in .json, as
/// earlier versions had it.
Argument json_argument(JsonTarget& target, const std::string& what, bool file_follows = false);

/// Whole or not at all. Throws Failure if the disk does not take it.
void write_json(const std::string& path, const nlohmann::ordered_json& json);

/// For the Python package (questions.py), which reads and writes a line of JSON at a time.
void tell(const nlohmann::ordered_json& json);
/// Tells the answer to each line of standard input, to its end.
void answer_questions(const std::function<nlohmann::ordered_json(const nlohmann::ordered_json& question)>& answer);

/// Has a `function` of python.hpp draw what the JSON holds into a picture, and says so unless `silently`. Throws
/// Failure if it does not: all else that was asked for is to be done before.
void draw_json(const std::string& function, const nlohmann::ordered_json& json, const std::string& picture,
               bool silently = false);

}  // namespace lichtenberg
