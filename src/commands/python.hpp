#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"

/// Commands and pictures of the Python package (python/lichtenberg), which runs in a process of its own.
namespace lichtenberg {

/// Those that the package had when this program was built. They become Python once their words are read, after a look
/// at the result files that these name: HDF5 in Python would crash on some damaged ones. Throw InputError for these,
/// Failure if Python cannot be started.
std::vector<Command> python_commands();

/// One that came later, or that stands in a folder of the environment's LICHTENBERG_COMMANDS. Throws Failure if its
/// module cannot be read.
std::optional<Command> added_python_command(const std::string& name);

/// The path of a file as a word that no program takes for an option.
inline std::string as_word(const std::string& path) { return path.starts_with('-') ? "./" + path : path; }

/// Calls a function of the package's pictures, "network.draw_file", with the given words, and waits for it. Its
/// messages go to standard error. Throws Failure if it is not there or fails.
void draw(const std::string& function, std::vector<std::string> words);

/// The picture of a result file. The result is safe, so a picture that cannot be drawn is no reason to fail: standard
/// error says so. Adds the wall time (s) that it takes.
void draw_picture(const std::string& file, double& seconds);

}  // namespace lichtenberg
