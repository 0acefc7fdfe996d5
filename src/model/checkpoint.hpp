#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace lichtenberg {

/// All that a run needs to go on from an instant as if it had never stopped, as named arrays.
struct Checkpoint {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
};

/// The array of that name. Throws Failure if the checkpoint has none, or one of another size: it is then of another
/// scene or another version of the program.
const std::vector<double>& reals(const Checkpoint& checkpoint, const std::string& name, std::size_t size);
const std::vector<std::int64_t>& integers(const Checkpoint& checkpoint, const std::string& name);

}  // namespace lichtenberg
