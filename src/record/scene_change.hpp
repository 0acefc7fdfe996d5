#pragma once

#include <string>

namespace lichtenberg {

/// Compares two scene texts and returns the path of the first key or table that differs, in alphabetical order; empty
/// if none does. Comments, order, white space and former names of keys do not count. The keys of [stop], [output] and
/// [network], and max_iterations, force_tolerance and threads of [minimize], are ignored. They determine the end, the
/// output, the measurements and the number of threads. A run may be resumed only if no other key has changed, because
/// another key may affect its course. Throws InputError for a text that is no TOML; `path_before` names the first one.
std::string first_change(const std::string& before, const std::string& now,
                         const std::string& path_before = "scene/text");

}  // namespace lichtenberg
