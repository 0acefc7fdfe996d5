#pragma once

#include <string>
#include <vector>

namespace lichtenberg {

/// The path of a file as a word that no program takes for an option.
inline std::string as_word(const std::string& path) { return path.starts_with('-') ? "./" + path : path; }

/// Runs a script of this folder (Python with matplotlib, plot.py also with h5py) with the given arguments, as on its
/// command line, and waits for it. Its messages go to standard error. Throws Failure if it is not there or fails.
void draw(const std::string& script, const std::vector<std::string>& arguments);

/// The picture of a result file. The result is safe, so a picture that cannot be drawn is no reason to fail: standard
/// error says so. Adds the wall time (s) that it takes.
void draw_picture(const std::string& file, double& seconds);

/// Becomes the script: its exit status is the program's. Throws Failure if it cannot be started.
[[noreturn]] void become_script(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace lichtenberg
