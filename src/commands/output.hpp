#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/geometry/vec.hpp"
#include "src/commands/streams.hpp"
#include "src/record/atomic_file.hpp"

namespace lichtenberg {

/// Throws InputError if the file that `option` names cannot be written, or exists and may not be overwritten. Call it
/// before the work.
inline void check_output(const std::string& option, const std::string& path, bool overwrite) {
  check_writable(path);
  if (!overwrite && std::filesystem::exists(path))
    throw InputError(fmt::format("the file {} exists: give {} another name, or give --overwrite", path, option));
}

/// Throws InputError unless the file name that `option` gives ends in .png, .pdf or .svg.
inline void check_picture(const std::string& option, const std::string& path) {
  const std::string format = std::filesystem::path(path).extension();
  if (format != ".png" && format != ".pdf" && format != ".svg")
    throw InputError(fmt::format("option {} {}: the picture's name must end in .png, .pdf or .svg", option, path));
}

/// Returns the first `dimension` components of a vector.
inline std::vector<double> components(Vec3 vector, int dimension = 3) {
  const std::vector<double> all = {vector.x, vector.y, vector.z};
  return {all.begin(), all.begin() + dimension};
}

/// Formats numbers as columns of a table, each with `format`.
inline std::string columns_of(const std::vector<double>& numbers, const char* format) {
  std::string text;
  for (const double number : numbers) text += fmt::format(fmt::runtime(format), number);
  return text;
}

/// Prints warnings as one block on standard error; nothing if there are none.
inline void print_warnings(const std::vector<std::string>& warnings) {
  std::fflush(stdout);
  const char* label = "WARNING";
  for (const std::string& warning : warnings)
    fmt::print(stderr, "{:<15}{}\n", std::exchange(label, ""), printable(warning));
}

}  // namespace lichtenberg
