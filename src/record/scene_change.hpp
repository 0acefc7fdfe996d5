#pragma once

#include <string>

namespace lichtenberg {

/// The first key, dotted, at which two scene texts say different things outside of [stop] and [output]; empty if there
/// is none. Comments, order and white space do not count. A run may be resumed only if nothing changed: [stop] says
/// when to end and [output] what to write, all else decides what happens.
std::string first_change(const std::string& before, const std::string& now);

}  // namespace lichtenberg
