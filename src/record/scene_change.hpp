#pragma once

#include <string>

namespace lichtenberg {

/// The first key, dotted, at which two scene texts say different things outside of [stop], [output] and [network];
/// empty if there is none. Comments, order and white space do not count. A run may be resumed only if nothing changed:
/// [stop] says when to end, [output] what to write and [network] what to measure in the result, all else decides what
/// happens.
std::string first_change(const std::string& before, const std::string& now);

}  // namespace lichtenberg
