#pragma once

#include <string>
#include <vector>

namespace lichtenberg {

/// Runs the plot script (plot.py: Python with h5py and matplotlib) with the given arguments and waits for it. The
/// script's own messages go to standard error. Throws InputError if it refuses its input (status 2), Failure if it is
/// not there or fails.
void draw(const std::vector<std::string>& arguments);

}  // namespace lichtenberg
