#pragma once

#include <string>
#include <vector>

namespace lichtenberg {

/// Runs the plot script (plot.py: Python with h5py and matplotlib) with the given arguments, as on its command line,
/// and waits for it. Its messages go to standard error. Throws Failure if it is not there or fails.
void draw(const std::vector<std::string>& arguments);

/// Becomes the plot script: its exit status is the program's. Throws Failure if it cannot be started.
[[noreturn]] void become_plot_script(const std::vector<std::string>& arguments);

}  // namespace lichtenberg
