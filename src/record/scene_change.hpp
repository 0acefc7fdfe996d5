#pragma once

#include <string>

namespace lichtenberg {

/// The first key, dotted, at which two scene texts say different things outside of [stop], [output], [network] and of
/// [minimize]'s max_iterations, force_tolerance and threads; empty if there is none. Comments, order and white space do
/// not count. A run may be resumed only if nothing changed: those say when to end, what to write, what to measure in
/// the result and who computes, all else decides what happens.
std::string first_change(const std::string& before, const std::string& now);

}  // namespace lichtenberg
