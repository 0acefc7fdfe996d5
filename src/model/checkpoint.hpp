#pragma once

#include <string>
#include <vector>

#include "src/model/frame.hpp"

namespace lichtenberg {

/// The array of that name. Throws Failure if the checkpoint has none, or one of another size: it is then of another
/// scene or another version of the program.
const std::vector<double>& reals(const Checkpoint& checkpoint, const std::string& name, std::size_t size);
const std::vector<std::int64_t>& integers(const Checkpoint& checkpoint, const std::string& name);

}  // namespace lichtenberg
