#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// Throws InputError if the file to write is one of the files read, under any path. Empty names are skipped.
void check_not_read(const std::string& file, const std::vector<std::string>& read);

/// Throws InputError if two of the names mean the same file, under any paths. Empty names are skipped.
void check_different(const std::vector<std::string>& written);

/// Checks files to be written, before the work; empty names are skipped. Throws InputError if one cannot be written, or
/// equals another one or a file that is read. Also throws if one would replace a scene (.toml), a result or something
/// other than a plain file. Without `overwrite` it throws for any existing file.
void check_outputs(const std::vector<std::string>& written, const std::vector<std::string>& read, bool overwrite);

/// Throws InputError if `overwrite` is set and `written`, the names of files to be written, is empty. `options`: names
/// of the command's options that write files, for the message.
void check_overwrite(bool overwrite, const std::vector<std::string>& written, const std::string& options);

/// Target of the option `--json[=FILE]`: JSON on standard output instead of a table, or in a file in addition to the
/// table.
struct JsonTarget {
  std::string word;  ///< empty: no JSON; "true": standard output; otherwise the file

  /// Returns true if the JSON goes to standard output.
  bool printed() const { return word == "true"; }
  /// Returns the file that receives the JSON; empty if there is none.
  std::string file() const { return printed() ? "" : word; }
  /// Writes the JSON to its target if requested. `indent`: spaces per level on standard output. Throws Failure if the
  /// file cannot be written.
  void put(const nlohmann::ordered_json& json, int indent) const;
};

/// Makes the argument `--json`. `what`: contents of the JSON, for the help.
Argument json_argument(JsonTarget& target, const std::string& what);

/// Writes JSON to the file at `path`, completely or not at all. Throws Failure if the write fails.
void write_json(const std::string& path, const nlohmann::ordered_json& json);

/// Prints one line of JSON on standard output, for the Python package (questions.py).
void print_json_line(const nlohmann::ordered_json& json);
/// Reads JSON requests from standard input until its end, one per line, and prints the result of `answer` for each.
void answer_questions(const std::function<nlohmann::ordered_json(const nlohmann::ordered_json& question)>& answer);

/// Draws JSON into a picture by a `function` of the Python package (python.hpp). Prints a message unless `silently`.
/// Throws Failure if that fails; therefore other outputs must be written first.
void draw_json(const std::string& function, const nlohmann::ordered_json& json, const std::string& picture,
               bool silently = false);

}  // namespace lichtenberg
