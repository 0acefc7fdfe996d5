#pragma once

#include <string>

namespace lichtenberg {

/// Returns the first key, dotted, at which two scene texts differ; empty if there is none. It ignores [stop], [output]
/// and [network], and max_iterations, force_tolerance and threads of [minimize]. Comments, order, white space and
/// former names of keys do not count. A run may be resumed only if no other key has changed, because all others affect
/// its course. The ignored keys determine the end, the output, the measurements and the number of threads.
std::string first_change(const std::string& before, const std::string& now);

}  // namespace lichtenberg
