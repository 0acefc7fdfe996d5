#pragma once

#include <string>
#include <vector>

namespace lichtenberg {

/// Runs a script of this folder (Python with matplotlib, plot.py also with h5py) with the given arguments, as on its
/// command line, and waits for it. Its messages go to standard error. Throws Failure if it is not there or fails.
void draw(const std::string& script, const std::vector<std::string>& arguments);

/// Becomes the script: its exit status is the program's. Throws Failure if it cannot be started.
[[noreturn]] void become_script(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace lichtenberg
