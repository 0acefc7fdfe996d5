#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"

/// Commands and pictures of the Python package (python/lichtenberg), which runs in its own process.
namespace lichtenberg {

/// Returns the commands of the Python package that were known at build time. Each checks the result files that it
/// names, because HDF5 in Python would crash on some damaged ones, and then replaces this process by Python. They throw
/// InputError for damaged files, PETSc options and several processes (mpirun). They throw Failure if the package is
/// missing or Python cannot be started.
std::vector<Command> python_commands();

/// Finds a command of this name that was added to the Python package after the build. It may also be in a folder of the
/// environment variable LICHTENBERG_COMMANDS. Empty if there is none. Throws Failure if its module cannot be read.
std::optional<Command> added_python_command(const std::string& name);

/// Returns the path in a form that no program reads as an option: "./" precedes a leading dash.
inline std::string as_word(const std::string& path) { return path.starts_with('-') ? "./" + path : path; }

/// Calls a drawing function of the Python package, such as "network.draw_file", with these words as arguments, and
/// waits for it. Throws Failure if the function does not exist or fails.
void draw(const std::string& function, std::vector<std::string> words);

/// Draws the picture of a result file by Python. If that fails, prints a message on standard error, because the result
/// is complete. Adds the wall time (s) to `seconds`.
void draw_picture(const std::string& file, double& seconds);

}  // namespace lichtenberg
