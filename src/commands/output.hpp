#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "solvers/error.hpp"
#include "src/record/atomic_file.hpp"

namespace lichtenberg {

/// Before the work, not after it: throws InputError if the file that `option` names cannot be written, or exists and
/// must not be replaced.
inline void check_output(const std::string& option, const std::string& path, bool overwrite) {
  check_writable(path);
  if (!overwrite && std::filesystem::exists(path))
    throw InputError(fmt::format("{} exists: give {} another name, or allow --overwrite", path, option));
}

/// Throws InputError unless a script can draw into a file of this name.
inline void check_picture(const std::string& option, const std::string& path) {
  const std::string format = std::filesystem::path(path).extension();
  if (format != ".png" && format != ".pdf" && format != ".svg")
    throw InputError(fmt::format("{} {}: the picture's name must end in .png, .pdf or .svg", option, path));
}

}  // namespace lichtenberg
