#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace lichtenberg {

/// State from which a run continues as if it had not been interrupted, as named arrays.
struct Checkpoint {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
};

/// Returns the array of that name. Throws Failure if the checkpoint lacks it or has one of another size. The checkpoint
/// then belongs to another scene or another version of the program.
const std::vector<double>& reals(const Checkpoint& checkpoint, const std::string& name, std::size_t size);
const std::vector<std::int64_t>& integers(const Checkpoint& checkpoint, const std::string& name);

}  // namespace lichtenberg
